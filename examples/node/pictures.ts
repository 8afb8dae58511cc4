/** JPEG and PNG files in, upright by EXIF, on white where transparent; masks out as PNG. */

import exifr from "exifr";
import jpeg from "jpeg-js";
import { PNG } from "pngjs";
import type { Size } from "../web/src/core/resize";
import type { Picture } from "./ground-finder";

const JPEG_START = 0xffd8;

/** Decodes a file's bytes. */
export async function decode(file: Buffer): Promise<Picture> {
  const isJpeg = file.readUInt16BE(0) === JPEG_START;
  const { data, width, height } = isJpeg
    ? jpeg.decode(file, { maxMemoryUsageInMB: 1024 })
    : PNG.sync.read(file);
  const picture = { rgba: onWhite(data), width, height };
  const orientation = isJpeg ? ((await exifr.orientation(file)) ?? 1) : 1;
  return upright(picture, orientation);
}

/** The 35 mm equivalent focal length that a file states, in millimetres; null if it states none. */
export async function focalLength35mm(file: Buffer): Promise<number | null> {
  const tags = await exifr.parse(file, ["FocalLengthIn35mmFormat"]).catch(() => undefined);
  return tags?.FocalLengthIn35mmFormat || null;
}

/** @param mask 1 for white, 0 for black. */
export function encodeMask(mask: Uint8Array, { height, width }: Size): Buffer {
  const grey = { colorType: 0, inputColorType: 0, inputHasAlpha: false } as const;
  const png = new PNG({ width, height, ...grey });
  png.data = Buffer.from(mask.map((value) => value * 255));
  return PNG.sync.write(png, grey);
}

function onWhite(rgba: Uint8Array): Uint8Array {
  return rgba.map((value, i) => {
    const alpha = rgba[i | 3];
    return (i & 3) === 3 ? 255 : Math.round((value * alpha + 255 * (255 - alpha)) / 255);
  });
}

/** Turns a picture by its EXIF orientation, 1 to 8. */
function upright({ rgba, width, height }: Picture, orientation: number): Picture {
  if (orientation < 2 || orientation > 8) return { rgba, width, height };
  const [isTurned, fromRight, fromBottom] = [
    orientation > 4,
    [2, 3, 7, 8].includes(orientation),
    [3, 4, 6, 7].includes(orientation),
  ];
  const size = isTurned ? { width: height, height: width } : { width, height };
  const source = new Uint32Array(rgba.buffer, rgba.byteOffset, width * height);
  const result = new Uint32Array(width * height);
  for (let y = 0, i = 0; y < size.height; y++) {
    for (let x = 0; x < size.width; x++, i++) {
      const [column, row] = isTurned ? [y, x] : [x, y];
      const from = fromRight ? width - 1 - column : column;
      result[i] = source[(fromBottom ? height - 1 - row : row) * width + from];
    }
  }
  return { ...size, rgba: new Uint8Array(result.buffer) };
}

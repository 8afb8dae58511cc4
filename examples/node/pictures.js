/** JPEG and PNG files in, upright by EXIF; masks out as PNG. */

import exifr from "exifr";
import { readLens } from "footprints-edge";
import jpeg from "jpeg-js";
import { PNG } from "pngjs";

const JPEG_START = 0xffd8;

/**
 * Decodes a file's bytes to what `predict` takes, four bytes a pixel, and to what they say of the lens.
 *
 * @param {Buffer} file
 */
export async function decode(file) {
  if (file.readUInt16BE(0) !== JPEG_START) return { picture: PNG.sync.read(file), lens: null };
  const stored = jpeg.decode(file, { maxMemoryUsageInMB: 1024 });
  const picture = upright(stored, (await exifr.orientation(file)) ?? 1);
  return { picture, lens: readLens(Uint8Array.from(file).buffer) };
}

/** A mask, 1 for white, 0 for black, as PNG. */
export function encodeMask(mask, { height, width }) {
  const grey = { colorType: 0, inputColorType: 0, inputHasAlpha: false };
  const png = new PNG({ width, height, ...grey });
  png.data = Buffer.from(mask.map((value) => value * 255));
  return PNG.sync.write(png, grey);
}

/** Turns a picture by its EXIF orientation, 1 to 8. */
function upright({ data, width, height }, orientation) {
  if (orientation < 2 || orientation > 8) return { data, width, height };
  const isTurned = orientation > 4;
  const fromRight = [2, 3, 7, 8].includes(orientation);
  const fromBottom = [3, 4, 6, 7].includes(orientation);
  const size = isTurned ? { width: height, height: width } : { width, height };
  const source = new Uint32Array(data.buffer, data.byteOffset, width * height);
  const result = new Uint32Array(width * height);
  for (let y = 0, i = 0; y < size.height; y++) {
    for (let x = 0; x < size.width; x++, i++) {
      const [column, row] = isTurned ? [y, x] : [x, y];
      const from = fromRight ? width - 1 - column : column;
      result[i] = source[(fromBottom ? height - 1 - row : row) * width + from];
    }
  }
  return { ...size, data: new Uint8Array(result.buffer) };
}

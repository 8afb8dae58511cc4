/** Decoded pixels as a picture. */

import { ImageError } from "../errors.ts";
import type { Pixels, Size } from "../foundation/types.ts";
import { UNKNOWN_LENS, type Lens } from "./lens.ts";

/** An upright picture, and what its file says about the lens. */
export interface DecodedImage extends Pixels, Lens {
  /** Size of the picture; its pixels here are fewer if it was too large to be read as a whole. */
  imageSize: Size;
}

/** Whether something looks like decoded pixels: `ImageData`, or an object of its shape. */
export function isPixels(source: unknown): source is Pixels {
  const given = source as Partial<Pixels> | null;
  return (
    typeof given === "object" &&
    given !== null &&
    ArrayBuffer.isView(given.data) &&
    typeof given.width === "number" &&
    typeof given.height === "number"
  );
}

/**
 * Checks decoded pixels; what is transparent becomes white.
 *
 * @throws ImageError If there are not three or four bytes for each pixel.
 */
export function decodedPixels({ data, width, height }: Pixels): DecodedImage {
  if (!(Number.isInteger(width) && Number.isInteger(height) && width > 0 && height > 0)) {
    throw new ImageError(`the picture is ${width} x ${height} pixels; both sides need at least 1`);
  }
  if (!(data instanceof Uint8Array || data instanceof Uint8ClampedArray)) {
    throw new ImageError(`the picture's data are a ${(data as object).constructor.name}; give bytes from 0 to 255`);
  }
  const channels = data.length / (width * height);
  if (channels !== 3 && channels !== 4) {
    throw new ImageError(
      `a picture of ${width} x ${height} pixels has ${data.length} bytes; give 3 (RGB) or 4 (RGBA) for ` +
        "each pixel, row by row",
    );
  }
  return {
    data: channels === 4 ? onWhite(data) : data,
    width,
    height,
    imageSize: { height, width },
    ...UNKNOWN_LENS,
  };
}

function onWhite(rgba: Pixels["data"]): Pixels["data"] {
  let isOpaque = true;
  for (let i = 3; i < rgba.length && isOpaque; i += 4) isOpaque = rgba[i] === 255;
  if (isOpaque) return rgba;
  return rgba.map((value, i) => {
    const alpha = rgba[i | 3];
    return (i & 3) === 3 ? 255 : Math.round((value * alpha + 255 * (255 - alpha)) / 255);
  });
}

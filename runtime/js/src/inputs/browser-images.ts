/** Pictures as browsers have them. */

import { ImageError } from "../errors.ts";
import type { Pixels } from "../foundation/types.ts";
import { readLens, UNKNOWN_LENS } from "./lens.ts";
import { decodedPixels, isPixels, type DecodedImage } from "./pixels.ts";

/** A file, its bytes, decoded pixels (`ImageData`), or whatever a canvas can draw. */
export type ImageSource = Blob | ArrayBuffer | Uint8Array | Pixels | ImageBitmapSource;

/** Larger pictures are scaled down before they are read: phones refuse larger canvases. */
const MOST_CANVAS_PX = 4096 * 4096;

/** What is said of the lens stands at the beginning of a file. */
const LENS_BYTES = 2 ** 24;

/**
 * Decodes a picture, upright.
 *
 * @throws ImageError If it is none that this browser can read.
 */
export async function decodeImage(source: ImageSource): Promise<DecodedImage> {
  if (isPixels(source)) return decodedPixels(source);
  const isBytes = source instanceof ArrayBuffer || source instanceof Uint8Array;
  const drawable = isBytes ? new Blob([source as BlobPart]) : source;
  const lens =
    drawable instanceof Blob ? readLens(await drawable.slice(0, LENS_BYTES).arrayBuffer()) : UNKNOWN_LENS;
  let bitmap: ImageBitmap;
  try {
    bitmap =
      drawable instanceof ImageBitmap
        ? drawable
        : // Colours as they are in the file: that is what the network was trained on.
          await createImageBitmap(drawable as ImageBitmapSource, {
            imageOrientation: "from-image",
            colorSpaceConversion: "none",
          });
  } catch (error) {
    const reason = error instanceof Error ? error.message : String(error);
    throw new ImageError(`this is not a picture that this browser can read: ${reason}`, { cause: error });
  }
  try {
    const { data, width, height } = readPixels(bitmap);
    const imageSize = { height: bitmap.height, width: bitmap.width };
    return { data, width, height, imageSize, ...lens };
  } finally {
    if (bitmap !== drawable) bitmap.close();
  }
}

let canvas: OffscreenCanvas | undefined;

/** The picture's pixels; what is transparent becomes white. */
function readPixels(picture: ImageBitmap): ImageData {
  const shrink = Math.min(1, Math.sqrt(MOST_CANVAS_PX / (picture.width * picture.height)));
  const width = Math.max(1, Math.floor(picture.width * shrink));
  const height = Math.max(1, Math.floor(picture.height * shrink));
  canvas ??= new OffscreenCanvas(width, height);
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) throw new ImageError("this browser gives no canvas to read the picture with");
  context.fillStyle = "white";
  context.fillRect(0, 0, width, height);
  context.drawImage(picture, 0, 0, width, height);
  return context.getImageData(0, 0, width, height);
}

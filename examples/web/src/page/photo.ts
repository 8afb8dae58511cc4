/** Pictures from files. */

import { readLens, type Lens } from "footprints-edge";

/** What is said of the lens stands at the beginning of a file. */
const LENS_BYTES = 2 ** 24;

export interface Photo {
  picture: ImageBitmap;
  /** What the file says; null for a frame of the camera. */
  lens: Lens | null;
}

/**
 * Decodes a picture and turns it upright.
 *
 * @throws Error If the browser cannot read it; the message is for people.
 */
export async function readPhoto(file: Blob, name: string): Promise<Photo> {
  const head = await file.slice(0, LENS_BYTES).arrayBuffer();
  try {
    // Colours as they are in the file: that is what the network was trained on.
    const picture = await createImageBitmap(file, {
      imageOrientation: "from-image",
      colorSpaceConversion: "none",
    });
    return { picture, lens: readLens(head) };
  } catch {
    throw new Error(`${name} is not a picture that this browser can read. Choose a JPEG or PNG.`);
  }
}

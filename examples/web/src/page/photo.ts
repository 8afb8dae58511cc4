/** Pictures from files. */

import { focalLength35mm } from "footprints-edge";

/** EXIF blocks come first in a file and are at most 64 KiB long. */
const EXIF_BYTES = 2 ** 17;

export interface Photo {
  picture: ImageBitmap;
  /** 35 mm equivalent focal length in millimetres; null if the file states none. */
  focal35mm: number | null;
}

/**
 * Decodes a picture and turns it upright.
 *
 * @throws Error If the browser cannot read it; the message is for people.
 */
export async function readPhoto(file: Blob, name: string): Promise<Photo> {
  const head = await file.slice(0, EXIF_BYTES).arrayBuffer();
  try {
    // Colours as they are in the file: that is what the network was trained on.
    const picture = await createImageBitmap(file, {
      imageOrientation: "from-image",
      colorSpaceConversion: "none",
    });
    return { picture, focal35mm: focalLength35mm(head) };
  } catch {
    throw new Error(`${name} is not a picture that this browser can read. Choose a JPEG or PNG.`);
  }
}

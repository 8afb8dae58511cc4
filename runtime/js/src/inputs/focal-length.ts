/** The 35 mm equivalent focal length that a JPEG file states in its EXIF block. */

const EXIF_BLOCK = 0xffe1;
const START_OF_SCAN = 0xffda;
const EXIF_POINTER = 0x8769;
const FOCAL_LENGTH_IN_35MM = 0xa405;

/**
 * Reads the focal length of a JPEG file.
 *
 * @param file The file's bytes; the first 64 KiB or so are enough.
 * @returns Millimetres; null if the file is no JPEG, states none, or its EXIF block is broken.
 */
export function focalLength35mm(file: ArrayBuffer): number | null {
  try {
    const view = new DataView(file);
    if (view.getUint16(0) !== 0xffd8) return null;
    let at = 2;
    while (view.getUint16(at) !== START_OF_SCAN) {
      const length = view.getUint16(at + 2);
      const isExif = view.getUint16(at) === EXIF_BLOCK && view.getUint32(at + 4) === 0x45786966;
      if (isExif) return fromTiff(new DataView(file, at + 10, length - 8));
      at += 2 + length;
    }
    return null;
  } catch (error) {
    if (error instanceof RangeError) return null; // a broken block says nothing
    throw error;
  }
}

function fromTiff(tiff: DataView): number | null {
  const little = tiff.getUint16(0) === 0x4949;
  const find = (folder: number, tag: number): number | null => {
    const entries = tiff.getUint16(folder, little);
    for (let i = 0; i < entries; i++) {
      const entry = folder + 2 + 12 * i;
      if (tiff.getUint16(entry, little) === tag) return entry + 8;
    }
    return null;
  };
  const pointer = find(tiff.getUint32(4, little), EXIF_POINTER);
  if (pointer === null) return null;
  const focal = find(tiff.getUint32(pointer, little), FOCAL_LENGTH_IN_35MM);
  return (focal === null ? 0 : tiff.getUint16(focal, little)) || null; // 0 stands for unknown
}

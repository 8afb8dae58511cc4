/** The 35 mm equivalent focal length that a JPEG file states in its EXIF block. */

const EXIF_BLOCK = 0xffe1;
const START_OF_SCAN = 0xffda;
const EXIF_POINTER = 0x8769;
const MAKE = 0x10f;
const DIGITAL_ZOOM = 0xa404;
const FOCAL_LENGTH_IN_35MM = 0xa405;
const [SHORT, LONG, RATIONAL] = [3, 4, 5];

/** Millimetres; a focal length outside of it counts as not stated. No lens is there. */
const [SHORTEST_MM, LONGEST_MM] = [4, 5000];

/** A digital zoom above it counts as not stated. */
const FARTHEST_ZOOM = 200;

/**
 * Reads the focal length of a JPEG file. Digital zoom lengthens it, as it narrows the view.
 *
 * @param file The file's bytes; the first 64 KiB or so are enough.
 * @returns Millimetres; null if the file is no JPEG, states none that a lens can have, or its EXIF block is
 *   broken.
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
  /** Where the entry of a tag begins. */
  const find = (folder: number, tag: number): number | null => {
    const entries = tiff.getUint16(folder, little);
    for (let i = 0; i < entries; i++) {
      const entry = folder + 2 + 12 * i;
      if (tiff.getUint16(entry, little) === tag) return entry;
    }
    return null;
  };
  const numberOf = (folder: number, tag: number): number => {
    const entry = find(folder, tag);
    if (entry === null) return 0;
    const type = tiff.getUint16(entry + 2, little);
    if (type === SHORT) return tiff.getUint16(entry + 8, little);
    const value = tiff.getUint32(entry + 8, little);
    if (type === LONG) return value;
    return type === RATIONAL ? tiff.getUint32(value, little) / tiff.getUint32(value + 4, little) : 0;
  };
  const main = tiff.getUint32(4, little);
  const exif = numberOf(main, EXIF_POINTER);
  if (exif === 0) return null;
  const focalMm = numberOf(exif, FOCAL_LENGTH_IN_35MM); // 0 stands for unknown
  if (!(focalMm >= SHORTEST_MM && focalMm <= LONGEST_MM)) return null;
  const make = find(main, MAKE);
  if (make !== null && startsWithApple(tiff, make, little)) return focalMm; // that of what is left
  const zoom = numberOf(exif, DIGITAL_ZOOM); // 0 stands for none
  return zoom > 1 && zoom <= FARTHEST_ZOOM ? focalMm * zoom : focalMm;
}

function startsWithApple(tiff: DataView, entry: number, little: boolean): boolean {
  if (tiff.getUint32(entry + 4, little) < 5) return false; // letters
  const at = tiff.getUint32(entry + 8, little);
  return [..."Apple"].every((letter, i) => tiff.getUint8(at + i) === letter.charCodeAt(0));
}

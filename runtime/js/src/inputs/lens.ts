/** What a JPEG file says of its lens: EXIF, and GPano of panoramas. */

import type { Size } from "../foundation/types.ts";

const [FIRST_FRAME, LAST_FRAME] = [0xffc0, 0xffcf];
/** Segments of the same range that hold tables. */
const NO_FRAMES = [0xffc4, 0xffc8, 0xffcc];
const APPLICATION_1 = 0xffe1;
const START_OF_SCAN = 0xffda;
const EXIF_NAME = "Exif\0\0";
const XMP_NAME = "http://ns.adobe.com/xap/1.0/\0";

const MAKE = 0x10f;
const EXIF_POINTER = 0x8769;
const [TAKEN_WIDTH, TAKEN_HEIGHT] = [0xa002, 0xa003];
const CUSTOM_RENDERED = 0xa401;
const DIGITAL_ZOOM = 0xa404;
const FOCAL_LENGTH_IN_35MM = 0xa405;
const [SHORT, LONG, RATIONAL] = [3, 4, 5];

/** `CustomRendered` of panoramas that iPhones take. */
const APPLE_PANORAMA = 6;

/** Millimetres; a focal length outside of it counts as not stated. No lens is there. */
const [SHORTEST_MM, LONGEST_MM] = [4, 5000];

/** A digital zoom above it counts as not stated. */
const FARTHEST_ZOOM = 200;

/** Relative difference of two width-to-height ratios that rounding explains. */
const SAME_SHAPE = 0.02;

/** A part of a panorama up to this wide is near enough to the picture of a pinhole camera. */
const WIDEST_VIEW_DEG = 90;

const DIAGONAL_35MM = Math.hypot(36, 24);

/** What is known of a picture's camera. */
export interface Lens {
  /** 35 mm equivalent focal length of the whole picture, millimetres; null if not stated. */
  focal35mm: number | null;
  /** Whether the picture is a wide panorama: no pinhole camera has taken it. */
  panorama: boolean;
}

export const UNKNOWN_LENS: Lens = { focal35mm: null, panorama: false };

/**
 * Reads what a JPEG file says of its lens, by the rules of the Python runtime: digital zoom narrows the
 * view, and so does a crop, which shows in a shape other than the one that was taken.
 *
 * @param file The file's bytes; what comes before the picture itself is enough.
 * @returns Nothing known, if the file is no JPEG or what it states is broken.
 */
export function readLens(file: ArrayBuffer): Lens {
  const { tiff, xmp, size } = segmentsOf(file);
  if (size === null) return UNKNOWN_LENS;
  const stated = tiff && fromTiff(tiff);
  const viewDeg = panoramaViewDeg(xmp) ?? (stated?.rendered === APPLE_PANORAMA ? 360 : null);
  if (viewDeg !== null) {
    if (viewDeg > WIDEST_VIEW_DEG) return { focal35mm: null, panorama: true };
    const focalPx = (size.width / viewDeg) * (180 / Math.PI);
    return { focal35mm: possible((focalPx * DIAGONAL_35MM) / diagonal(size)), panorama: false };
  }
  const focalMm = possible(stated?.focalMm ?? 0);
  if (!stated || focalMm === null) return UNKNOWN_LENS;
  const isZoomed = !stated.isApple && stated.zoom > 1 && stated.zoom <= FARTHEST_ZOOM;
  const zoomedMm = isZoomed ? focalMm * stated.zoom : focalMm;
  return { focal35mm: focalOfRest(zoomedMm, stated.taken, size), panorama: false };
}

function possible(focalMm: number): number | null {
  return focalMm >= SHORTEST_MM && focalMm <= LONGEST_MM ? focalMm : null;
}

function diagonal({ height, width }: Size): number {
  return Math.hypot(height, width);
}

/**
 * The 35 mm equivalent focal length of what is left of a picture that was cropped.
 *
 * A picture of another shape than when it was taken has been cropped, and then no longer has the field of
 * view that EXIF goes on to state. It is taken not to have been resized as well.
 */
function focalOfRest(focalMm: number, stated: Size, now: Size): number | null {
  if (!(Math.min(stated.height, stated.width) >= 1)) return focalMm;
  if (!Number.isFinite(Math.max(stated.height, stated.width))) return focalMm; // a broken number
  const isUprightCrop = now.height === stated.height || now.width === stated.width; // an edge is whole
  const isTurned = stated.width > stated.height !== now.width > now.height && !isUprightCrop;
  const taken = isTurned ? { height: stated.width, width: stated.height } : stated; // by a program
  const shapes = ((taken.width / taken.height) * now.height) / now.width;
  if (Math.abs(shapes - 1) <= SAME_SHAPE) return focalMm;
  if (now.width > taken.width || now.height > taken.height) return null;
  return (focalMm * diagonal(taken)) / diagonal(now);
}

interface Segments {
  tiff: DataView | null;
  xmp: string;
  /** As stored, before it is turned upright; null if the file is no JPEG. */
  size: Size | null;
}

function segmentsOf(file: ArrayBuffer): Segments {
  const found: Segments = { tiff: null, xmp: "", size: null };
  const view = new DataView(file);
  try {
    if (view.getUint16(0) !== 0xffd8) return found;
    for (let at = 2; ; ) {
      const marker = view.getUint16(at);
      if (marker === START_OF_SCAN) return found;
      const length = view.getUint16(at + 2);
      const body = new Uint8Array(file, at + 4, length - 2);
      if (marker === APPLICATION_1 && startsWith(body, EXIF_NAME)) {
        found.tiff ??= new DataView(file, at + 4 + EXIF_NAME.length, length - 2 - EXIF_NAME.length);
      } else if (marker === APPLICATION_1 && startsWith(body, XMP_NAME)) {
        found.xmp = new TextDecoder().decode(body.subarray(XMP_NAME.length));
      } else if (marker >= FIRST_FRAME && marker <= LAST_FRAME && !NO_FRAMES.includes(marker)) {
        found.size = { height: view.getUint16(at + 5), width: view.getUint16(at + 7) };
        return found; // nothing of the lens comes after it
      }
      at += 2 + length;
    }
  } catch (error) {
    if (error instanceof RangeError) return found; // broken, or more than was given
    throw error;
  }
}

function startsWith(bytes: Uint8Array, text: string): boolean {
  return [...text].every((letter, i) => bytes[i] === letter.charCodeAt(0));
}

interface Stated {
  focalMm: number;
  zoom: number;
  taken: Size;
  rendered: number;
  isApple: boolean;
}

/** What an EXIF block states, 0 for what it does not; null if it is broken. */
function fromTiff(tiff: DataView): Stated | null {
  try {
    const little = tiff.getUint16(0) === 0x4949;
    const main = tiff.getUint32(4, little);
    const exif = numberOf(tiff, little, main, EXIF_POINTER);
    if (exif === 0) return null;
    const of = (tag: number) => numberOf(tiff, little, exif, tag);
    return {
      focalMm: of(FOCAL_LENGTH_IN_35MM),
      zoom: of(DIGITAL_ZOOM),
      taken: { height: of(TAKEN_HEIGHT), width: of(TAKEN_WIDTH) },
      rendered: of(CUSTOM_RENDERED),
      isApple: isMadeByApple(tiff, little, main), // which states the focal length of what is left
    };
  } catch (error) {
    if (error instanceof RangeError) return null;
    throw error;
  }
}

/** Where the entry of a tag begins. */
function entryOf(tiff: DataView, little: boolean, folder: number, tag: number): number | null {
  const entries = tiff.getUint16(folder, little);
  for (let i = 0; i < entries; i++) {
    const entry = folder + 2 + 12 * i;
    if (tiff.getUint16(entry, little) === tag) return entry;
  }
  return null;
}

function numberOf(tiff: DataView, little: boolean, folder: number, tag: number): number {
  const entry = entryOf(tiff, little, folder, tag);
  if (entry === null) return 0;
  const type = tiff.getUint16(entry + 2, little);
  if (type === SHORT) return tiff.getUint16(entry + 8, little);
  const value = tiff.getUint32(entry + 8, little);
  if (type === LONG) return value;
  return type === RATIONAL ? tiff.getUint32(value, little) / tiff.getUint32(value + 4, little) : 0;
}

function isMadeByApple(tiff: DataView, little: boolean, folder: number): boolean {
  const entry = entryOf(tiff, little, folder, MAKE);
  if (entry === null || tiff.getUint32(entry + 4, little) < 5) return false; // letters
  const at = tiff.getUint32(entry + 8, little);
  return [..."Apple"].every((letter, i) => tiff.getUint8(at + i) === letter.charCodeAt(0));
}

/** How many degrees a panorama shows from left to right, by its GPano; null if it has none. */
function panoramaViewDeg(xmp: string): number | null {
  if (!xmp.includes("GPano") || gpano(xmp, "ProjectionType").toLowerCase() === "rectilinear") return null;
  const [full, shown] = [gpano(xmp, "FullPanoWidthPixels"), gpano(xmp, "CroppedAreaImageWidthPixels")].map(
    (stated) => (stated === "" ? NaN : Number(stated)),
  );
  return Number.isFinite(full) && shown > 0 && shown <= full ? (360 * shown) / full : 360;
}

/** A property as attribute or as element; empty if it is not there. */
function gpano(xmp: string, name: string): string {
  return new RegExp(`GPano:${name}\\s*(?:=\\s*["']|>)\\s*([^"'<]*)`).exec(xmp)?.[1].trim() ?? "";
}

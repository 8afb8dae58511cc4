/**
 * Pinhole cameras, and the conversion of disparity to depth. Pixel coordinates count from the centre
 * of the top left pixel; camera axes: x right, y down, z forward.
 */

import { IntrinsicsError } from "../errors.ts";
import type { Size } from "../foundation/types.ts";

/** A pinhole camera in the pixels of one picture size. */
export interface Intrinsics {
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  /** Where the numbers came from: the caller, the picture's EXIF, or a field of view taken for granted. */
  source: "given" | "exif" | "assumed";
}

/**
 * A camera as a caller knows it: intrinsics in pixels of the upright picture, its field of view in degrees
 * (horizontal, or along the longer side, whichever way it is held), or its 35 mm equivalent focal length
 * in millimetres.
 */
export type Camera =
  | { fx: number; fy: number; cx: number; cy: number }
  | { hfovDeg: number }
  | { fovDeg: number }
  | { focal35mm: number };

/** Field of view along the longer side of a picture that does not say which camera took it. */
export const ASSUMED_FOV_DEG = 60;

const DIAGONAL_35MM = Math.hypot(36, 24);
const MOST_PX = 1e9;

/**
 * The camera of a picture.
 *
 * @param picture Size of the upright picture.
 * @param camera What the caller knows; null for nothing.
 * @param exif35mm What the picture's EXIF states, millimetres; null for nothing.
 * @throws IntrinsicsError If the camera is impossible.
 */
export function intrinsicsOf(
  picture: Size,
  camera: Camera | null = null,
  exif35mm: number | null = null,
): Intrinsics {
  if (camera === null) {
    return exif35mm === null
      ? centred(picture, focalPx(Math.max(picture.height, picture.width), ASSUMED_FOV_DEG), "assumed")
      : centred(picture, fromFocal35mm(picture, exif35mm), "exif");
  }
  if ("focal35mm" in camera) return centred(picture, fromFocal35mm(picture, camera.focal35mm), "given");
  if ("hfovDeg" in camera) return centred(picture, focalPx(picture.width, camera.hfovDeg), "given");
  if ("fovDeg" in camera) {
    return centred(picture, focalPx(Math.max(picture.height, picture.width), camera.fovDeg), "given");
  }
  const { fx, fy, cx, cy } = camera;
  return checked({ fx, fy, cx, cy, source: "given" });
}

/** The same camera after its picture was resized: edges go onto edges. */
export function scaledCamera(camera: Intrinsics, from: Size, to: Size): Intrinsics {
  const alongX = to.width / from.width;
  const alongY = to.height / from.height;
  return {
    fx: camera.fx * alongX,
    fy: camera.fy * alongY,
    cx: (camera.cx + 0.5) * alongX - 0.5,
    cy: (camera.cy + 0.5) * alongY - 0.5,
    source: camera.source,
  };
}

/** Metres from a sigmoid disparity: 0 is `farthestM` away, 1 is `nearestM` away. */
export function disparityToDepth(disparity: number, nearestM = 0.1, farthestM = 100): number {
  return 1 / (1 / farthestM + (1 / nearestM - 1 / farthestM) * disparity);
}

function focalPx(side: number, fovDeg: number): number {
  if (!(fovDeg > 1e-6 && fovDeg < 180 - 1e-6)) {
    throw new IntrinsicsError(
      `a pinhole camera cannot have a field of view of ${fovDeg} degrees; give an angle between 0 and 180 ` +
        "(phones: about 65)",
    );
  }
  return side / 2 / Math.tan((fovDeg * Math.PI) / 360);
}

/** The equivalence refers to the diagonal (CIPA DCG-001): 43.27 mm of film. */
function fromFocal35mm({ height, width }: Size, focal35mm: number): number {
  return (focal35mm * Math.hypot(height, width)) / DIAGONAL_35MM;
}

function centred({ height, width }: Size, focal: number, source: Intrinsics["source"]): Intrinsics {
  return checked({ fx: focal, fy: focal, cx: (width - 1) / 2, cy: (height - 1) / 2, source });
}

function checked(camera: Intrinsics): Intrinsics {
  for (const name of ["fx", "fy", "cx", "cy"] as const) {
    const value = camera[name];
    const isPossible = Number.isFinite(value) && Math.abs(value) <= MOST_PX;
    if (!isPossible || (name.startsWith("f") && value < 1 / MOST_PX)) {
      throw new IntrinsicsError(
        `the camera's ${name} is ${value}; give { fx, fy, cx, cy } in pixels of the upright picture, ` +
          "{ fovDeg }, { hfovDeg } or { focal35mm }",
      );
    }
  }
  return camera;
}

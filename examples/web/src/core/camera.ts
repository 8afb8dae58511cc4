/**
 * Pinhole cameras and metres. Pixel coordinates count from the centre of the top left pixel; camera
 * axes: x right, y down, z forward.
 */

import type { Size } from "./resize";

/** A pinhole camera in the pixels of one picture size. */
export interface Intrinsics {
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  /** Where the numbers came from: the picture's EXIF, or a field of view taken for granted. */
  source: "exif" | "assumed";
}

/** Field of view along the longer side of a picture that does not say which camera took it. */
export const ASSUMED_FOV_DEG = 60;

const DIAGONAL_35MM = Math.hypot(36, 24);

/**
 * The camera of a picture.
 *
 * @param picture Size of the upright picture.
 * @param focal35mm Its 35 mm equivalent focal length in millimetres, null if it states none.
 */
export function cameraOf(picture: Size, focal35mm: number | null): Intrinsics {
  const { height, width } = picture;
  const focalPx =
    focal35mm === null
      ? Math.max(height, width) / 2 / Math.tan((ASSUMED_FOV_DEG * Math.PI) / 360)
      : (focal35mm * Math.hypot(height, width)) / DIAGONAL_35MM;
  return {
    fx: focalPx,
    fy: focalPx,
    cx: (width - 1) / 2,
    cy: (height - 1) / 2,
    source: focal35mm === null ? "assumed" : "exif",
  };
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
export function disparityToDepth(disparity: number, nearestM: number, farthestM: number): number {
  return 1 / (1 / farthestM + (1 / nearestM - 1 / farthestM) * disparity);
}

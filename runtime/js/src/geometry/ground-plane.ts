/**
 * The ground plane: its fit, the camera's pose above it, and metric coordinates on it.
 *
 * Ground coordinates follow ROS REP-103: x forward, y left, metres, from the point of the plane
 * straight below the camera; forward is the viewing direction projected onto the plane.
 */

// docs/porting-metres.md has this file, and those in navigation/, in pseudo-code.

import { GroundPlaneError } from "../errors.ts";
import { median, select } from "../foundation/median.ts";
import type { Mask, Pair, Size, Triple } from "../foundation/types.ts";
import type { Intrinsics } from "./camera.ts";
import { knowsAnything, upVector, type CameraPose } from "./camera-pose.ts";

const FEWEST_PIXELS = 20;

/** Triples drawn: if half of the pixels are inliers, one is free of outliers but for 1 in 10^8. */
const TRIALS = 150;

/** Most pixels for the fit, evenly drawn: three numbers need no more. */
const FITTED = 8000;

/** Pixels that rank the hypotheses: more do not change the order. */
const JUDGED = 600;

/** Share of the picture that must be ground. */
const LEAST_AREA = 0.02;

/** The ground is flat if the median of |ln(depth / plane's depth)| over it is at most this. */
const FLAT = 0.15;

/** Camera heights, lowest pitch and largest lean to a side with which a fitted plane is believed. */
const [LOWEST_M, HIGHEST_M] = [0.03, 100];
const [STEEPEST_UP_DEG, MOST_LEANING_DEG] = [-30, 45];

/** Angles around the fitted one among which the unknown angle is searched if the other is known. */
const SEARCHED_DEG = Array.from({ length: 101 }, (_, i) => -25 + i / 2);

const DEGREES = 180 / Math.PI;

/** The ground as one plane, in camera axes. */
export class GroundPlane {
  /** The unit normal in camera axes: x right, y down, z forward. */
  readonly up: Triple;
  /** Height of the camera above the plane, metres. */
  readonly cameraHeightM: number;
  /** Median distance between the plane and the pixels of the fit, metres; 0 for a known plane. */
  readonly errorM: number;

  constructor(up: Triple, cameraHeightM: number, errorM: number) {
    this.up = up;
    this.cameraHeightM = cameraHeightM;
    this.errorM = errorM;
  }

  /** Downward pitch of the camera in degrees: 0 looks at the horizon, 90 straight down. */
  get pitchDeg(): number {
    return Math.asin(Math.max(-1, Math.min(1, -this.up[2]))) * DEGREES;
  }

  /** Roll of the camera about its optical axis in degrees, right side down. */
  get rollDeg(): number {
    return Math.atan2(-this.up[0], -this.up[1]) * DEGREES;
  }

  /** Forward, left and up: unit vectors in camera axes. */
  get axes(): [Triple, Triple, Triple] {
    const { up } = this;
    // straight down: forward is up in the picture
    const towards: Triple = Math.abs(up[2]) > 0.999 ? [0, -1, 0] : [0, 0, 1];
    const along = dot(towards, up);
    const level = towards.map((each, i) => each - along * up[i]) as Triple;
    const length = Math.hypot(...level);
    const forward = level.map((each) => each / length) as Triple;
    return [forward, cross(up, forward), up];
  }

  /** Inverse depth at the centre of the picture, and its change with every pixel to the right and down. */
  slope({ fx, fy, cx, cy }: Intrinsics): { atOrigin: number; perX: number; perY: number } {
    const [a, b, c] = this.up.map((each) => -each / this.cameraHeightM);
    return { atOrigin: c - (a * cx) / fx - (b * cy) / fy, perX: a / fx, perY: b / fy };
  }

  /** The plane's inverse depth at every pixel, 1 / metres; not positive at and above the horizon. */
  inverseDepth(camera: Intrinsics, { height, width }: Size): Float32Array {
    const { atOrigin, perX, perY } = this.slope(camera);
    const inverse = new Float32Array(height * width);
    for (let y = 0, i = 0; y < height; y++) {
      for (let x = 0; x < width; x++, i++) inverse[i] = atOrigin + perX * x + perY * y;
    }
    return inverse;
  }

  /**
   * Where the ray of a pixel meets the plane.
   *
   * @param pixel x and y; (0, 0) is the centre of the top left pixel.
   * @returns Forward and left, metres; NaN at and above the horizon.
   */
  atPixel([x, y]: Pair, camera: Intrinsics): [number, number] {
    const ray: Triple = [(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1];
    const [forward, left, rise] = this.axes.map((axis) => dot(axis, ray));
    const stretch = rise < -1e-9 ? this.cameraHeightM / -rise : NaN;
    return [forward * stretch, left * stretch];
  }

  /** The function that projects places on the plane into the picture: the inverse of `atPixel`. */
  projection(camera: Intrinsics): (forwardM: number, leftM: number) => [number, number] {
    const [forward, left, up] = this.axes;
    const below = up.map((each) => -each * this.cameraHeightM);
    return (x, y) => {
      const depthM = forward[2] * x + left[2] * y + below[2];
      if (!(depthM > 1e-6)) return [NaN, NaN];
      return [
        camera.cx + (camera.fx * (forward[0] * x + left[0] * y + below[0])) / depthM,
        camera.cy + (camera.fy * (forward[1] * x + left[1] * y + below[1])) / depthM,
      ];
    };
  }

  /** Projects one place, forward and left, into the picture; NaN behind the camera. */
  toPixel([forwardM, leftM]: Pair, camera: Intrinsics): [number, number] {
    return this.projection(camera)(forwardM, leftM);
  }
}

/**
 * The ground plane, if there is one to be believed: the one gate for everything in metres.
 *
 * A pose that is known completely gives the plane, whatever the picture shows. Otherwise it is fitted,
 * and refused if too little of the picture is ground, if the ground is not flat, or if the camera's
 * height, pitch or lean cannot be.
 *
 * @param groundDepthM Metres along the optical axis; read where `ground` is.
 * @param camera In pixels of the maps.
 * @param pose What is known of the camera's pose; the rest is fitted.
 * @throws GroundPlaneError If no plane fits, or the plane is refused.
 */
export function findGroundPlane(
  groundDepthM: Float32Array,
  ground: Mask,
  size: Size,
  camera: Intrinsics,
  pose: CameraPose,
): GroundPlane {
  const { heightM, pitchDeg, rollDeg } = pose;
  if (heightM !== null && pitchDeg !== null && rollDeg !== null) {
    return new GroundPlane(upVector(pitchDeg, rollDeg), heightM, 0);
  }
  const chosen = evenlyDrawn(ground);
  const plane = fitGroundPlane(groundDepthM, chosen, size, camera, pose);
  const share = ground.reduce((sum, each) => sum + each, 0) / ground.length;
  if (share < LEAST_AREA) {
    throw new GroundPlaneError(
      `${(100 * share).toFixed(1)}% of the picture is ground; a plane needs ${100 * LEAST_AREA}%; use a ` +
        "picture that shows more ground, or give the camera's height, pitch and roll",
      "little_ground",
    );
  }
  const leanDeg = Math.asin(Math.min(1, Math.abs(plane.up[0]))) * DEGREES;
  const isPossible =
    LOWEST_M <= plane.cameraHeightM &&
    plane.cameraHeightM <= HIGHEST_M &&
    plane.pitchDeg >= STEEPEST_UP_DEG &&
    (leanDeg <= MOST_LEANING_DEG || rollDeg !== null);
  if (!isPossible) {
    throw new GroundPlaneError(
      "the plane of what looks like ground cannot be the ground: the camera would be " +
        `${plane.cameraHeightM.toFixed(2)} m above it, look down by ${plane.pitchDeg.toFixed(0)} ` +
        `degrees and lean by ${leanDeg.toFixed(0)}; give the camera's height, pitch and roll, if they are so`,
      "impossible_pose",
    );
  }
  const deviation = medianDeviation(plane, groundDepthM, chosen, size, camera);
  if (!(deviation <= FLAT)) {
    throw new GroundPlaneError(
      `the ground is not flat: half of it deviates by more than ${(100 * deviation).toFixed(0)}% from ` +
        "one plane; use a picture of flat ground, or give the camera's height, pitch and roll",
      "not_flat",
    );
  }
  return plane;
}

/** Indices of ground pixels, row by row: all of them, or `FITTED`. */
function evenlyDrawn(ground: Mask): Int32Array {
  const pixels = new Int32Array(ground.length);
  let count = 0;
  for (let i = 0; i < ground.length; i++) if (ground[i]) pixels[count++] = i;
  if (count <= FITTED) return pixels.slice(0, count);
  return Int32Array.from({ length: FITTED }, (_, i) => pixels[Math.floor((i * count) / FITTED)]);
}

/**
 * The median of |ln(depth / plane's depth)|, relative to its own median if that is not 1: a camera
 * height that is known rescales the plane, which does not make the ground uneven.
 */
function medianDeviation(
  plane: GroundPlane,
  groundDepthM: Float32Array,
  ground: Int32Array,
  { width }: Size,
  camera: Intrinsics,
): number {
  const { atOrigin, perX, perY } = plane.slope(camera);
  const logRatio = Float64Array.from(ground, (pixel) => {
    const x = pixel % width;
    const inverse = atOrigin + perX * x + (perY * (pixel - x)) / width;
    return Math.log(Math.max(inverse * groundDepthM[pixel], 1e-6));
  });
  const middle = median(logRatio.slice());
  return median(logRatio.map((each) => Math.abs(each - middle)));
}

/** Ground pixels for a fit: the x and y of their rays, whose z is 1, and their inverse depths. */
interface Rays {
  x: Float64Array;
  y: Float64Array;
  inverse: Float64Array;
}

/**
 * Fits the plane that at least half of the ground lies on.
 *
 * Along a plane the inverse depth is affine in the pixel, and a network's error is uniform in inverse
 * depth, not in metres. So this is a least median of squares in inverse depth (Rousseeuw 1984), then
 * least squares over the inliers.
 */
function fitGroundPlane(
  groundDepthM: Float32Array,
  ground: Int32Array,
  { width }: Size,
  camera: Intrinsics,
  pose: CameraPose,
): GroundPlane {
  if (ground.length < FEWEST_PIXELS) {
    throw new GroundPlaneError(
      `${ground.length} pixels are ground; a plane needs ${FEWEST_PIXELS}; lower the threshold, or use a ` +
        "picture that shows more ground",
      "few_pixels",
    );
  }
  const count = ground.length;
  const rays = {
    x: new Float64Array(count),
    y: new Float64Array(count),
    inverse: new Float64Array(count),
  };
  for (let i = 0; i < count; i++) {
    const pixel = ground[i];
    const column = pixel % width;
    rays.x[i] = (column - camera.cx) / camera.fx;
    rays.y[i] = ((pixel - column) / width - camera.cy) / camera.fy;
    rays.inverse[i] = 1 / groundDepthM[pixel];
  }
  let gradient = leastMedian(rays);
  for (let round = 0; round < 6; round++) {
    const off = residuals(gradient, rays);
    const most = Math.max(2.5 * 1.4826 * median(off.slice()), 1e-9);
    gradient = leastSquares(rays, (i) => off[i] <= most) ?? gradient;
  }
  if (knowsAnything(pose)) gradient = withKnown(gradient, rays, pose);
  const length = Math.hypot(...gradient); // up . ray = -height / depth
  const up = gradient.map((each) => -each / length) as Triple;
  if (up[1] > 0.2) {
    throw new GroundPlaneError(
      "the ground plane is above the camera; turn the picture if it is upside down",
      "above_camera",
    );
  }
  const above = rays.inverse.map((inverse, i) =>
    Math.abs((up[0] * rays.x[i] + up[1] * rays.y[i] + up[2]) / inverse + 1 / length),
  );
  return new GroundPlane(up, 1 / length, median(above));
}

function residuals([a, b, c]: Triple, { x, y, inverse }: Rays): Float64Array {
  const off = new Float64Array(x.length);
  for (let i = 0; i < off.length; i++) off[i] = Math.abs(a * x[i] + b * y[i] + c - inverse[i]);
  return off;
}

/** The gradient of inverse depth, with the known part of the pose instead of the fitted. */
function withKnown(gradient: Triple, rays: Rays, pose: CameraPose): Triple {
  const length = Math.hypot(...gradient);
  const fitted = new GroundPlane(gradient.map((each) => -each / length) as Triple, 1 / length, 0);
  let pitches = [pose.pitchDeg ?? fitted.pitchDeg];
  let rolls = [pose.rollDeg ?? fitted.rollDeg];
  if (pose.pitchDeg === null && (pose.rollDeg !== null || pose.heightM !== null)) {
    pitches = SEARCHED_DEG.map((each) => Math.min(90, Math.max(-89, fitted.pitchDeg + each)));
  } else if (pose.pitchDeg !== null && pose.rollDeg === null) {
    rolls = SEARCHED_DEG.map((each) => fitted.rollDeg + each);
  }
  let best = gradient;
  let least = Infinity;
  for (const pitch of pitches) {
    for (const roll of rolls) {
      const up = upVector(pitch, roll);
      const heightM = pose.heightM ?? medianHeight(up, rays);
      const plane = up.map((each) => -each / heightM) as Triple;
      const error = median(residuals(plane, rays));
      if (error < least) [best, least] = [plane, error];
    }
  }
  return best;
}

/** The median height of the camera above the pixels of the fit, if up is known. */
function medianHeight(up: Triple, { x, y, inverse }: Rays): number {
  const heights = inverse
    .map((each, i) => -(up[0] * x[i] + up[1] * y[i] + up[2]) / each)
    .filter((each) => each > 0);
  return heights.length > 0 ? median(heights) : 1;
}

/** The plane through a triple with the least median residual. */
function leastMedian(rays: Rays): Triple {
  const count = rays.x.length;
  const planes: Triple[] = [];
  for (let trial = 0; trial < TRIALS; trial++) {
    const [i, j, k] = [0, 1, 2].map((corner) => drawn(3 * trial + corner, count));
    const plane = through(rays, i, j, k);
    if (plane) planes.push(plane);
  }
  if (planes.length === 0) {
    throw new GroundPlaneError(
      `the ${count} ground pixels lie in one line, which spans no plane; use a picture that shows more ` +
        "ground",
      "one_line",
    );
  }
  const judged = Int32Array.from({ length: JUDGED }, (_, i) => drawn(3 * TRIALS + i, count));
  const part = (values: Float64Array) => Float64Array.from(judged, (i) => values[i]);
  const judges = { x: part(rays.x), y: part(rays.y), inverse: part(rays.inverse) };
  let best = planes[0];
  let least = Infinity;
  for (const plane of planes) {
    const middle = select(residuals(plane, judges), JUDGED >> 1);
    if (middle < least) [best, least] = [plane, middle];
  }
  return best;
}

/**
 * The i-th of a row of numbers from 0 to count - 1, the same ones on every machine and in every
 * language: the finaliser of MurmurHash3 (32 bits) of i, spread over the range.
 */
function drawn(i: number, count: number): number {
  let mixed = i ^ (i >>> 16);
  mixed = Math.imul(mixed, 0x85ebca6b);
  mixed = Math.imul(mixed ^ (mixed >>> 13), 0xc2b2ae35);
  mixed ^= mixed >>> 16;
  return Math.floor(((mixed >>> 0) * count) / 2 ** 32);
}

/** The plane through three pixels; null if they lie in one line. */
function through({ x, y, inverse }: Rays, i: number, j: number, k: number): Triple | null {
  const [a, b, c]: Triple[] = [i, j, k].map((each) => [x[each], y[each], 1]);
  const determinant = dot(a, cross(b, c));
  if (!(Math.abs(determinant) > 1e-9)) return null;
  const [u, v, w] = [cross(b, c), cross(c, a), cross(a, b)];
  return [0, 1, 2].map(
    (axis) => (inverse[i] * u[axis] + inverse[j] * v[axis] + inverse[k] * w[axis]) / determinant,
  ) as Triple;
}

/** Least squares over the pixels that count; null where they lie in one line. */
function leastSquares({ x, y, inverse }: Rays, counts: (i: number) => boolean): Triple | null {
  let [xx, xy, yy, sx, sy, n] = [0, 0, 0, 0, 0, 0];
  const right: Triple = [0, 0, 0];
  for (let i = 0; i < x.length; i++) {
    if (!counts(i)) continue;
    xx += x[i] * x[i];
    xy += x[i] * y[i];
    yy += y[i] * y[i];
    sx += x[i];
    sy += y[i];
    n++;
    right[0] += x[i] * inverse[i];
    right[1] += y[i] * inverse[i];
    right[2] += inverse[i];
  }
  // Cramer's rule; the matrix is symmetric, so its rows are its columns.
  const [a, b, c]: Triple[] = [[xx, xy, sx], [xy, yy, sy], [sx, sy, n]];
  const determinant = dot(a, cross(b, c));
  if (!(Math.abs(determinant) > 1e-12)) return null;
  return [cross(b, c), cross(c, a), cross(a, b)].map((each) => dot(right, each) / determinant) as Triple;
}

function dot(a: Triple, b: Triple): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a: Triple, b: Triple): Triple {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

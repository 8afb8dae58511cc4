/**
 * The one rule for obstacles: what is seen between a step and the robot's height above the ground.
 *
 * A surface that is seen is an obstacle where it is higher above the ground plane than `STEP_HEIGHT_M`
 * and lower than the robot, and is not visible ground. Ground that is seen far above the plane is none:
 * table tops look like floors, so there the depth decides.
 *
 * The depth is a network's. So its scale is taken from the visible ground, whose distance the plane
 * knows better. Pixels are counted by bearing and range, in bins that grow with the range as the
 * depth's error does, and a bin is occupied if enough surface is seen in it.
 */

import { median } from "../foundation/median.ts";
import { rint } from "../foundation/rint.ts";
import type { Mask } from "../foundation/types.ts";
import type { GroundMaps } from "../maps/ground-maps.ts";

/** Lower things are no obstacles: a network's depth does not tell them from the ground. */
export const STEP_HEIGHT_M = 0.15;

/** Default height of the robot, metres: higher things are passed beneath. */
export const ROBOT_HEIGHT_M = 1.2;

/** Width of a bin. */
const BEARING_DEG = 1;

const [NEAREST_M, FARTHEST_M] = [0.2, 50];

/** Length of a bin, as a share of its range. */
const RANGE_STEP = 0.02;

/** A bin is judged together with the bins behind it: 12 % of the range, about the depth's error. */
const WINDOW = 6;

/** Height of the surface seen in a window, over the width of a bin, that makes an obstacle. */
const LEAST_SEEN_M = 0.01;
const LEAST_PX = 3;

/** Visible ground higher than this share of the camera's height is not ground. */
const RAISED = 0.35;

/** Change of the logarithm of depth along a row beyond which it runs from one surface to another. */
const STEEPEST = 0.04;

/** Pixels of visible ground that are needed to take the depth's scale from them. */
const SCALED_BY_PX = 100;

const RANGES = Math.ceil(Math.log(FARTHEST_M / NEAREST_M) / RANGE_STEP);
const BEARINGS = Math.round(180 / BEARING_DEG) + 1;
const DEGREES = 180 / Math.PI;

/** @throws RangeError If the height is not above `STEP_HEIGHT_M`. */
export function checkRobotHeight(robotHeightM: number): void {
  if (!(Number.isFinite(robotHeightM) && robotHeightM > STEP_HEIGHT_M)) {
    throw new RangeError(
      `robotHeightM is ${robotHeightM}; give metres, more than the ${STEP_HEIGHT_M} m of a step`,
    );
  }
}

/**
 * What stands around the camera, by bearing and range, on the ground plane. Bearings are degrees from
 * straight ahead, left positive (REP-103), from -90 to 90.
 */
export class Obstacles {
  readonly #occupied: Mask;
  readonly #inView: Mask;
  /** 1 where visible ground is too high to be ground. */
  readonly raised: Mask;

  /**
   * @param occupied Bearings by ranges.
   * @param inView Bearings that the picture shows.
   */
  constructor(occupied: Mask, inView: Mask, raised: Mask) {
    this.#occupied = occupied;
    this.#inView = inView;
    this.raised = raised;
  }

  /**
   * Marks the square cells that are occupied: their centre lies in an occupied bin, or the centre of an
   * occupied bin in them (near the camera bins are smaller than cells).
   *
   * @param rows The grid has twice as many columns; see `OccupancyGrid`.
   * @param mark Gets the index of a cell.
   */
  cover(rows: number, cellM: number, mark: (cell: number) => void): void {
    const columns = 2 * rows;
    for (let row = 0, cell = 0; row < rows; row++) {
      const x = (rows - row - 0.5) * cellM;
      for (let column = 0; column < columns; column++, cell++) {
        const y = (rows - column - 0.5) * cellM;
        const bearing = bearingOf(Math.atan2(y, x));
        const place = placeOf(Math.hypot(x, y));
        const isInside = bearing >= 0 && bearing < BEARINGS && place >= 0 && place < RANGES;
        if (isInside && this.#occupied[bearing * RANGES + place]) mark(cell);
      }
    }
    this.#occupied.forEach((isOccupied, bin) => {
      if (!isOccupied) return;
      const place = bin % RANGES;
      const angle = ((bin - place) / RANGES - (BEARINGS - 1) / 2) * (BEARING_DEG / DEGREES);
      const rangeM = rangeOf(place);
      const row = Math.floor(rows - (rangeM * Math.cos(angle)) / cellM);
      const column = Math.floor(rows - (rangeM * Math.sin(angle)) / cellM);
      if (row >= 0 && row < rows && column >= 0 && column < columns) mark(row * columns + column);
    });
  }

  /** Range of the first occupied bin, metres; infinite where nothing is seen, NaN outside the view. */
  nearestM(bearingDeg: number): number {
    const row = rint(bearingDeg / BEARING_DEG + (BEARINGS - 1) / 2);
    if (!(row >= 0 && row < BEARINGS) || !this.#inView[row]) return NaN;
    const first = this.#occupied.subarray(row * RANGES, (row + 1) * RANGES).indexOf(1);
    return first < 0 ? Infinity : rangeOf(first);
  }
}

/**
 * Applies the rule at the top of this page to a prediction.
 *
 * @throws GroundPlaneError If there is no ground plane.
 * @throws RangeError If the robot is not higher than a step.
 */
export function findObstacles(maps: GroundMaps, robotHeightM = ROBOT_HEIGHT_M): Obstacles {
  checkRobotHeight(robotHeightM);
  const plane = maps.groundPlane();
  const { intrinsics: camera, visibleGround } = maps;
  const { height, width } = maps.mapSize;
  const [ahead, aside, up] = plane.axes;
  const pixels = height * width;
  const forward = new Float32Array(pixels);
  const left = new Float32Array(pixels);
  const rise = new Float32Array(pixels);
  for (let row = 0, i = 0; row < height; row++) {
    const y = (row - camera.cy) / camera.fy;
    for (let column = 0; column < width; column++, i++) {
      const x = (column - camera.cx) / camera.fx;
      forward[i] = ahead[0] * x + ahead[1] * y + ahead[2];
      left[i] = aside[0] * x + aside[1] * y + aside[2];
      rise[i] = up[0] * x + up[1] * y + up[2];
    }
  }
  const depthM = scaled(maps.visibleDepthM, rise, visibleGround, plane.cameraHeightM);
  const highestM = Math.max(STEP_HEIGHT_M, RAISED * plane.cameraHeightM);
  const raised = new Uint8Array(pixels);
  const inView = new Uint8Array(BEARINGS);
  const count = new Float64Array(BEARINGS * RANGES);
  const surfaceM = new Float64Array(BEARINGS * RANGES);
  for (let row = 0, i = 0; row < height; row++) {
    for (let column = 0; column < width; column++, i++) {
      const bearing = bearingOf(Math.atan2(left[i], forward[i]));
      const isInside = bearing >= 0 && bearing < BEARINGS;
      if (isInside) inView[bearing] = 1;
      const aboveM = depthM[i] * rise[i] + plane.cameraHeightM;
      raised[i] = visibleGround[i] & Number(aboveM > highestM);
      if (!isInside || !(aboveM > STEP_HEIGHT_M && aboveM < robotHeightM)) continue;
      if (visibleGround[i] && !raised[i]) continue;
      if (column > 0 && column < width - 1) {
        if (!(Math.abs(Math.log(depthM[i + 1] / depthM[i - 1])) < 2 * STEEPEST)) continue;
      }
      const rangeM = depthM[i] * Math.hypot(forward[i], left[i]);
      const place = placeOf(rangeM);
      if (place < 0 || place >= RANGES) continue;
      const bin = bearing * RANGES + place;
      count[bin]++;
      // a pixel is depth / f wide and high, a bin as wide as an arc
      surfaceM[bin] += depthM[i] ** 2 / (camera.fx * camera.fy) / (rangeM * (BEARING_DEG / DEGREES));
    }
  }
  const occupied = new Uint8Array(BEARINGS * RANGES);
  for (let bearing = 0; bearing < BEARINGS; bearing++) {
    let seen = 0;
    let seenM = 0;
    for (let place = RANGES - 1; place >= 0; place--) {
      const bin = bearing * RANGES + place;
      const isFar = place + WINDOW >= RANGES;
      seen += count[bin] - (isFar ? 0 : count[bin + WINDOW]);
      seenM += surfaceM[bin] - (isFar ? 0 : surfaceM[bin + WINDOW]);
      occupied[bin] = Number(count[bin] > 0 && seen >= LEAST_PX && seenM >= LEAST_SEEN_M);
    }
  }
  return new Obstacles(occupied, inView, raised);
}

/** The visible depth, scaled so that visible ground lies on the plane in the median. */
export function scaled(
  depthM: Float32Array,
  rise: Float32Array,
  visible: Mask,
  cameraHeightM: number,
): Float32Array {
  const heightsM = new Float64Array(depthM.length);
  let count = 0;
  for (let i = 0; i < depthM.length; i++) {
    if (visible[i] && rise[i] < -1e-3) heightsM[count++] = depthM[i] * -rise[i];
  }
  if (count < SCALED_BY_PX) return depthM;
  const tooFar = median(heightsM.subarray(0, count)) / cameraHeightM;
  return depthM.map((each) => each / tooFar);
}

function bearingOf(angle: number): number {
  return rint((angle * DEGREES) / BEARING_DEG + (BEARINGS - 1) / 2);
}

function placeOf(rangeM: number): number {
  return Math.floor(Math.min(Math.log(Math.max(rangeM, 1e-3) / NEAREST_M) / RANGE_STEP, RANGES));
}

/** Range of a bin's centre, metres. */
function rangeOf(place: number): number {
  return NEAREST_M * Math.exp((place + 0.5) * RANGE_STEP);
}

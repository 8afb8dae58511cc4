/** Ranges by bearing, as a laser scanner at the camera's place on the ground would report them. */

import type { GroundMaps } from "../maps/ground-maps.ts";
import { findObstacles } from "./obstacles.ts";

/**
 * Range, metres, and the share of such ranges that lie within a quarter of the true distance, measured
 * on synthetic scenes: places unlike them are worse.
 */
const MEASURED = [
  [1, 0.55],
  [1.52, 0.57],
  [1.94, 0.64],
  [2.51, 0.6],
  [3.19, 0.6],
  [4.31, 0.79],
  [6.69, 0.67],
] as const;

/** The distance to the nearest obstacle by bearing, as in ROS's `sensor_msgs/LaserScan`. */
export interface RangeScan {
  /** Degrees from straight ahead, left positive (REP-103). */
  bearingsDeg: number[];
  /** Metres from the point below the camera; infinite where no obstacle is seen, NaN out of view. */
  rangesM: Float32Array;
  /** Share of such ranges that lie within a quarter of the true one; 0 where there is no range. */
  confidence: Float32Array;
}

/** The scan of a prediction; see `Prediction.scan`. */
export function scan(
  maps: GroundMaps,
  bearingsDeg: readonly number[],
  robotHeightM: number,
): RangeScan {
  const obstacles = findObstacles(maps, robotHeightM);
  const rangesM = Float32Array.from(bearingsDeg, (each) => obstacles.nearestM(each));
  return { bearingsDeg: [...bearingsDeg], rangesM, confidence: rangesM.map(confidenceAt) };
}

function confidenceAt(rangeM: number): number {
  if (!Number.isFinite(rangeM)) return 0;
  const next = MEASURED.findIndex(([atM]) => atM > rangeM);
  if (next === 0) return MEASURED[0][1];
  if (next < 0) return MEASURED[MEASURED.length - 1][1];
  const [[fromM, from], [toM, to]] = [MEASURED[next - 1], MEASURED[next]];
  return from + ((rangeM - fromM) / (toM - fromM)) * (to - from);
}

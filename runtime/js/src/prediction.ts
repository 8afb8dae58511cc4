/** The result of a prediction: the maps, and methods that plan on them. */

import type { Pair, Size } from "./foundation/types.ts";
import { GroundMaps } from "./maps/ground-maps.ts";
import { flattened } from "./navigation/ground-flattening.ts";
import { ROBOT_HEIGHT_M } from "./navigation/obstacles.ts";
import { makeOccupancyGrid, makeWalkableGrid, type OccupancyGrid } from "./navigation/occupancy-grid.ts";
import { findPath, type GroundPath, type PlanOptions } from "./navigation/path-planning.ts";
import { scan, type RangeScan } from "./navigation/range-scan.ts";

const EVERY_DEGREE = Array.from({ length: 181 }, (_, i) => i - 90);

/** What is at a place of the picture. */
export interface Place {
  /** Ground that is seen, ground behind something, or none. */
  ground: "visible" | "hidden" | "none";
  /** Metres along the optical axis to the ground; NaN where there is none. */
  groundDepthM: number;
  /** Metres along the optical axis to what is seen; on visible ground, the ground. */
  visibleDepthM: number;
}

/** Walkable ground in a picture, seen and hidden, and how far away it is. */
export class Prediction extends GroundMaps {
  /**
   * The same prediction with the ground's depth laid onto `groundPlane`, where it lies close to it:
   * ramps, steps and stairs keep their depth. With a known height, pitch and roll all ground is laid.
   * Without a plane, the prediction itself.
   */
  flattened(): Prediction {
    if (this.laidOnto) return this;
    const found = flattened(this);
    if (!found) return this;
    return new Prediction({ ...this, unmaskedGroundDepthM: found.depthM, laidOnto: found.plane });
  }

  /**
   * What is at a pixel of the picture. Places beyond the border count as on it.
   *
   * @param pixel x and y; [0, 0] is the centre of the top left pixel.
   */
  at([x, y]: Pair): Place {
    const { mapSize, imageSize } = this;
    const within = (value: number, to: number) => Math.min(to - 1, Math.max(0, Math.floor(value)));
    const column = within(((x + 0.5) * mapSize.width) / imageSize.width, mapSize.width);
    const row = within(((y + 0.5) * mapSize.height) / imageSize.height, mapSize.height);
    const pixel = row * mapSize.width + column;
    const ground = this.visibleGround[pixel] ? "visible" : this.ground[pixel] ? "hidden" : "none";
    const depthM = this.unmaskedGroundDepthM[pixel];
    return {
      ground,
      groundDepthM: this.ground[pixel] ? depthM : NaN,
      visibleDepthM: ground === "visible" && this.ground[pixel] ? depthM : this.visibleDepthM[pixel],
    };
  }

  /**
   * The surroundings in bird's-eye view, as an occupancy grid. Occupied is what is seen between the
   * height of a step (0.15 m) and that of the robot. Hidden ground is a value of its own. Assumes that
   * all ground lies in one plane, `groundPlane`.
   *
   * @param cellM Side of a cell, metres.
   * @param rangeM Reach of the grid ahead, and to each side, metres.
   * @param robotHeightM Height of the robot, metres: it passes beneath higher things.
   * @throws GroundPlaneError If there is no ground plane.
   * @throws RangeError If a size is not positive, the range is more than 1500 cells, or the robot is not
   *   higher than a step.
   */
  topDown(cellM = 0.05, rangeM = 10, { robotHeightM = ROBOT_HEIGHT_M } = {}): OccupancyGrid {
    return makeOccupancyGrid(this, cellM, rangeM, robotHeightM);
  }

  /**
   * All walkable ground in bird's-eye view, beneath and behind things too: the paper's S*. Not free
   * space: a table stands on walkable ground. Occupied is what is not ground, where it borders on ground
   * or is at most 1 m behind the visible surface. Parameters and errors as for `topDown`.
   */
  walkableBehindThings(cellM = 0.05, rangeM = 10): OccupancyGrid {
    return makeWalkableGrid(this, cellM, rangeM);
  }

  /**
   * The distance to the nearest obstacle by bearing, as a laser scanner reports it.
   *
   * @param bearingsDeg Degrees from straight ahead, left positive; every degree from -90 to 90 if not
   *   given.
   * @param robotHeightM As for `topDown`; obstacles follow the same rule.
   * @throws GroundPlaneError If there is no ground plane.
   */
  scan(bearingsDeg: readonly number[] = EVERY_DEGREE, { robotHeightM = ROBOT_HEIGHT_M } = {}): RangeScan {
    return scan(this, bearingsDeg, robotHeightM);
  }

  /**
   * The cheapest path over the ground, with the paper's cost of 1 - s*, per metre. It lies on the ground
   * plane, in the cells of `topDown`: it never leaves the ground, and passes no obstacle.
   *
   * @param start x and y in pixels of the picture, or with `unit: "m"` forward and left in metres.
   * @param goal Likewise.
   * @throws OutsideError If an end is outside the picture.
   * @throws OffGroundError If one is not on ground, where an obstacle stands, or closer to one than the
   *   margin.
   * @throws NoPathError If no path connects them.
   * @throws PlanningError Base class of these; also if an argument is invalid.
   * @throws GroundPlaneError If there is no ground plane.
   */
  plan(
    start: Pair,
    goal: Pair,
    { unit = "px", marginM = 0, ground = "all", robotHeightM = ROBOT_HEIGHT_M }: PlanOptions = {},
  ): GroundPath {
    return findPath(this, start, goal, { unit, marginM, ground, robotHeightM });
  }

  /** The same prediction with maps at another size. */
  atSize(size: Size): Prediction {
    return new Prediction(this.dataAtSize(size));
  }

  /** The same prediction with maps at the picture's full size. */
  atImageSize(): Prediction {
    return this.atSize(this.imageSize);
  }
}

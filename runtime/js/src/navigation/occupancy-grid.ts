/** The ground in bird's-eye view: a metric occupancy grid. */

import type { Mask } from "../foundation/types.ts";
import type { GroundPlane } from "../geometry/ground-plane.ts";
import type { GroundMaps } from "../maps/ground-maps.ts";
import { findObstacles, type Obstacles } from "./obstacles.ts";

/** Cell values: unknown, obstacle, visible ground, hidden ground. */
export const [UNKNOWN, OCCUPIED, VISIBLE, HIDDEN] = [0, 1, 2, 3];

/** Most cells in the range of a grid, which has 2 * 1500 * 1500 of them then. */
const MAX_CELLS = 1500;

/**
 * In the grid of "walkable behind things", a cell without ground counts as occupied up to this distance
 * behind the visible surface, the depth of most furniture; farther on it is unknown.
 */
const OBSTACLE_DEPTH_M = 1;

/**
 * An occupancy grid on the ground plane. The cell at row r and column c is the square around
 *
 *     x = (rows - r - 0.5) * cellM,    y = (columns / 2 - c - 0.5) * cellM
 *
 * forward and left in metres from the point below the camera, which looks from below the middle of the
 * last row towards the first.
 */
export class OccupancyGrid {
  /** `UNKNOWN`, `OCCUPIED`, `VISIBLE` or `HIDDEN`, row by row. */
  readonly cells: Uint8Array;
  readonly rows: number;
  readonly columns: number;
  /** Side of a cell, metres. */
  readonly cellM: number;
  readonly plane: GroundPlane;

  constructor(cells: Uint8Array, rows: number, cellM: number, plane: GroundPlane) {
    this.cells = cells;
    this.rows = rows;
    this.columns = 2 * rows;
    this.cellM = cellM;
    this.plane = plane;
  }

  /** 1 where a cell is visible ground without an obstacle. */
  get free(): Mask {
    return this.cells.map((each) => Number(each === VISIBLE));
  }

  /** 1 where a cell is ground without an obstacle, visible or hidden. */
  get walkable(): Mask {
    return this.cells.map((each) => Number(each >= VISIBLE));
  }

  /** Area of the free cells in square metres. */
  get freeAreaM2(): number {
    return this.cells.filter((each) => each === VISIBLE).length * this.cellM ** 2;
  }

  /** Area of the cells of hidden ground in square metres. */
  get hiddenAreaM2(): number {
    return this.cells.filter((each) => each === HIDDEN).length * this.cellM ** 2;
  }

  /** Forward and left of the centre of a cell, metres. */
  placeM(cell: number): [number, number] {
    const column = cell % this.columns;
    const row = (cell - column) / this.columns;
    return [(this.rows - row - 0.5) * this.cellM, (this.rows - column - 0.5) * this.cellM];
  }

  /** The cell in which a place lies; places beyond the border count as on it. */
  cellAt(forwardM: number, leftM: number): number {
    const within = (value: number, count: number) => Math.min(count - 1, Math.max(0, Math.floor(value)));
    const row = within(this.rows - forwardM / this.cellM, this.rows);
    return row * this.columns + within(this.rows - leftM / this.cellM, this.columns);
  }

  /**
   * Distance to the first occupied cell in each direction.
   *
   * @param bearingsDeg Degrees from straight ahead, left positive (REP-103).
   * @returns Metres from the point below the camera, accurate to half a cell; infinite in directions
   *   without an occupied cell, NaN for NaN.
   */
  nearestObstacleM(bearingsDeg: readonly number[]): Float32Array {
    const quarters = 4 * Math.hypot(this.rows, this.columns);
    return Float32Array.from(bearingsDeg, (bearingDeg) => {
      if (!Number.isFinite(bearingDeg)) return NaN;
      const angle = (bearingDeg * Math.PI) / 180;
      for (let i = 0; i < quarters; i++) {
        const row = Math.floor(this.rows - (Math.cos(angle) * i) / 4);
        const column = Math.floor(this.rows - (Math.sin(angle) * i) / 4);
        const isInside = row >= 0 && row < this.rows && column >= 0 && column < this.columns;
        if (isInside && this.cells[row * this.columns + column] === OCCUPIED) return (i / 4) * this.cellM;
      }
      return Infinity;
    });
  }
}

/** The grid of a prediction; see `Prediction.topDown`. */
export function makeOccupancyGrid(
  maps: GroundMaps,
  cellM: number,
  rangeM: number,
  robotHeightM: number,
): OccupancyGrid {
  checkSizes(cellM, rangeM);
  return gridWith(maps, findObstacles(maps, robotHeightM), cellM, rangeM);
}

/** The grid of a prediction whose obstacles are known already. */
export function gridWith(
  maps: GroundMaps,
  obstacles: Obstacles,
  cellM: number,
  rangeM: number,
): OccupancyGrid {
  const { grid, pixels } = groundCells(maps, cellM, rangeM);
  pixels.forEach((pixel, cell) => {
    // a table top called ground: what is beneath it is not seen
    if (pixel >= 0 && obstacles.raised[pixel]) grid.cells[cell] = UNKNOWN;
  });
  obstacles.cover(grid.rows, cellM, (cell) => {
    if (Math.hypot(...grid.placeM(cell)) <= rangeM) grid.cells[cell] = OCCUPIED;
  });
  return grid;
}

/** The grid of "walkable behind things"; see `Prediction.walkableBehindThings`. */
export function makeWalkableGrid(maps: GroundMaps, cellM: number, rangeM: number): OccupancyGrid {
  checkSizes(cellM, rangeM);
  const { grid, pixels } = groundCells(maps, cellM, rangeM);
  const { cells, rows, columns, plane } = grid;
  const { intrinsics: camera, visibleDepthM } = maps;
  const { width } = maps.mapSize;
  const [ahead, aside] = plane.axes;
  pixels.forEach((pixel, cell) => {
    if (pixel < 0 || cells[cell] !== UNKNOWN) return;
    const column = pixel % width;
    const x = (column - camera.cx) / camera.fx;
    const y = ((pixel - column) / width - camera.cy) / camera.fy;
    const surfaceM =
      visibleDepthM[pixel] *
      Math.hypot(ahead[0] * x + ahead[1] * y + ahead[2], aside[0] * x + aside[1] * y + aside[2]);
    if (Math.hypot(...grid.placeM(cell)) - surfaceM <= OBSTACLE_DEPTH_M) cells[cell] = OCCUPIED;
  });
  const ground = grid.walkable;
  const isNearGround = (cell: number) => {
    const column = cell % columns;
    const row = (cell - column) / columns;
    for (let r = Math.max(0, row - 1); r <= Math.min(rows - 1, row + 1); r++) {
      for (let c = Math.max(0, column - 1); c <= Math.min(columns - 1, column + 1); c++) {
        if (ground[r * columns + c]) return true;
      }
    }
    return false;
  };
  pixels.forEach((pixel, cell) => {
    // something ends the ground here
    if (pixel >= 0 && cells[cell] < VISIBLE && isNearGround(cell)) cells[cell] = OCCUPIED;
  });
  return grid;
}

function checkSizes(cellM: number, rangeM: number): void {
  if (!(Number.isFinite(rangeM) && cellM > 0 && cellM <= rangeM && rangeM <= MAX_CELLS * cellM)) {
    throw new RangeError(
      `cellM is ${cellM}, rangeM is ${rangeM}; give positive numbers of metres, with 1 to ${MAX_CELLS} ` +
        "cells in the range",
    );
  }
}

/** Looks up the ground below the centre of every cell; `pixels` are -1 for cells out of view. */
function groundCells(maps: GroundMaps, cellM: number, rangeM: number) {
  const rows = Math.ceil(rangeM / cellM - 1e-6); // 1.1 / 0.1 is a little more than 11
  const plane = maps.groundPlane();
  const grid = new OccupancyGrid(new Uint8Array(2 * rows * rows), rows, cellM, plane);
  const pixels = new Int32Array(grid.cells.length).fill(-1);
  const project = plane.projection(maps.intrinsics);
  const { height, width } = maps.mapSize;
  for (let cell = 0; cell < pixels.length; cell++) {
    const [forwardM, leftM] = grid.placeM(cell);
    if (Math.hypot(forwardM, leftM) > rangeM) continue;
    const [x, y] = project(forwardM, leftM);
    if (!(x >= -0.5 && x < width - 0.5 && y >= -0.5 && y < height - 0.5)) continue;
    const pixel = Math.floor(y + 0.5) * width + Math.floor(x + 0.5);
    pixels[cell] = pixel;
    if (maps.ground[pixel]) grid.cells[cell] = maps.hiddenGround[pixel] ? HIDDEN : VISIBLE;
  }
  return { grid, pixels };
}

/** Paths over the ground, also where it is hidden (the paper's "Use case: Path Planning"). */

import { NoPathError, OffGroundError, OutsideError, PlanningError } from "../errors.ts";
import type { Mask, Pair } from "../foundation/types.ts";
import type { GroundPlane } from "../geometry/ground-plane.ts";
import type { GroundMaps } from "../maps/ground-maps.ts";
import { cheapestRoute } from "./cheapest-route.ts";
import { distanceTo } from "./distance-transform.ts";
import { findObstacles, type Obstacles } from "./obstacles.ts";
import { gridWith, HIDDEN, OCCUPIED, UNKNOWN, VISIBLE, type OccupancyGrid } from "./occupancy-grid.ts";

/** Added to every cell's cost: where probabilities round to 1, the shortest path wins. */
const STEP_COST = 0.01;

/** Side of a cell; larger where the ends are more than 20 m away, so that the graph stays small. */
const [CELL_M, CELLS_AHEAD] = [0.05, 400];

const FARTHEST_M = 100;

/** The grid reaches this much farther than the farther end: a factor, and metres. */
const [DETOUR, DETOUR_M] = [1.25, 2];

export interface PlanOptions {
  /** `px`: ends are x and y in pixels of the picture; `m`: forward and left in metres on the ground. */
  unit?: "px" | "m" | undefined;
  /** Distance to keep from everything that is not ground, metres, such as half of the robot's width. */
  marginM?: number | undefined;
  /** `visible` to stay on visible ground. */
  ground?: "all" | "visible" | undefined;
  /** As for `topDown`; obstacles follow the same rule. */
  robotHeightM?: number | undefined;
}

/** All of the options. */
type Chosen = { [name in keyof PlanOptions]-?: Exclude<PlanOptions[name], undefined> };

/** A path over the ground, from start to goal; its points are at most a cell apart. */
export interface GroundPath {
  /** x and y in pixels of the picture; [0, 0] is the centre of its top left pixel. */
  pixels: [number, number][];
  /** The same points on the ground plane: forward and left, metres, from the point below the camera. */
  placesM: [number, number][];
  /** For each point, whether the ground is hidden behind something. */
  hidden: boolean[];
  passesHiddenGround: boolean;
  /** The integral of `1 - s* + STEP_COST` along the path, metres. */
  cost: number;
  /** Length on the ground plane, metres. */
  lengthM: number;
}

/** Finds the cheapest path over the ground; see `Prediction.plan`. */
export function findPath(
  maps: GroundMaps,
  start: Pair,
  goal: Pair,
  { unit, marginM, ground, robotHeightM }: Chosen,
): GroundPath {
  if (!["px", "m"].includes(unit)) throw new PlanningError(`unit is ${unit}; give "px" or "m"`);
  if (!["all", "visible"].includes(ground)) {
    throw new PlanningError(`ground is ${ground}; give "all" or "visible"`);
  }
  if (!(Number.isFinite(marginM) && marginM >= 0)) {
    throw new PlanningError(`marginM is ${marginM}; give metres, 0 or more`);
  }
  const plane = maps.groundPlane();
  const obstacles = findObstacles(maps, robotHeightM);
  const ends = [
    endAt(maps, plane, obstacles, start, "start", unit, ground),
    endAt(maps, plane, obstacles, goal, "goal", unit, ground),
  ];
  const reachM = DETOUR * Math.max(...ends.map(({ placeM }) => Math.hypot(...placeM))) + DETOUR_M;
  const cellM = Math.max(CELL_M, reachM / CELLS_AHEAD);
  const grid = gridWith(maps, obstacles, cellM, reachM);
  const { cells, columns } = grid;
  for (const { placeM, pixel } of ends) {
    const cell = grid.cellAt(...placeM);
    // its centre is not in view, or beyond the ground's edge
    if (cells[cell] === UNKNOWN) cells[cell] = maps.visibleGround[pixel] ? VISIBLE : HIDDEN;
  }
  const open = cells.map((each) => Number(ground === "visible" ? each === VISIBLE : each >= VISIBLE));
  const { cost, inView } = costsOf(maps, grid, ground);
  const safe = marginM > 0 ? withMargin(open, cells, inView, columns, marginM / cellM) : open;
  for (const { placeM, where } of ends) {
    const cell = grid.cellAt(...placeM);
    if (!open[cell]) {
      const what = cells[cell] === OCCUPIED ? "where an obstacle stands" : "not on visible ground";
      throw new OffGroundError(`${where} is ${what}; choose another point`);
    }
    if (!safe[cell]) {
      throw new OffGroundError(
        `${where} is closer than marginM=${marginM} to an obstacle; choose another point, or a smaller ` +
          "margin",
      );
    }
  }
  const costs = cost.map((each, cell) => (safe[cell] ? each : -1));
  const [from, to] = ends.map(({ placeM }) => grid.cellAt(...placeM));
  const route = cheapestRoute(costs, columns, from, to);
  if (route === null) {
    throw new NoPathError(
      `no path on ${ground === "visible" ? "visible " : ""}ground connects ${ends[0].where} and ` +
        `${ends[1].where} with marginM=${marginM}; try a smaller margin, a lower threshold, or other points`,
    );
  }
  // An end's line to the next cell may cut the corner of a closed one; to its own cell it cannot.
  const cornersM = [ends[0].placeM, ...route.map((cell) => grid.placeM(cell)), ends[1].placeM];
  const linesM = shortened(cornersM, costs, grid);
  const placesM = dense(linesM, cellM);
  const hidden = placesM.map((placeM) => cells[grid.cellAt(...placeM)] === HIDDEN);
  const project = plane.projection(maps.intrinsics);
  return {
    pixels: placesM.map((placeM) => toPicture(maps, project(...placeM))),
    placesM,
    hidden,
    passesHiddenGround: hidden.includes(true),
    cost: lineCost(linesM, costs, grid),
    lengthM: placesM.slice(1).reduce((sum, place, i) => sum + apart(place, placesM[i]), 0),
  };
}

/** A start or goal in view, on ground: forward and left, metres, its pixel, and its name. */
function endAt(
  maps: GroundMaps,
  plane: GroundPlane,
  { raised }: Obstacles,
  given: Pair,
  name: string,
  unit: "px" | "m",
  ground: "all" | "visible",
): { placeM: [number, number]; pixel: number; where: string } {
  const { mapSize, imageSize, threshold, intrinsics } = maps;
  if (!(given.length === 2 && given.every(Number.isFinite))) {
    throw new PlanningError(`the ${name} is [${given}]; give two finite numbers`);
  }
  const where = `the ${name} (${given[0]}, ${given[1]}) ${unit}`;
  const [x, y] = unit === "m" ? plane.toPixel(given, intrinsics) : toMaps(maps, given);
  const { height, width } = mapSize;
  if (!(x >= -0.5 && x < width - 0.5 && y >= -0.5 && y < height - 0.5)) {
    throw new OutsideError(
      `${where} is outside the picture of ${imageSize.width} x ${imageSize.height} px; choose a point ` +
        "in view",
    );
  }
  const pixel = Math.floor(y + 0.5) * width + Math.floor(x + 0.5);
  const seen = ground === "visible";
  if (!(seen ? maps.visibleGround : maps.ground)[pixel]) {
    const probability = (seen ? maps.visibleGroundProbability : maps.groundProbability)[pixel];
    throw new OffGroundError(
      `${where} is not on ${seen ? "visible " : ""}ground (probability ${probability.toFixed(2)}, ` +
        `threshold ${threshold}); choose another point`,
    );
  }
  if (raised[pixel]) {
    throw new OffGroundError(
      `${where} is not on ground: what is seen there lies too high above the ground plane, such as a ` +
        "table top; choose another point",
    );
  }
  const placeM: [number, number] = unit === "m" ? [...given] : plane.atPixel([x, y], intrinsics);
  if (!(Math.hypot(...placeM) <= FARTHEST_M)) {
    throw new OffGroundError(
      `${where} is at the horizon of the ground plane, or more than ${FARTHEST_M} m away; choose a ` +
        "nearer point",
    );
  }
  return { placeM, pixel, where };
}

/** From pixels of the picture to pixels of the maps. */
function toMaps({ imageSize, mapSize }: GroundMaps, [x, y]: Pair): [number, number] {
  return [
    ((x + 0.5) * mapSize.width) / imageSize.width - 0.5,
    ((y + 0.5) * mapSize.height) / imageSize.height - 0.5,
  ];
}

function toPicture({ imageSize, mapSize }: GroundMaps, [x, y]: Pair): [number, number] {
  return [
    ((x + 0.5) * imageSize.width) / mapSize.width - 0.5,
    ((y + 0.5) * imageSize.height) / mapSize.height - 0.5,
  ];
}

/** The cost of a metre in each cell, and the cells that the picture shows. */
function costsOf(maps: GroundMaps, grid: OccupancyGrid, ground: "all" | "visible") {
  const probability = ground === "visible" ? maps.visibleGroundProbability : maps.groundProbability;
  const project = grid.plane.projection(maps.intrinsics);
  const { height, width } = maps.mapSize;
  const inView = new Uint8Array(grid.cells.length);
  const cost = new Float64Array(grid.cells.length).fill(1);
  for (let cell = 0; cell < cost.length; cell++) {
    const [x, y] = project(...grid.placeM(cell));
    const [column, row] = [Math.floor(x + 0.5), Math.floor(y + 0.5)];
    if (!(row >= 0 && row < height && column >= 0 && column < width)) continue;
    inView[cell] = 1;
    cost[cell] = 1 - probability[row * width + column] + STEP_COST;
  }
  return { cost, inView };
}

/**
 * The open cells that keep a margin, in cells. The picture's border is no obstacle; an obstacle may
 * reach a cell beyond its cells' centres.
 */
function withMargin(open: Mask, cells: Uint8Array, inView: Mask, columns: number, margin: number): Mask {
  const closed = cells.map((each, i) => Number((inView[i] && !open[i]) || each === OCCUPIED));
  const away = distanceTo(closed, columns);
  return open.map((each, i) => each & Number(away[i] - 1 >= margin));
}

function apart(a: Pair, b: Pair): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}

/** Points along straight lines between corners, at most a step apart. */
function dense(cornersM: [number, number][], stepM: number): [number, number][] {
  const points = [cornersM[0]];
  for (let i = 1; i < cornersM.length; i++) {
    const [begin, end] = [cornersM[i - 1], cornersM[i]];
    const count = Math.max(1, Math.ceil(apart(begin, end) / stepM));
    for (let k = 1; k <= count; k++) {
      const share = k / count;
      points.push([begin[0] + share * (end[0] - begin[0]), begin[1] + share * (end[1] - begin[1])]);
    }
  }
  return points;
}

/**
 * The cost of straight lines between corners; infinite if one leaves or touches what is closed.
 *
 * A line is followed in steps, which may cut a cell's corner or meet it exactly. So the cells beside a
 * diagonal passage, within three steps, must be open as well.
 */
function lineCost(cornersM: [number, number][], costs: Float64Array, grid: OccupancyGrid): number {
  let total = 0;
  for (let i = 1; i < cornersM.length; i++) {
    const points = dense([cornersM[i - 1], cornersM[i]], grid.cellM / 4);
    const at = points.slice(1).map((b, k) => {
      const a = points[k];
      return grid.cellAt((a[0] + b[0]) / 2, (a[1] + b[1]) / 2);
    });
    for (let k = 0; k < at.length; k++) {
      const [cell, later] = [at[k], at[Math.min(k + 2, at.length - 1)]];
      const [column, laterColumn] = [cell % grid.columns, later % grid.columns];
      const beside = [cell - column + laterColumn, later - laterColumn + column];
      if (costs[cell] < 0 || beside.some((each) => costs[each] < 0)) return Infinity;
      total += costs[cell] * apart(points[k], points[k + 1]);
    }
  }
  return total;
}

/** Replaces steps from cell to cell by straight lines, where these are open and no dearer. */
function shortened(
  cornersM: [number, number][],
  costs: Float64Array,
  grid: OccupancyGrid,
): [number, number][] {
  const steps = cornersM.slice(1).map((corner, i) => lineCost([cornersM[i], corner], costs, grid));
  const kept = [cornersM[0]];
  for (let begin = 0; begin < cornersM.length - 1; ) {
    let end = begin + 1;
    let detour = steps[begin];
    while (end + 1 < cornersM.length) {
      const longer = detour + steps[end];
      const straight = lineCost([cornersM[begin], cornersM[end + 1]], costs, grid);
      if (!(straight <= longer * (1 + 1e-6))) break;
      end++;
      detour = longer;
    }
    kept.push(cornersM[end]);
    begin = end;
  }
  return kept;
}

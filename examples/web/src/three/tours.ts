/** Where to walk if nobody says where: as far behind things as the floor leads. */

import { HIDDEN, PlanningError, type GroundPath, type Prediction, VISIBLE } from "footprints-edge";

/** Farther away, the walker is small. */
const FARTHEST_M = 5.5;

/** So many goals are tried. */
const TRIED = 60;

/** The path that is hidden for longest, from the nearest free floor; null if there is none. */
export function hiddenTour(prediction: Prediction, walkerM: number): GroundPath | null {
  const grid = prediction.topDown(0.05, FARTHEST_M, { robotHeightM: walkerM });
  const places = (value: number) =>
    [...grid.cells.keys()].filter((cell) => grid.cells[cell] === value).map((cell) => grid.placeM(cell));
  const start = places(VISIBLE).sort((a, b) => Math.hypot(...a) - Math.hypot(...b))[0];
  if (!start) return null;
  const goals = places(HIDDEN);
  const paths = Array.from({ length: Math.min(TRIED, goals.length) }, (_, i) =>
    pathTo(prediction, start, goals[Math.floor((i * goals.length) / Math.min(TRIED, goals.length))], walkerM),
  ).filter((path) => path !== null);
  return paths.sort((a, b) => hiddenM(b) - hiddenM(a))[0] ?? null;
}

/** The path to a goal, metres; null if there is none. */
export function pathTo(
  prediction: Prediction,
  start: readonly [number, number],
  goal: readonly [number, number],
  walkerM: number,
): GroundPath | null {
  try {
    return prediction.plan(start, goal, { unit: "m", robotHeightM: walkerM });
  } catch (error) {
    if (error instanceof PlanningError) return null;
    throw error;
  }
}

function hiddenM({ hidden, lengthM }: GroundPath): number {
  return (hidden.filter(Boolean).length / hidden.length) * lengthM;
}

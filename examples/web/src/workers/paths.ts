/** Paths from where one stands. */

import {
  GroundPlaneError,
  NoPathError,
  OCCUPIED,
  OffGroundError,
  type GroundPath,
  type OccupancyGrid,
  type Prediction,
} from "footprints-edge";

import type { NoPath, Point } from "../messages";

/** The cheapest path from the free ground nearest to the bottom centre of the picture. */
export function findPath(prediction: Prediction, goal: Point): GroundPath | NoPath {
  if (!prediction.showsGround) return "no ground";
  const { width, height } = prediction.imageSize;
  const end = [goal.x * width - 0.5, goal.y * height - 0.5] as const;
  if (prediction.at(end).ground === "none") return "goal off ground";
  try {
    const start = standingPlace(prediction, prediction.topDown());
    return start ? prediction.plan(start, end) : "no ground";
  } catch (error) {
    if (error instanceof GroundPlaneError) return "no plane";
    if (error instanceof OffGroundError) return "goal taken"; // ground, but something stands there
    if (error instanceof NoPathError) return "no way";
    throw error;
  }
}

/** The pixel of the picture in which one stands; null where there is no free ground. */
function standingPlace(prediction: Prediction, grid: OccupancyGrid): [number, number] | null {
  const { mapSize, imageSize, ground, intrinsics } = prediction;
  const perMapPx = imageSize.width / mapSize.width;
  const centre = (mapSize.width - 1) / 2;
  let best: [number, number] | null = null;
  let least = Infinity;
  ground.forEach((isGround, pixel) => {
    if (!isGround) return;
    const x = pixel % mapSize.width;
    const y = (pixel - x) / mapSize.width;
    const distance = (x - centre) ** 2 + (mapSize.height - 1 - y) ** 2;
    if (distance >= least) return;
    const placeM = grid.plane.atPixel([x, y], intrinsics);
    if (grid.cells[grid.cellAt(...placeM)] === OCCUPIED) return;
    best = [(x + 0.5) * perMapPx - 0.5, ((y + 0.5) * imageSize.height) / mapSize.height - 0.5];
    least = distance;
  });
  return best;
}

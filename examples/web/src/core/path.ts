/** Paths over the ground, also where it is hidden, at the paper's cost: 1 - s* for every pixel. */

import { GroundPlane } from "./ground-plane";
import { pixelAt, placeAt, THRESHOLD, type Maps, type Point } from "./maps";

/** Added to every pixel's cost: where probabilities round to 1, the shortest way wins. */
const STEP_COST = 0.01;

/** A way over the ground. */
export interface GroundPath {
  /** From start to goal, one for each pixel of the maps. */
  points: Point[];
  /** For each point, whether something stands in front of the ground there. */
  hidden: boolean[];
  /** Over its steps: the step's length times the mean of 1 - s* + STEP_COST at its two ends. */
  cost: number;
  /** Length on the plane of the ground, metres; null where there is too little ground for one. */
  lengthM: number | null;
}

/** Why there is no path. */
export type NoPath = "goal off ground" | "no ground" | "no way";

/**
 * The cheapest path from where one stands, the ground nearest to the bottom centre of the picture.
 */
export function findPath(maps: Maps, goal: Point): GroundPath | NoPath {
  const end = pixelAt(maps, goal);
  if (!(maps.groundProbability[end] > THRESHOLD)) return "goal off ground";
  const start = standingPlace(maps);
  if (start === null) return "no ground";
  const found = cheapest(maps, start, end);
  if (found === null) return "no way";
  return {
    points: found.pixels.map((pixel) => {
      const { x, y } = placeOf(pixel, maps.width);
      return { x: (x + 0.5) / maps.width, y: (y + 0.5) / maps.height };
    }),
    hidden: found.pixels.map((pixel) => placeAt(maps, pixel) === "hidden"),
    cost: found.cost,
    lengthM: lengthM(maps, found.pixels),
  };
}

/** The pixel of ground nearest to the bottom centre; null where there is no ground. */
function standingPlace(maps: Maps): number | null {
  const centre = (maps.width - 1) / 2;
  let best: number | null = null;
  let least = Infinity;
  maps.groundProbability.forEach((probability, pixel) => {
    if (!(probability > THRESHOLD)) return;
    const { x, y } = placeOf(pixel, maps.width);
    const distance = (x - centre) ** 2 + (maps.height - 1 - y) ** 2;
    if (distance < least) [best, least] = [pixel, distance];
  });
  return best;
}

/** Dijkstra's search over the eight neighbours of every pixel. */
function cheapest(
  maps: Maps,
  start: number,
  end: number,
): { pixels: number[]; cost: number } | null {
  const { height, width, groundProbability } = maps;
  const totals = new Float64Array(height * width).fill(Infinity);
  const before = new Int32Array(height * width).fill(-1);
  const done = new Uint8Array(height * width);
  const queue = new Queue();
  totals[start] = 0;
  queue.push(start, 0);
  for (let pixel = queue.pop(); pixel !== undefined; pixel = queue.pop()) {
    if (pixel === end) return { pixels: traced(before, end), cost: totals[end] };
    if (done[pixel]) continue;
    done[pixel] = 1;
    const column = pixel % width;
    const row = (pixel - column) / width;
    const cost = 1 - groundProbability[pixel] + STEP_COST;
    for (let y = Math.max(0, row - 1); y <= Math.min(height - 1, row + 1); y++) {
      for (let x = Math.max(0, column - 1); x <= Math.min(width - 1, column + 1); x++) {
        const next = y * width + x;
        if (done[next] || !(groundProbability[next] > THRESHOLD)) continue;
        const step = x !== column && y !== row ? Math.SQRT2 : 1;
        const mean = (cost + 1 - groundProbability[next] + STEP_COST) / 2;
        const total = totals[pixel] + step * mean;
        if (total >= totals[next]) continue;
        totals[next] = total;
        before[next] = pixel;
        queue.push(next, total);
      }
    }
  }
  return null;
}

function traced(before: Int32Array, end: number): number[] {
  const pixels = [];
  for (let pixel = end; pixel >= 0; pixel = before[pixel]) pixels.push(pixel);
  return pixels.reverse();
}

/** Column and row of a pixel. */
function placeOf(pixel: number, width: number): { x: number; y: number } {
  const x = pixel % width;
  return { x, y: (pixel - x) / width };
}

function lengthM(maps: Maps, pixels: number[]): number | null {
  const plane = GroundPlane.fit(maps);
  if (!plane) return null;
  const places = pixels.map((pixel) => plane.at(pixel));
  const total = places
    .slice(1)
    .reduce((sum, to, i) => sum + Math.hypot(...to.map((each, axis) => each - places[i][axis])), 0);
  return Number.isFinite(total) ? total : null;
}

/** A binary heap: the pixel with the least total comes out first. */
class Queue {
  private pixels: number[] = [];
  private totals: number[] = [];

  push(pixel: number, total: number): void {
    let at = this.pixels.length;
    while (at > 0) {
      const parent = (at - 1) >> 1;
      if (this.totals[parent] <= total) break;
      this.pixels[at] = this.pixels[parent];
      this.totals[at] = this.totals[parent];
      at = parent;
    }
    this.pixels[at] = pixel;
    this.totals[at] = total;
  }

  pop(): number | undefined {
    const first = this.pixels[0];
    const pixel = this.pixels.pop();
    const total = this.totals.pop();
    if (pixel === undefined || total === undefined || this.pixels.length === 0) return first;
    const length = this.pixels.length;
    let at = 0;
    for (;;) {
      let child = 2 * at + 1;
      if (child >= length) break;
      if (child + 1 < length && this.totals[child + 1] < this.totals[child]) child++;
      if (this.totals[child] >= total) break;
      this.pixels[at] = this.pixels[child];
      this.totals[at] = this.totals[child];
      at = child;
    }
    this.pixels[at] = pixel;
    this.totals[at] = total;
    return first;
  }
}

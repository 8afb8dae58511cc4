/** From a network's four sigmoid maps to probabilities and metres. */

import { disparityToDepth, type Intrinsics } from "./camera";
import type { ModelFacts } from "./model-facts";
import type { Size } from "./resize";

/** Probability above which a pixel counts as ground. */
export const THRESHOLD = 0.5;

/** What the network says about every pixel of a picture, row by row. */
export interface Maps extends Size {
  /** That the surface seen here is walkable (the paper's S). */
  visibleGroundProbability: Float32Array;
  /** That the ray meets walkable ground, seen or hidden (the paper's S*). */
  groundProbability: Float32Array;
  /** Metres along the optical axis to what is seen. */
  visibleDepthM: Float32Array;
  /** Metres along the optical axis to the ground; means something only where there is ground. */
  groundDepthM: Float32Array;
  /** The camera in the maps' own pixels. */
  camera: Intrinsics;
}

/**
 * Reads the network's output in the units that the model file states. Depths are those of the
 * camera that the network was trained for: they grow with the focal length of this one.
 *
 * @param output float32 [1, 4, height, width].
 * @param camera The picture's camera, in the pixels of `size`.
 */
export function readMaps(
  output: Float32Array,
  size: Size,
  facts: ModelFacts,
  camera: Intrinsics,
): Maps {
  const pixels = size.height * size.width;
  const scale = facts.focalPx === null ? 1 : Math.sqrt(camera.fx * camera.fy) / facts.focalPx;
  const [nearestM, farthestM] = facts.depthRangeM.map((bound) => scale * bound);
  const channel = (index: number) => output.slice(index * pixels, (index + 1) * pixels);
  const metres = (index: number) => {
    const values = channel(index);
    for (let i = 0; i < pixels; i++) values[i] = disparityToDepth(values[i], nearestM, farthestM);
    return values;
  };
  return {
    ...size,
    visibleGroundProbability: channel(0),
    groundProbability: channel(1),
    visibleDepthM: metres(2),
    groundDepthM: metres(3),
    camera,
  };
}

/** What there is at one pixel of the maps. */
export type Place = "visible" | "hidden" | "none";

/** Whether one can walk at a pixel, and whether something stands in front. */
export function placeAt(maps: Maps, pixel: number): Place {
  if (maps.visibleGroundProbability[pixel] > THRESHOLD) return "visible";
  return maps.groundProbability[pixel] > THRESHOLD ? "hidden" : "none";
}

/** A place in a picture, as fractions of its sides: (0, 0) is its top left corner, (1, 1) the other. */
export interface Point {
  x: number;
  y: number;
}

/** The pixel of the maps that a place is in; places beyond the border count as on it. */
export function pixelAt({ height, width }: Size, { x, y }: Point): number {
  const within = (value: number, count: number) =>
    Math.min(count - 1, Math.max(0, Math.floor(value * count)));
  return within(y, height) * width + within(x, width);
}

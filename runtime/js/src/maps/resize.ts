/** Resizing of maps. */

import type { Size } from "../foundation/types.ts";
import { tapsOf, type Taps } from "../inputs/resize.ts";

/** Resizes a map: bilinear, antialiased when it shrinks, as Pillow does with floats. */
export function resizeMap(values: Float32Array, from: Size, to: Size): Float32Array {
  const narrow = new Float32Array(from.height * to.width);
  apply(tapsOf(from.width, to.width, "bilinear"), values, narrow, from.height, [from.width, 1], [to.width, 1]);
  const result = new Float32Array(to.height * to.width);
  apply(tapsOf(from.height, to.height, "bilinear"), narrow, result, to.width, [1, to.width], [1, to.width]);
  return result;
}

/**
 * Resizes a depth map as inverse depth. Along a plane the inverse depth is affine in the pixel, so
 * interpolation keeps planes flat.
 */
export function resizeDepth(depthM: Float32Array, from: Size, to: Size): Float32Array {
  const inverse = resizeMap(depthM.map((each) => 1 / each), from, to);
  return inverse.map((each) => 1 / each);
}

/** One pass over lines; `step` is how far apart lines, and values within a line, lie. */
function apply(
  { first, count, weights, stride }: Taps,
  values: Float32Array,
  result: Float32Array,
  lines: number,
  [readLine, readStep]: [number, number],
  [writeLine, writeStep]: [number, number],
): void {
  for (let line = 0; line < lines; line++) {
    for (let i = 0; i < first.length; i++) {
      let sum = 0;
      for (let k = 0; k < count[i]; k++) {
        sum += weights[i * stride + k] * values[line * readLine + (first[i] + k) * readStep];
      }
      result[line * writeLine + i * writeStep] = sum;
    }
  }
}

/** Exact Euclidean distances in a grid (Felzenszwalb and Huttenlocher 2012). */

import type { Mask } from "../foundation/types.ts";

/** For each cell the distance, in cells, to the nearest cell that is 1; infinite if there is none. */
export function distanceTo(set: Mask, columns: number): Float64Array {
  const rows = set.length / columns;
  const squared = Float64Array.from(set, (each) => (each ? 0 : Infinity));
  for (let row = 0; row < rows; row++) alongLine(squared, row * columns, 1, columns);
  for (let column = 0; column < columns; column++) alongLine(squared, column, columns, rows);
  return squared.map(Math.sqrt);
}

/** The lower envelope of the parabolas that stand on a line's values, in place of the values. */
function alongLine(values: Float64Array, start: number, step: number, count: number): void {
  const line = Float64Array.from({ length: count }, (_, i) => values[start + i * step]);
  const places: number[] = [];
  const from: number[] = [];
  for (let i = 0; i < count; i++) {
    if (line[i] === Infinity) continue;
    let begin = -Infinity;
    while (places.length > 0) {
      const last = places[places.length - 1];
      begin = (line[i] + i * i - (line[last] + last * last)) / (2 * (i - last));
      if (begin > from[from.length - 1]) break;
      places.pop();
      from.pop();
      begin = -Infinity;
    }
    places.push(i);
    from.push(begin);
  }
  if (places.length === 0) return;
  for (let i = 0, k = 0; i < count; i++) {
    while (k + 1 < places.length && from[k + 1] < i) k++;
    values[start + i * step] = (i - places[k]) ** 2 + line[places[k]];
  }
}

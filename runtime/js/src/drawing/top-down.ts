/** Pictures of occupancy grids: a bird's-eye view in the colours of the overlay. */

import type { Pixels } from "../foundation/types.ts";
import { HIDDEN, OCCUPIED, VISIBLE, type OccupancyGrid } from "../navigation/occupancy-grid.ts";
import { COLOUR_SCALE, scalePosition } from "./colours.ts";

const UNKNOWN_COLOUR = [44, 48, 58];
const OCCUPIED_COLOUR = [8, 9, 13];
const RING_COLOUR = [128, 134, 146];
const GAP_COLOUR = [70, 70, 70];
const RINGS_M = [0.5, 1, 2, 3, 5, 10, 20, 50];

/**
 * Draws a grid: forward is up, left is left, the camera is in the middle of the lower border. Visible
 * ground is solid in the colour of its distance, hidden ground hatched, obstacles black, unknown cells
 * grey; rings mark 0.5, 1, 2, 3, 5, 10 ... metres.
 *
 * @param heightPx Height of the picture; it is twice as wide.
 * @returns Four bytes a pixel, as `ImageData` takes them.
 */
export function drawTopDown(
  grid: OccupancyGrid,
  heightPx: number,
): Pixels & { data: Uint8ClampedArray<ArrayBuffer> } {
  const width = 2 * heightPx;
  const data = new Uint8ClampedArray(4 * width * heightPx);
  const metresPerPx = (grid.rows * grid.cellM) / heightPx;
  const stripePx = 1.5 * Math.max(2, Math.floor(heightPx / 120));
  for (let y = 0, at = 0; y < heightPx; y++) {
    const row = Math.floor((y * grid.rows) / heightPx);
    const ahead = heightPx - y - 0.5;
    for (let x = 0; x < width; x++, at += 4) {
      const cell = grid.cells[row * grid.columns + Math.floor((x * grid.columns) / width)];
      const awayPx = Math.hypot(ahead, x + 0.5 - heightPx);
      let colour: ArrayLike<number> = UNKNOWN_COLOUR;
      if (cell === OCCUPIED) colour = OCCUPIED_COLOUR;
      else if (cell === VISIBLE || cell === HIDDEN) {
        const isGap = cell === HIDDEN && ((x + y) * Math.SQRT1_2) % (2 * stripePx) >= stripePx;
        const place = 3 * scalePosition(awayPx * metresPerPx);
        colour = isGap ? GAP_COLOUR : COLOUR_SCALE.subarray(place, place + 3);
      }
      if (RINGS_M.some((ringM) => Math.abs(awayPx - ringM / metresPerPx) < 0.5)) colour = RING_COLOUR;
      data.set([colour[0], colour[1], colour[2], 255], at);
    }
  }
  return { data, width, height: heightPx };
}

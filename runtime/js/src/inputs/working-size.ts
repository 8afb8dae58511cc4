/** The size at which a network with free input size looks at a picture. */

import type { Size } from "../foundation/types.ts";

/** Networks halve the picture five times: sides must be multiples of this. */
const STRIDE = 32;

/** Pixels that the network sees, whatever the picture's shape. */
const BUDGET_PX = 256 * 448;

const MOST_PX = Math.trunc(1.15 * BUDGET_PX);
const AREA_WEIGHT = 0.25;

/**
 * The size at which a network with free input size looks at a picture: of all pairs of multiples
 * of 32 the one that keeps the picture's shape and the budget best, 256 x 448 for 16:9. The same
 * rule as the Python runtime's `working_size`.
 */
export function workingSize(picture: Size): Size {
  if (picture.height > picture.width) {
    const wide = workingSize({ height: picture.width, width: picture.height });
    return { height: wide.width, width: wide.height };
  }
  const logAspect = Math.log(picture.width / picture.height);
  let best: Size = { height: 0, width: 0 };
  let least = Infinity;
  for (let height = 2 * STRIDE; height * height <= MOST_PX; height += STRIDE) {
    for (let width = height; height * width <= MOST_PX; width += STRIDE) {
      const squeeze = Math.abs(Math.log(width / height) - logAspect);
      const cost = squeeze + AREA_WEIGHT * Math.abs(Math.log((height * width) / BUDGET_PX));
      if (cost < least) [best, least] = [{ height, width }, cost];
    }
  }
  return best;
}

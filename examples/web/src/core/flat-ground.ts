/** Ground depth laid onto the ground's plane, where it lies near to it; as the Python runtime does. */

import { GroundPlane } from "./ground-plane";
import { THRESHOLD, type Maps } from "./maps";

/** Where the median of |ln(depth / depth of the plane)| over the ground is less, it is flat. */
const FLAT = 0.15;

/** Up to the first, a pixel is laid wholly onto the plane; from the second on, not at all. */
const WHOLLY = 0.4;
const NOT_AT_ALL = 0.8;

/** A median needs no more pixels than one in so many. */
const JUDGED_EVERY = 11;

/** The same maps with flat ground on its plane. Steps, platforms and what has no plane stay. */
export function flatten(maps: Maps): Maps {
  const plane = GroundPlane.fit(maps);
  if (!plane) return maps;
  const away = new Float32Array(maps.groundDepthM.length);
  const flat = maps.groundDepthM.map((depthM, pixel) => {
    const nearness = plane.nearnessAt(pixel);
    away[pixel] = nearness > 1e-4 ? Math.abs(Math.log(depthM * nearness)) : Infinity;
    const share = Math.min(Math.max((NOT_AT_ALL - away[pixel]) / (NOT_AT_ALL - WHOLLY), 0), 1);
    return share > 0 ? 1 / (share * nearness + (1 - share) / depthM) : depthM;
  });
  const onGround = away
    .filter((_, pixel) => pixel % JUDGED_EVERY === 0 && maps.groundProbability[pixel] > THRESHOLD)
    .sort();
  return onGround[onGround.length >> 1] < FLAT ? { ...maps, groundDepthM: flat } : maps;
}

/** Laying of the ground's depth onto the ground plane, where it lies close to it. */

import { GroundPlaneError } from "../errors.ts";
import { median } from "../foundation/median.ts";
import { knowsAnything, knowsEverything } from "../geometry/camera-pose.ts";
import type { GroundPlane } from "../geometry/ground-plane.ts";
import type { GroundMaps } from "../maps/ground-maps.ts";

/**
 * Bounds of a pixel's |ln(depth / plane's depth)|. Up to the first, it counts as the network's error
 * and the pixel moves onto the plane; from the second on, as another surface. In between, both mix.
 */
const [LAY_BELOW, KEEP_ABOVE] = [0.4, 0.8];

/** With a known pose all ground nearer than this lies on the plane; the rest keeps its depth. */
const FARTHEST_M = 100;

/** The new depth of the ground and the plane that it lies on; null where there is no plane. */
export function flattened(maps: GroundMaps): { depthM: Float32Array; plane: GroundPlane } | null {
  let plane: GroundPlane;
  try {
    plane = maps.groundPlane();
  } catch (error) {
    if (error instanceof GroundPlaneError) return null;
    throw error;
  }
  const onPlane = plane.inverseDepth(maps.intrinsics, maps.mapSize);
  const depthM = maps.unmaskedGroundDepthM.slice();
  if (knowsEverything(maps.pose)) {
    onPlane.forEach((inverse, i) => {
      if (inverse > 1 / FARTHEST_M) depthM[i] = 1 / inverse;
    });
    return { depthM, plane };
  }
  const deviation = onPlane.map((inverse, i) => Math.log((inverse > 1e-4 ? inverse : 1) * depthM[i]));
  const { ground } = maps;
  // a known height corrects the scale of the depth
  const shift = knowsAnything(maps.pose)
    ? median(new Float64Array(deviation.filter((_, i) => ground[i])))
    : 0;
  for (let i = 0; i < depthM.length; i++) {
    if (!(onPlane[i] > 1e-4)) continue;
    const away = Math.abs(deviation[i] - shift);
    const share = Math.min(1, Math.max(0, (KEEP_ABOVE - away) / (KEEP_ABOVE - LAY_BELOW)));
    const inverse = 1 / depthM[i];
    depthM[i] = 1 / (inverse + share * (onPlane[i] - inverse));
  }
  return { depthM, plane };
}

/** From a network's four sigmoid maps to probabilities and metres. */

import type { Size } from "../foundation/types.ts";
import { disparityToDepth, type Intrinsics } from "../geometry/camera.ts";
import type { ModelMetadata } from "../model-files/metadata.ts";

/** What the network says about every pixel, in units, before any threshold. */
export interface DecodedMaps {
  /** Probability that the surface seen here is walkable (the paper's S). */
  visibleGroundProbability: Float32Array;
  /** Probability that the ray meets walkable ground, seen or hidden (the paper's S*). */
  groundProbability: Float32Array;
  /** Metres along the optical axis to what is seen (the paper's D). */
  visibleDepthM: Float32Array;
  /** Metres along the optical axis to where ground would be (D*); meaningful only on ground. */
  unmaskedGroundDepthM: Float32Array;
}

/**
 * Reads the network's output in the units that the model file states. Depths are those of the camera
 * that the network was trained for: they grow with the focal length of this one.
 *
 * @param output float32 [1, 4, height, width].
 * @param camera In pixels of the maps.
 */
export function decodeMaps(
  output: Float32Array,
  { height, width }: Size,
  metadata: ModelMetadata,
  camera: Intrinsics,
): DecodedMaps {
  const pixels = height * width;
  const scale = metadata.focalPx === null ? 1 : Math.sqrt(camera.fx * camera.fy) / metadata.focalPx;
  const [nearestM, farthestM] = metadata.depthRangeM.map((bound) => scale * bound);
  const channel = (index: number) => output.slice(index * pixels, (index + 1) * pixels);
  const metres = (index: number) => {
    const values = channel(index);
    for (let i = 0; i < pixels; i++) values[i] = disparityToDepth(values[i], nearestM, farthestM);
    return values;
  };
  return {
    visibleGroundProbability: channel(0),
    groundProbability: channel(1),
    visibleDepthM: metres(2),
    unmaskedGroundDepthM: metres(3),
  };
}

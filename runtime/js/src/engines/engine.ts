/** What runs a model file. */

import { ModelError } from "../errors.ts";
import type { Size } from "../foundation/types.ts";

const MAPS = 4;

/** Values this far beyond 0 and 1 are rounding. */
const TOLERANCE = 1e-6;

export interface Engine {
  /** Package, version and provider. */
  readonly runtime: string;
  /** Threads of the processor that it uses; null where it leaves that to its library. */
  readonly threads: number | null;
  /** The size that the model file is fixed to; null where it takes any multiples of 32. */
  readonly inputSize: Size | null;
  /**
   * One forward pass.
   *
   * @param rgb Three bytes a pixel.
   * @param size Multiples of 32.
   * @returns float32 [1, 4, height, width]: probabilities of visible ground and of ground, then the
   *   sigmoid disparities of what is seen and of the ground.
   */
  run(rgb: Uint8Array, size: Size): Promise<Float32Array>;
  /** Frees its memory. */
  release(): Promise<void>;
}

/** The part of onnxruntime's sessions that the engines use; the same in both of its packages. */
export interface Session {
  readonly inputMetadata: readonly unknown[];
  run(feeds: Record<string, unknown>): Promise<Record<string, unknown>>;
  release(): Promise<void>;
}

/** The size that a session's input is fixed to; null if it is free. */
export function fixedSize(session: Session): Size | null {
  const { shape } = session.inputMetadata[0] as { shape?: readonly unknown[] };
  const [height, width] = [shape?.[1], shape?.[2]];
  const isFixed = typeof height === "number" && typeof width === "number" && height > 0 && width > 0;
  return isFixed ? { height, width } : null;
}

/**
 * What a network has given: four maps of its input's size, from 0 to 1. Rounding beyond is cut off in place.
 *
 * @throws ModelError If it is anything else.
 */
export function checkedMaps(maps: Float32Array, { height, width }: Size): Float32Array {
  if (maps.length !== MAPS * height * width) {
    throw new ModelError(
      `the model gives ${maps.length} values for an input of ${height} x ${width}; expected ${MAPS} maps of ` +
        "this size; it is damaged, or lacks masks or depths",
    );
  }
  for (let i = 0; i < maps.length; i++) {
    const value = maps[i];
    if (value >= 0 && value <= 1) continue;
    if (!(value >= -TOLERANCE && value <= 1 + TOLERANCE)) {
      throw new ModelError(`the model gives the value ${value}; maps are from 0 to 1: its weights are damaged`);
    }
    maps[i] = value < 0 ? 0 : 1;
  }
  return maps;
}

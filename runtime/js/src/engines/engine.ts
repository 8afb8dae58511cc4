/** What runs a model file. */

import type { Size } from "../foundation/types.ts";

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

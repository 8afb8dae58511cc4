/** The engine of Node: onnxruntime-node, on the processor. */

import { isMainThread } from "node:worker_threads";

import type { InferenceSession } from "onnxruntime-node";

import { ModelError } from "../errors.ts";
import { fixedSize, type Engine } from "./engine.ts";

export interface NodeEngineOptions {
  /** Threads for one prediction; all cores if not given. */
  threads?: number;
}

/**
 * Loads the runtime and a model file.
 *
 * @throws ModelError If it cannot be loaded, or its telemetry cannot be switched off here.
 */
export async function openNodeEngine(
  file: Uint8Array,
  { threads }: NodeEngineOptions,
): Promise<Engine> {
  // onnxruntime reports to its maker unless this is set before it starts; 0 lets it. A worker thread sets
  // only its own copy, which onnxruntime does not read.
  if (!isMainThread && !process.env.ORT_DISABLE_TELEMETRY) {
    throw new ModelError(
      'a worker thread cannot switch off the telemetry of onnxruntime: set process.env.ORT_DISABLE_TELEMETRY = "1" ' +
        "in the main thread, before it starts the worker",
    );
  }
  process.env.ORT_DISABLE_TELEMETRY ||= "1";
  const { env, InferenceSession, Tensor } = await import("onnxruntime-node");
  let session: InferenceSession;
  try {
    session = await InferenceSession.create(file, threads ? { intraOpNumThreads: threads } : {});
  } catch (error) {
    const reason = error instanceof Error ? error.message : String(error);
    throw new ModelError(`onnxruntime-node cannot load the model: ${reason}`, { cause: error });
  }
  return {
    runtime: `onnxruntime-node ${env.versions.node ?? ""}`.trim(),
    threads: threads ?? null,
    inputSize: fixedSize(session),
    async run(rgb, { height, width }) {
      const { maps } = await session.run({ image: new Tensor("uint8", rgb, [1, height, width, 3]) });
      return maps.data as Float32Array;
    },
    release: () => session.release(),
  };
}

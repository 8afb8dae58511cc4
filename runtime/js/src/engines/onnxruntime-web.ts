/** The engine of browsers: onnxruntime-web, on the processor or on the graphics chip. */

import type { InferenceSession } from "onnxruntime-web/wasm";

import { ModelError } from "../errors.ts";
import { fixedSize, type Engine } from "./engine.ts";

/** More threads than this do not make the network faster. */
const MOST_THREADS = 4;

type Runtime = typeof import("onnxruntime-web/wasm");

export interface WebEngineOptions {
  /** The processor through WebAssembly (`wasm`, the default), or the graphics chip (`webgpu`). */
  engine?: "wasm" | "webgpu";
  /** Threads of the processor; up to 4 on pages that are cross-origin isolated, else 1. */
  threads?: number;
  /** Where onnxruntime-web's own files are, if a bundler moved them. */
  wasmPaths?: string | { mjs?: string; wasm?: string };
}

/**
 * Loads the runtime and a model file.
 *
 * @throws ModelError If the engine does not start on this device.
 */
export async function openWebEngine(
  file: Uint8Array,
  { engine = "wasm", threads, wasmPaths }: WebEngineOptions,
): Promise<Engine> {
  if (engine === "webgpu" && !(await hasWebGpu())) {
    throw new ModelError('this device offers no WebGPU; load with { engine: "wasm" }');
  }
  // Of onnxruntime-web's two builds the one with WebGPU is twice as large.
  const runtime: Runtime =
    engine === "webgpu" ? await import("onnxruntime-web/webgpu") : await import("onnxruntime-web/wasm");
  // Threads share memory, which browsers allow to isolated pages only.
  const most = globalThis.crossOriginIsolated ? (threads ?? Math.min(MOST_THREADS, navigator.hardwareConcurrency)) : 1;
  runtime.env.wasm.numThreads = most;
  runtime.env.logLevel = "error";
  if (wasmPaths !== undefined) runtime.env.wasm.wasmPaths = wasmPaths;
  let session: InferenceSession;
  try {
    session = await runtime.InferenceSession.create(file, {
      executionProviders: [engine],
      logSeverityLevel: 3,
      // Between two pictures the cores, and the battery, are not for threads that wait.
      extra: { session: { force_spinning_stop: "1" } },
    });
  } catch (error) {
    const reason = error instanceof Error ? error.message : String(error);
    throw new ModelError(`onnxruntime-web cannot load the model on ${engine}: ${reason}`, { cause: error });
  }
  let last: Promise<unknown> = Promise.resolve();
  return {
    runtime: `onnxruntime-web ${runtime.env.versions.web ?? ""}, ${engine}`,
    threads: engine === "wasm" ? most : null,
    inputSize: fixedSize(session),
    run(rgb, { height, width }) {
      // One picture at a time: a session of WebGPU takes no second one.
      const result = last.then(async () => {
        const image = new runtime.Tensor("uint8", rgb, [1, height, width, 3]);
        const { maps } = await session.run({ image });
        const values = await maps.getData();
        maps.dispose();
        return values as Float32Array;
      });
      last = result.catch(() => undefined);
      return result;
    },
    release: () => last.then(() => session.release()),
  };
}

/** Whether this device has a graphics chip that WebGPU can use. */
export async function hasWebGpu(): Promise<boolean> {
  const gpu = (globalThis.navigator as { gpu?: { requestAdapter(): Promise<unknown> } } | undefined)?.gpu;
  return Boolean(await gpu?.requestAdapter().catch(() => null));
}

/** Running the model file. The only module that knows onnxruntime-web. */

import asyncifyMjs from "onnxruntime-web/ort-wasm-simd-threaded.asyncify.mjs?url";
import asyncifyWasm from "onnxruntime-web/ort-wasm-simd-threaded.asyncify.wasm?url";
import plainMjs from "onnxruntime-web/ort-wasm-simd-threaded.mjs?url";
import plainWasm from "onnxruntime-web/ort-wasm-simd-threaded.wasm?url";
import type { InferenceSession } from "onnxruntime-web/wasm";

import modelUrl from "../../../../runtime/footprints_edge/model_files/data/edge.onnx?url";
import { readModelFacts, type ModelFacts } from "../core/model-facts";
import type { Size } from "../core/resize";
import type { Engine } from "../messages";

const MOST_THREADS = 4;

type Runtime = typeof import("onnxruntime-web/wasm");

/** The model, loaded. */
export class Network {
  private constructor(
    private readonly runtime: Runtime,
    private readonly session: InferenceSession,
    readonly facts: ModelFacts,
    /** Threads of the processor that it uses. */
    readonly threads: number,
  ) {}

  /**
   * Fetches and loads the runtime and the model.
   *
   * @throws Error If one cannot be fetched, or the engine does not start on this device.
   */
  static async load(engine: Engine): Promise<Network> {
    const [runtime, file] = await Promise.all([loadRuntime(engine), fetchBytes(modelUrl)]);
    const facts = readModelFacts(file);
    // Threads share memory, which browsers allow to isolated pages only.
    const threads = crossOriginIsolated ? Math.min(MOST_THREADS, navigator.hardwareConcurrency) : 1;
    runtime.env.wasm.numThreads = threads;
    runtime.env.logLevel = "error";
    const session = await runtime.InferenceSession.create(file, {
      executionProviders: [engine],
      logSeverityLevel: 3,
      // Between two pictures the cores, and the battery, are not for threads that wait.
      extra: { session: { force_spinning_stop: "1" } },
    });
    return new Network(runtime, session, facts, threads);
  }

  /** The size that the model file is fixed to; null where it takes any multiples of 32. */
  get inputSize(): Size | null {
    const input = this.session.inputMetadata[0];
    const [, height, width] = input.isTensor ? input.shape : [];
    return typeof height === "number" && typeof width === "number" ? { height, width } : null;
  }

  /**
   * One forward pass.
   *
   * @param rgb Three bytes a pixel.
   * @param size Multiples of 32.
   * @returns float32 [1, 4, height, width]: probabilities of visible ground and of ground, then the
   *   sigmoid disparities of what is seen and of the ground.
   */
  async run(rgb: Uint8Array, size: Size): Promise<Float32Array> {
    const image = new this.runtime.Tensor("uint8", rgb, [1, size.height, size.width, 3]);
    const { maps } = await this.session.run({ image });
    const values = await maps.getData();
    maps.dispose();
    return values as Float32Array;
  }
}

/** One of onnxruntime-web's two builds: the one with WebGPU is twice as large. */
async function loadRuntime(engine: Engine): Promise<Runtime> {
  const absolute = (url: string) => new URL(url, location.href).href;
  if (engine === "webgpu") {
    const runtime = await import("onnxruntime-web/webgpu");
    runtime.env.wasm.wasmPaths = { wasm: absolute(asyncifyWasm), mjs: absolute(asyncifyMjs) };
    return runtime;
  }
  const runtime = await import("onnxruntime-web/wasm");
  runtime.env.wasm.wasmPaths = { wasm: absolute(plainWasm), mjs: absolute(plainMjs) };
  return runtime;
}

async function fetchBytes(url: string): Promise<Uint8Array> {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`the model could not be fetched (${response.status})`);
  return new Uint8Array(await response.arrayBuffer());
}

/** Loading of the package's model, with onnxruntime-web's files where the build puts them. */

import { load, type GroundModel } from "footprints-edge";
import asyncifyMjs from "onnxruntime-web/ort-wasm-simd-threaded.asyncify.mjs?url";
import asyncifyWasm from "onnxruntime-web/ort-wasm-simd-threaded.asyncify.wasm?url";
import plainMjs from "onnxruntime-web/ort-wasm-simd-threaded.mjs?url";
import plainWasm from "onnxruntime-web/ort-wasm-simd-threaded.wasm?url";

import type { Engine } from "../messages";

const FILES: Record<Engine, { mjs: string; wasm: string }> = {
  wasm: { mjs: plainMjs, wasm: plainWasm },
  webgpu: { mjs: asyncifyMjs, wasm: asyncifyWasm },
};

export function loadModel(engine: Engine): Promise<GroundModel> {
  const absolute = (url: string) => new URL(url, location.href).href;
  const { mjs, wasm } = FILES[engine];
  return load({ engine, wasmPaths: { mjs: absolute(mjs), wasm: absolute(wasm) } });
}

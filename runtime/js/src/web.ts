/** The package in browsers, in pages and workers. */

import { openWebEngine, type WebEngineOptions } from "./engines/onnxruntime-web.ts";
import { ModelError } from "./errors.ts";
import { decodeImage, type ImageSource } from "./inputs/browser-images.ts";
import { Model } from "./model.ts";
import { readMetadata } from "./model-files/metadata.ts";

export * from "./api.ts";
export { hasWebGpu, type WebEngineOptions } from "./engines/onnxruntime-web.ts";
export type { ImageSource } from "./inputs/browser-images.ts";

export interface LoadOptions extends WebEngineOptions {
  /** Address or bytes of a model file; the one inside the package if not given. */
  model?: string | URL | Uint8Array;
}

export type GroundModel = Model<ImageSource>;

/**
 * Loads a model.
 *
 * @throws ModelError If it cannot be fetched, is no footprints-edge file, or does not start here.
 */
export async function load({ model, ...options }: LoadOptions = {}): Promise<GroundModel> {
  const file =
    model instanceof Uint8Array
      ? model
      : await fetched(model ?? new URL("../model/edge.onnx", import.meta.url));
  return new Model(readMetadata(file), await openWebEngine(file, options), decodeImage);
}

async function fetched(url: string | URL): Promise<Uint8Array> {
  const response = await fetch(url).catch((error: unknown) => {
    throw new ModelError(`the model ${url} could not be fetched: ${String(error)}`, { cause: error });
  });
  if (!response.ok) throw new ModelError(`the model ${url} could not be fetched (${response.status})`);
  return new Uint8Array(await response.arrayBuffer());
}

/** The package in Node. */

import { readFile } from "node:fs/promises";

import { openNodeEngine, type NodeEngineOptions } from "./engines/onnxruntime-node.ts";
import { ImageError, ModelError } from "./errors.ts";
import type { Pixels } from "./foundation/types.ts";
import { decodedPixels, isPixels, type DecodedImage } from "./inputs/pixels.ts";
import { Model } from "./model.ts";
import { readMetadata } from "./model-files/metadata.ts";

export * from "./api.ts";
export type { NodeEngineOptions } from "./engines/onnxruntime-node.ts";

/** Decoded pixels: Node has no decoder of its own. */
export type ImageSource = Pixels;

export interface LoadOptions extends NodeEngineOptions {
  /** Path, file URL or bytes of a model file; the one inside the package if not given. */
  model?: string | URL | Uint8Array;
}

export type GroundModel = Model<ImageSource>;

/**
 * Loads a model.
 *
 * @throws ModelError If it cannot be read, is no footprints-edge file, or does not start here.
 */
export async function load({ model, ...options }: LoadOptions = {}): Promise<GroundModel> {
  const file =
    model instanceof Uint8Array
      ? model
      : await read(model ?? new URL("../model/edge.onnx", import.meta.url));
  return new Model(readMetadata(file), await openNodeEngine(file, options), decode);
}

async function read(path: string | URL): Promise<Uint8Array> {
  return readFile(path).catch((error: unknown) => {
    throw new ModelError(`the model ${path} cannot be read: ${(error as Error).message}`, { cause: error });
  });
}

async function decode(source: ImageSource): Promise<DecodedImage> {
  if (!isPixels(source)) {
    throw new ImageError(
      "Node decodes no pictures; decode the file first, with sharp or jpeg-js, say, and give " +
        "{ data, width, height } with 3 or 4 bytes a pixel",
    );
  }
  return decodedPixels(source);
}

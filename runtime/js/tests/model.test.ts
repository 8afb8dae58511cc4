/** A prediction from the picture on, with an engine that says what it is told to. */

import { readFileSync } from "node:fs";

import { afterEach, describe, expect, it, vi } from "vitest";

import type { Engine } from "../src/engines/engine.ts";
import { ModelError } from "../src/errors.ts";
import type { Size } from "../src/foundation/types.ts";
import { decodeImage } from "../src/inputs/browser-images.ts";
import { decodedPixels } from "../src/inputs/pixels.ts";
import { Model } from "../src/model.ts";
import { readMetadata } from "../src/model-files/metadata.ts";

const FILE = new URL("../../footprints_edge/model_files/data/edge.onnx", import.meta.url);
const metadata = readMetadata(readFileSync(FILE));

function engineOf(maps: (size: Size) => Float32Array): Engine {
  return {
    runtime: "test",
    threads: 1,
    inputSize: null,
    run: async (_, size) => maps(size),
    release: async () => undefined,
  };
}

const evenly = (value: number) => (size: Size) => new Float32Array(4 * size.height * size.width).fill(value);
const PICTURE = { data: new Uint8Array(3 * 64 * 96), height: 64, width: 96 };
const modelOf = (maps: (size: Size) => Float32Array) =>
  new Model(metadata, engineOf(maps), async (source: typeof PICTURE) => decodedPixels(source));

describe("what a network gives", () => {
  it.each([NaN, Infinity, -0.1, 1.1])("is refused if it holds %d", async (value) => {
    const damaged = modelOf((size) => {
      const maps = evenly(0.5)(size);
      maps[maps.length - 1] = value;
      return maps;
    });
    await expect(damaged.predict(PICTURE)).rejects.toThrow(ModelError);
    await expect(damaged.predict(PICTURE)).rejects.toThrow(/its weights are damaged/);
  });

  it("is refused if it is not four maps", async () => {
    const short = modelOf((size) => evenly(0.5)(size).subarray(1));
    await expect(short.predict(PICTURE)).rejects.toThrow(ModelError);
  });

  it("may be rounded beyond 1", async () => {
    const { groundProbability } = await modelOf(evenly(1 + 2 ** -22)).predict(PICTURE);
    expect(Math.max(...groundProbability)).toBe(1);
  });
});

it("an input size that is no multiple of 32 is refused", async () => {
  const model = modelOf(evenly(0.5));
  for (const height of [100, 0, NaN]) {
    await expect(model.run(PICTURE, {}, { height, width: 96 })).rejects.toThrow(/multiples of 32/);
  }
});

describe("a picture larger than a canvas can be", () => {
  afterEach(() => vi.unstubAllGlobals());

  it("keeps its size and its camera", async () => {
    class Bitmap {
      width = 16384;
      height = 4096;
    }
    class Canvas {
      width: number;
      height: number;
      constructor(width: number, height: number) {
        [this.width, this.height] = [width, height];
      }
      getContext() {
        const getImageData = (_x: number, _y: number, width: number, height: number) => ({
          data: new Uint8ClampedArray(4 * width * height).fill(255),
          width,
          height,
        });
        return { fillRect() {}, drawImage() {}, getImageData };
      }
    }
    vi.stubGlobal("ImageBitmap", Bitmap);
    vi.stubGlobal("OffscreenCanvas", Canvas);
    const model = new Model(metadata, engineOf(evenly(0.5)), decodeImage);
    const camera = { fx: 12000, fy: 12000, cx: 8191.5, cy: 2047.5 };
    const found = await model.predict(new Bitmap() as unknown as ImageBitmap, { camera });
    expect(found.imageSize).toEqual({ height: 4096, width: 16384 });
    expect(found.intrinsics.fx / found.mapSize.width).toBeCloseTo(12000 / 16384, 9);
    expect(found.intrinsics.cx).toBeCloseTo((found.mapSize.width - 1) / 2, 9);
  }, 20_000);
});

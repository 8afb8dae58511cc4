/** Runs the page's own code on a test vector whose camera and size are given. */

import { placeAt, readMaps } from "../../src/core/maps";
import { resizeToRgb } from "../../src/core/resize";
import { Network } from "../../src/workers/network";

export interface Vector {
  /** The picture, as a data URL. */
  image: string;
  network_size_px: [number, number];
  network_intrinsics_px: { fx: number; fy: number; cx: number; cy: number };
  /** A fault to be found: blue and red swapped. */
  swapped: boolean;
}

/** Arrays by name; their bytes as a data URL, which travels far faster than numbers. */
export type Outputs = Record<string, { shape: number[]; bytes: boolean; url: string }>;

const network = await Network.load("wasm");

async function run(vector: Vector): Promise<Outputs> {
  const picture = await createImageBitmap(await (await fetch(vector.image)).blob());
  const context = new OffscreenCanvas(picture.width, picture.height).getContext("2d")!;
  context.drawImage(picture, 0, 0);
  const { data } = context.getImageData(0, 0, picture.width, picture.height);
  const [height, width] = vector.network_size_px;
  const size = { height, width };
  const input = resizeToRgb(data, picture, size, network.facts.resize);
  if (vector.swapped) {
    for (let i = 0; i < input.length; i += 3) [input[i], input[i + 2]] = [input[i + 2], input[i]];
  }
  const output = await network.run(input, size);
  const camera = { ...vector.network_intrinsics_px, source: "assumed" } as const;
  const maps = readMaps(output, size, network.facts, camera);
  const places = Array.from(maps.groundProbability, (_, pixel) => placeAt(maps, pixel));
  const mask = (test: (i: number) => boolean) => Uint8Array.from(places, (_, i) => Number(test(i)));
  const ground = (i: number) => maps.groundProbability[i] > 0.5;
  return {
    input: await packed([1, height, width, 3], input),
    maps: await packed([1, 4, height, width], output),
    visible_ground: await packed([height, width], mask((i) => places[i] === "visible")),
    ground: await packed([height, width], mask(ground)),
    hidden_ground: await packed([height, width], mask((i) => places[i] === "hidden")),
    visible_depth_m: await packed([height, width], maps.visibleDepthM),
    ground_depth_m: await packed(
      [height, width],
      maps.groundDepthM.map((each, i) => (ground(i) ? each : NaN)),
    ),
  };
}

async function packed(shape: number[], data: Uint8Array | Float32Array): Promise<Outputs[string]> {
  const reader = new FileReader();
  reader.readAsDataURL(new Blob([data as BlobPart]));
  await new Promise((resolve) => (reader.onload = resolve));
  return { shape, bytes: data instanceof Uint8Array, url: reader.result as string };
}

Object.assign(globalThis, { run });

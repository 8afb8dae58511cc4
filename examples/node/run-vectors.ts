/**
 * Test vectors through this program, for `fp-export check-vectors VECTORS OUTPUTS`.
 *
 *     npm run --silent vectors -- MODEL.onnx VECTORS OUTPUTS
 */

import { mkdir, readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { GroundFinder, masksOf } from "./ground-finder";
import { decode, encodeMask } from "./pictures";

const [modelPath, vectors, outputs] = process.argv.slice(2);
const finder = await GroundFinder.load(modelPath);
const manifest = JSON.parse(await readFile(join(vectors, "vectors.json"), "utf8"));
for (const { name, files, image_intrinsics_px, network_size_px } of manifest.vectors) {
  const [height, width] = network_size_px;
  const picture = await decode(await readFile(join(vectors, files.image)));
  const found = await finder.find(picture, image_intrinsics_px, { height, width });
  const masks = masksOf(found);
  const folder = join(outputs, name);
  await mkdir(folder, { recursive: true });
  const save = (file: string, bytes: Uint8Array) => writeFile(join(folder, file), bytes);
  await save("input.npy", npy(found.input, [1, height, width, 3]));
  await save("maps.npy", npy(found.output, [1, 4, height, width]));
  for (const [mask, values] of Object.entries(masks)) {
    await save(`${mask}.png`, encodeMask(values, found));
  }
  await save("visible_depth_m.npy", npy(found.visibleDepthM, [height, width]));
  const groundDepth = found.groundDepthM.map((metres, i) => (masks.ground[i] ? metres : NaN));
  await save("ground_depth_m.npy", npy(groundDepth, [height, width]));
}

/** An array in NumPy's format, version 1.0. */
function npy(values: Uint8Array | Float32Array, shape: number[]): Uint8Array {
  const type = values instanceof Uint8Array ? "|u1" : "<f4";
  const facts = `{'descr': '${type}', 'fortran_order': False, 'shape': (${shape.join(", ")}), }`;
  const start = Buffer.from(`\x93NUMPY\x01\x00..${facts.padEnd(117)}\n`, "latin1");
  start.writeUInt16LE(start.length - 10, 8);
  return Buffer.concat([start, Buffer.from(values.buffer, values.byteOffset, values.byteLength)]);
}

/**
 * Walkable ground in pictures: JSON to standard output, and three masks beside each picture.
 *
 *     npm run --silent find-ground -- MODEL.onnx PICTURE... > result.jsonl
 */

import { readFile, writeFile } from "node:fs/promises";
import { basename } from "node:path";
import { cameraOf } from "../web/src/core/camera";
import { GroundFinder, masksOf } from "./ground-finder";
import { decode, encodeMask, focalLength35mm } from "./pictures";

const [modelPath, ...paths] = process.argv.slice(2);
if (!modelPath || paths.length === 0) {
  console.error("usage: find-ground MODEL.onnx PICTURE...");
  process.exit(2);
}
const finder = await GroundFinder.load(modelPath);
for (const path of paths) {
  const file = await readFile(path);
  const picture = await decode(file);
  const camera = cameraOf(picture, await focalLength35mm(file));
  const found = await finder.find(picture, camera);
  const masks = masksOf(found);
  for (const [name, mask] of Object.entries(masks)) {
    await writeFile(`${path}.${name}.png`, encodeMask(mask, found));
  }
  const share = (mask: Uint8Array) => mask.reduce((sum, value) => sum + value, 0) / mask.length;
  const depths = found.groundDepthM.filter((_, i) => masks.ground[i]);
  const summary = {
    image: basename(path),
    image_size_px: [picture.height, picture.width],
    map_size_px: [found.height, found.width],
    ground_fraction: {
      visible: share(masks.visible_ground),
      hidden: share(masks.hidden_ground),
      all: share(masks.ground),
    },
    ground_distance_m: {
      nearest: depths.length ? depths.reduce((a, b) => Math.min(a, b)) : null,
      farthest: depths.length ? depths.reduce((a, b) => Math.max(a, b)) : null,
    },
    camera: { focal_length_px: camera.fx, source: camera.source },
    model: { name: finder.facts.name, precision: finder.facts.precision },
  };
  console.log(JSON.stringify(summary));
}

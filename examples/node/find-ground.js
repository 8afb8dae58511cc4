/**
 * Walkable ground in pictures: JSON to standard output, and three masks beside each picture.
 *
 *     npm run --silent find-ground -- [--camera-height METRES] PICTURE... > result.jsonl
 */

import { readFile, writeFile } from "node:fs/promises";
import { basename } from "node:path";
import { parseArgs } from "node:util";

import { GroundPlaneError, load } from "footprints-edge";

import { decode, encodeMask } from "./pictures.js";

const { values, positionals: paths } = parseArgs({
  options: { "camera-height": { type: "string" } },
  allowPositionals: true,
});
if (paths.length === 0) {
  console.error("usage: find-ground [--camera-height METRES] PICTURE...");
  process.exit(2);
}
const cameraHeightM = values["camera-height"] && Number(values["camera-height"]);
if (cameraHeightM !== undefined && !(cameraHeightM > 0)) {
  console.error(`--camera-height is ${values["camera-height"]}; give metres, such as 1.5`);
  process.exit(2);
}
const model = await load();
for (const path of paths) {
  try {
    await findGround(path);
  } catch (error) {
    console.error(`${path}: ${error.message}`); // the others can still be read
    process.exitCode = 1;
  }
}

async function findGround(path) {
  const { picture, lens } = await decode(await readFile(path));
  const found = await model.predict(picture, { lens, cameraHeightM });
  const masks = { visible_ground: found.visibleGround, ground: found.ground, hidden_ground: found.hiddenGround };
  for (const [name, mask] of Object.entries(masks)) {
    await writeFile(`${path}.${name}.png`, encodeMask(mask, found.mapSize));
  }
  console.log(JSON.stringify(summary(basename(path), found)));
}

function summary(image, found) {
  const share = (mask) => mask.reduce((sum, value) => sum + value, 0) / mask.length;
  const depths = found.groundDepthM.filter(Number.isFinite).sort();
  const { fx, source } = found.intrinsics;
  return {
    image,
    image_size_px: [found.imageSize.height, found.imageSize.width],
    map_size_px: [found.mapSize.height, found.mapSize.width],
    ground_fraction: {
      visible: share(found.visibleGround),
      hidden: share(found.hiddenGround),
      all: share(found.ground),
    },
    ground_distance_m: { nearest: depths[0] ?? null, farthest: depths.at(-1) ?? null },
    ...onPlane(found),
    camera: { focal_length_px: (fx * found.imageSize.width) / found.mapSize.width, source },
    model: { name: found.model.name, precision: found.model.precision },
  };
}

/** What needs a ground plane; null where there is none. */
function onPlane(found) {
  try {
    const { cameraHeightM, pitchDeg, rollDeg } = found.groundPlane();
    const nearest = Math.min(...found.scan().rangesM.filter(Number.isFinite));
    return {
      ground_plane: { camera_height_m: cameraHeightM, pitch_deg: pitchDeg, roll_deg: rollDeg },
      nearest_obstacle_m: Number.isFinite(nearest) ? nearest : null,
    };
  } catch (error) {
    if (error instanceof GroundPlaneError) return { ground_plane: null, nearest_obstacle_m: null };
    throw error;
  }
}

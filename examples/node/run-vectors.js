/**
 * Test vectors through the package, for `fp-export check-vectors VECTORS OUTPUTS`.
 *
 *     npm run --silent vectors -- MODEL.onnx VECTORS OUTPUTS
 */

import { mkdir, readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";

import { GroundPlaneError, load, PlanningError } from "footprints-edge";

import { decode, encodeMask } from "./pictures.js";

const [modelPath, vectors, outputs] = process.argv.slice(2);
const model = await load({ model: modelPath });
const manifest = JSON.parse(await readFile(join(vectors, "vectors.json"), "utf8"));
for (const entry of manifest.vectors) {
  const [height, width] = entry.network_size_px;
  const { picture } = await decode(await readFile(join(vectors, entry.files.image)));
  const pose = entry.known_pose ?? {};
  const options = {
    camera: entry.image_intrinsics_px,
    flatten: false,
    cameraHeightM: pose.camera_height_m,
    pitchDeg: pose.pitch_deg,
    rollDeg: pose.roll_deg,
  };
  const { prediction, input, output } = await model.run(picture, options, { height, width });
  const folder = join(outputs, entry.name);
  await mkdir(folder, { recursive: true });
  const save = (file, bytes) => writeFile(join(folder, file), bytes);
  await save("input.npy", npy(input, [1, height, width, 3]));
  await save("maps.npy", npy(output, [1, 4, height, width]));
  const large = prediction.atImageSize();
  for (const [found, suffix] of [[prediction, ""], [large, "_at_image_size"]]) {
    await save(`visible_ground${suffix}.png`, encodeMask(found.visibleGround, found.mapSize));
    await save(`ground${suffix}.png`, encodeMask(found.ground, found.mapSize));
    await save(`hidden_ground${suffix}.png`, encodeMask(found.hiddenGround, found.mapSize));
  }
  await save("visible_depth_m.npy", npy(prediction.visibleDepthM, [height, width]));
  await save("ground_depth_m.npy", npy(prediction.groundDepthM, [height, width]));
  await save("flat_ground_depth_m.npy", npy(prediction.flattened().groundDepthM, [height, width]));
  await save("ground_plane.json", JSON.stringify(planeOf(prediction)));
  if (entry.grid && planeOf(prediction).refused === null) await saveMetres(save, prediction, entry);
}

function planeOf(prediction) {
  try {
    const { up, cameraHeightM, pitchDeg, rollDeg, errorM } = prediction.groundPlane();
    const pose = { camera_height_m: cameraHeightM, pitch_deg: pitchDeg, roll_deg: rollDeg };
    return { up, ...pose, error_m: errorM, refused: null };
  } catch (error) {
    if (error instanceof GroundPlaneError) return { refused: error.reason };
    throw error;
  }
}

async function saveMetres(save, prediction, { grid: { cell_m, range_m, robot_height_m }, path }) {
  const robotHeightM = robot_height_m;
  const bearings = Array.from({ length: 181 }, (_, i) => i - 90);
  const grid = prediction.topDown(cell_m, range_m, { robotHeightM });
  await save("occupancy.npy", npy(grid.cells, [grid.rows, grid.columns]));
  await save("nearest_obstacle_m.npy", npy(grid.nearestObstacleM(bearings), [181]));
  await save("scan_m.npy", npy(prediction.scan(bearings, { robotHeightM }).rangesM, [181]));
  if (!path) return;
  try {
    const options = { marginM: path.margin_m, robotHeightM };
    const { placesM } = prediction.plan(path.start_px, path.goal_px, options);
    await save("path_m.npy", npy(Float32Array.from(placesM.flat()), [placesM.length, 2]));
  } catch (error) {
    if (!(error instanceof PlanningError)) throw error; // these maps have none
  }
}

/** An array in NumPy's format, version 1.0. */
function npy(values, shape) {
  const type = values instanceof Uint8Array ? "|u1" : "<f4";
  const facts = `{'descr': '${type}', 'fortran_order': False, 'shape': (${shape.join(", ")},), }`;
  const start = Buffer.from(`\x93NUMPY\x01\x00..${facts.padEnd(117)}\n`, "latin1");
  start.writeUInt16LE(start.length - 10, 8);
  return Buffer.concat([start, Buffer.from(values.buffer, values.byteOffset, values.byteLength)]);
}

/** All that follows from the network's maps, held against the test vectors that `fp-export vectors` writes. */

import { readFileSync } from "node:fs";

import { describe, expect, it } from "vitest";

import { GroundPlaneError } from "../src/errors.ts";
import { intrinsicsOf, scaledCamera } from "../src/geometry/camera.ts";
import { poseOf } from "../src/geometry/camera-pose.ts";
import { decodeMaps } from "../src/maps/decode.ts";
import { readMetadata } from "../src/model-files/metadata.ts";
import { Prediction } from "../src/prediction.ts";
import { fixturePath, readBytes, readFloats } from "./fixtures.ts";

const MODEL = new URL("../../footprints_edge/model_files/data/edge.onnx", import.meta.url);
const metadata = readMetadata(readFileSync(MODEL));
const { vectors } = JSON.parse(readFileSync(fixturePath("vectors/vectors.json"), "utf8"));
const BEARINGS = Array.from({ length: 181 }, (_, i) => i - 90);

function predictionOf(entry: any): Prediction {
  const [[height, width], [imageHeight, imageWidth]] = [entry.network_size_px, entry.image_size_px];
  const [mapSize, imageSize] = [{ height, width }, { height: imageHeight, width: imageWidth }];
  const intrinsics = scaledCamera(intrinsicsOf(imageSize, entry.image_intrinsics_px), imageSize, mapSize);
  const output = readFloats(fixturePath(`vectors/${entry.files.maps}`)).data;
  const { camera_height_m: cameraHeightM, pitch_deg: pitchDeg, roll_deg: rollDeg } = entry.known_pose;
  return new Prediction({
    ...decodeMaps(output, mapSize, metadata, intrinsics),
    mapSize,
    imageSize,
    intrinsics,
    threshold: 0.5,
    model: { name: metadata.name, precision: metadata.precision, runtime: "" },
    timingsMs: { decode: 0, preprocess: 0, inference: 0, postprocess: 0 },
    pose: poseOf({ cameraHeightM, pitchDeg, rollDeg }),
    panorama: false,
    laidOnto: null,
  });
}

/** Share of the values that are as expected, to 0.1 %; infinite and NaN like these. */
function alike(found: ArrayLike<number>, expected: ArrayLike<number>): number {
  expect(found.length).toBe(expected.length);
  const same = Array.from(found, (each, i) => {
    const other = expected[i];
    return Object.is(each, other) || Math.abs(each - other) <= 1e-3 * Math.abs(other);
  });
  return same.filter(Boolean).length / same.length;
}

describe.each<any>(vectors)("vector $name", (entry) => {
  const path = (name: string) => fixturePath(`vectors/${entry.files[name] ?? `${entry.name}/${name}`}`);
  const plane = JSON.parse(readFileSync(path("ground_plane.json"), "utf8"));
  const prediction = predictionOf(entry);
  const { grid } = entry;

  it("has its plane, or the reason against one", () => {
    if (plane.refused !== null) {
      let reason = "";
      try {
        prediction.groundPlane();
      } catch (error) {
        reason = (error as GroundPlaneError).reason;
      }
      expect(reason).toBe(plane.refused);
      return;
    }
    const found = prediction.groundPlane();
    expect(found.cameraHeightM).toBeCloseTo(plane.camera_height_m, 4);
    expect(found.pitchDeg).toBeCloseTo(plane.pitch_deg, 3);
    expect(found.rollDeg).toBeCloseTo(plane.roll_deg, 3);
    expect(found.errorM).toBeCloseTo(plane.error_m, 4);
  });

  it("has its depth, laid flat", () => {
    const flat = prediction.flattened();
    expect(flat.laidOnto === null).toBe(plane.refused !== null);
    const expected = readFloats(path("flat_ground_depth_m.npy")).data;
    expect(alike(flat.groundDepthM, expected)).toBeGreaterThan(0.999);
  });

  it.skipIf(plane.refused !== null)("has its grid and its obstacles", () => {
    const found = prediction.topDown(grid.cell_m, grid.range_m, { robotHeightM: grid.robot_height_m });
    const expected = readBytes(path("occupancy.npy"));
    expect([found.rows, found.columns]).toEqual(expected.shape);
    const differing = found.cells.filter((each, i) => each !== expected.data[i]).length;
    expect(differing / expected.data.filter((each) => each > 0).length).toBeLessThan(0.001);
    const nearest = found.nearestObstacleM(BEARINGS);
    expect(alike(nearest, readFloats(path("nearest_obstacle_m.npy")).data)).toBeGreaterThan(0.99);
    const { rangesM } = prediction.scan(BEARINGS, { robotHeightM: grid.robot_height_m });
    expect(alike(rangesM, readFloats(path("scan_m.npy")).data)).toBeGreaterThan(0.99);
  });

  it.skipIf(!entry.path)("has its path, and has it again after postMessage", () => {
    const { start_px, goal_px, margin_m, cost, length_m } = entry.path;
    const options = { marginM: margin_m, robotHeightM: grid.robot_height_m };
    const found = prediction.plan(start_px, goal_px, options);
    expect(found.cost / cost).toBeCloseTo(1, 1);
    expect(found.lengthM / length_m).toBeCloseTo(1, 2);
    expect(found.pixels[0][0]).toBeCloseTo(start_px[0], 3);
    expect(found.pixels.at(-1)![1]).toBeCloseTo(goal_px[1], 3);
    const copy = new Prediction(structuredClone(prediction));
    expect(copy.plan(start_px, goal_px, options)).toEqual(found);
  });
});

import { readFileSync } from "node:fs";

import { describe, expect, it } from "vitest";

import { COLOUR_SCALE, scalePosition } from "../src/drawing/colours.ts";
import { CameraPoseError, IntrinsicsError, ModelError } from "../src/errors.ts";
import { disparityToDepth, intrinsicsOf, scaledCamera } from "../src/geometry/camera.ts";
import { poseOf } from "../src/geometry/camera-pose.ts";
import { readLens, UNKNOWN_LENS } from "../src/inputs/lens.ts";
import { decodeMaps } from "../src/maps/decode.ts";
import { readMetadata } from "../src/model-files/metadata.ts";
import { facts, fixturePath, readFloats } from "./fixtures.ts";

const MODEL = new URL("../../footprints_edge/model_files/data/edge.onnx", import.meta.url);
const known = facts();

function fileOf(name: string): ArrayBuffer {
  return Uint8Array.from(readFileSync(fixturePath(name))).buffer;
}

describe("depth", () => {
  it.each(known.depths)("of disparity %d is the runtime's", (disparity, usual, narrower) => {
    expect(disparityToDepth(disparity, 0.1, 100)).toBeCloseTo(usual, 9);
    expect(disparityToDepth(disparity, 0.5, 40)).toBeCloseTo(narrower, 9);
  });

  it("grows with the focal length of the camera", () => {
    const model = { ...readMetadata(readFileSync(MODEL)), focalPx: 400 };
    const size = { height: 1, width: 1 };
    const output = Float32Array.from([0.9, 0.9, 0.01, 0.02]);
    const at = (focalPx: number) =>
      decodeMaps(output, size, model, { fx: focalPx, fy: focalPx, cx: 0, cy: 0, source: "exif" });
    expect(at(400).visibleDepthM[0]).toBeCloseTo(disparityToDepth(0.01, 0.1, 100), 4);
    expect(at(800).visibleDepthM[0]).toBeCloseTo(2 * at(400).visibleDepthM[0], 4);
    expect(at(800).unmaskedGroundDepthM[0]).toBeCloseTo(2 * disparityToDepth(0.02, 0.1, 100), 4);
  });
});

describe("camera", () => {
  it.each(Object.entries(known.photos))("of %s is the runtime's", (name, { camera }) => {
    const [rows, columns] = readFloats(fixturePath(`${name}.npy`)).shape.slice(1);
    const pictures: Record<string, [number, number]> = {
      "room.jpg": [720, 1280],
      "upright.png": [720, 540],
      "square.png": [720, 720],
      "small.png": [169, 200],
      "cropped.jpg": [700, 600],
      "zoomed.jpg": [360, 640],
    };
    const [height, width] = pictures[name];
    const focal = readLens(fileOf(name)).focal35mm;
    const found = scaledCamera(
      intrinsicsOf({ height, width }, null, focal),
      { height, width },
      { height: rows, width: columns },
    );
    const [fx, fy, cx, cy, source] = camera;
    expect(found.source).toBe(source);
    expect([found.fx, found.fy, found.cx, found.cy].map((x) => x.toFixed(6))).toEqual(
      [fx, fy, cx, cy].map((x) => x.toFixed(6)),
    );
  });
});

describe("a camera that is given", () => {
  const size = { height: 720, width: 1280 };

  it("has the field of view and the focal length that were given", () => {
    expect(intrinsicsOf(size, { hfovDeg: 90 }).fx).toBeCloseTo(640, 6);
    expect(intrinsicsOf({ height: 1280, width: 720 }, { fovDeg: 90 }).fx).toBeCloseTo(640, 6);
    const { fx, source } = intrinsicsOf(size, null, 30);
    expect(intrinsicsOf(size, { focal35mm: 30 }, 77).fx).toBe(fx);
    expect(source).toBe("exif");
  });

  it("is refused if it cannot be", () => {
    for (const camera of [{ hfovDeg: 180 }, { fovDeg: -1 }, { focal35mm: 0 }, { fx: 1, fy: NaN, cx: 0, cy: 0 }]) {
      expect(() => intrinsicsOf(size, camera)).toThrow(IntrinsicsError);
    }
  });
});

describe("a lens", () => {
  it("is what the JPEG states", () => expect(readLens(fileOf("room.jpg")).focal35mm).toBe(30));

  it.each(Object.entries(known.lenses))("%s is what the runtime reads", (name, lens) => {
    const { focal35mm, panorama } = readLens(fileOf(`lens-${name}.jpg`));
    expect(panorama).toBe(lens.panorama);
    if (lens.focal35mm === null) expect(focal35mm).toBeNull();
    else expect(focal35mm).toBeCloseTo(lens.focal35mm, 6);
  });

  it("is unknown for a PNG, nothing, and a file cut short", () => {
    expect(readLens(fileOf("upright.png"))).toEqual(UNKNOWN_LENS);
    expect(readLens(new ArrayBuffer(0))).toEqual(UNKNOWN_LENS);
    for (let length = 0; length < 60; length++) {
      expect(readLens(fileOf("room.jpg").slice(0, length))).toEqual(UNKNOWN_LENS);
    }
  });
});

describe("model file", () => {
  it("says what the file beside it says", () => {
    const { metadata } = JSON.parse(readFileSync(new URL("edge.onnx.json", MODEL), "utf8"));
    expect(readMetadata(readFileSync(MODEL))).toEqual({
      name: metadata.name,
      precision: metadata.precision,
      licence: metadata.licence,
      depthRangeM: metadata.depth_range_m,
      focalPx: metadata.focal_px,
      resize: metadata.resize,
    });
  });

  it("is refused when it is another program's, or cut short", () => {
    const file = readFileSync(MODEL);
    expect(() => readMetadata(new Uint8Array())).toThrow(ModelError);
    expect(() => readMetadata(file.subarray(0, file.length >> 1))).toThrow(/model file/);
  });
});

describe("a pose", () => {
  it("comes from gravity", () => {
    const tilt = (10 * Math.PI) / 180;
    const pose = poseOf({ gravity: [0, 9.81 * Math.cos(tilt), 9.81 * Math.sin(tilt)], cameraHeightM: 1.2 });
    expect(pose.heightM).toBe(1.2);
    expect(pose.pitchDeg).toBeCloseTo(10, 9);
    expect(pose.rollDeg).toBeCloseTo(0, 9);
  });

  it("is refused if it cannot be", () => {
    for (const options of [
      { cameraHeightM: 0 },
      { cameraHeightM: NaN },
      { pitchDeg: 91 },
      { gravity: [0, 0, 0] as const },
      { gravity: [0, 1, 0] as const, rollDeg: 0 },
    ]) {
      expect(() => poseOf(options)).toThrow(CameraPoseError);
    }
  });
});

describe("colours", () => {
  it("are the runtime's, to one level", () => {
    const worst = Math.max(...known.colours.map((each, i) => Math.abs(each - COLOUR_SCALE[i])));
    expect(worst).toBeLessThanOrEqual(1);
    for (const [depthM, position] of known.positions) expect(scalePosition(depthM)).toBe(position);
  });
});

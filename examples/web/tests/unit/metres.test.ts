import { readFileSync } from "node:fs";

import { describe, expect, it } from "vitest";

import { cameraOf, disparityToDepth, scaledCamera } from "../../src/core/camera";
import { COLOUR_SCALE, scalePosition } from "../../src/core/colours";
import { focalLength35mm } from "../../src/core/focal-length";
import { pixelAt, placeAt, readMaps } from "../../src/core/maps";
import { readModelFacts } from "../../src/core/model-facts";
import { facts, fixturePath, readFloats } from "../fixtures";

const MODEL = new URL("../../../../runtime/footprints_edge/model_files/data/edge.onnx", import.meta.url);
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
    const model = { ...readModelFacts(readFileSync(MODEL)), focalPx: 400 };
    const size = { height: 1, width: 1 };
    const output = Float32Array.from([0.9, 0.9, 0.01, 0.02]);
    const at = (focalPx: number) =>
      readMaps(output, size, model, { fx: focalPx, fy: focalPx, cx: 0, cy: 0, source: "exif" });
    expect(at(400).visibleDepthM[0]).toBeCloseTo(disparityToDepth(0.01, 0.1, 100), 4);
    expect(at(800).visibleDepthM[0]).toBeCloseTo(2 * at(400).visibleDepthM[0], 4);
    expect(at(800).groundDepthM[0]).toBeCloseTo(2 * disparityToDepth(0.02, 0.1, 100), 4);
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
    };
    const [height, width] = pictures[name];
    const focal = focalLength35mm(fileOf(name));
    const found = scaledCamera(
      cameraOf({ height, width }, focal),
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

describe("focal length", () => {
  it("is what the JPEG states", () => expect(focalLength35mm(fileOf("room.jpg"))).toBe(30));

  it("is unknown for a PNG, nothing, and a file cut short", () => {
    expect(focalLength35mm(fileOf("upright.png"))).toBeNull();
    expect(focalLength35mm(new ArrayBuffer(0))).toBeNull();
    for (let length = 0; length < 60; length++) {
      expect(focalLength35mm(fileOf("room.jpg").slice(0, length))).toBeNull();
    }
  });
});

describe("model file", () => {
  it("says what the file beside it says", () => {
    const { metadata } = JSON.parse(readFileSync(new URL("edge.onnx.json", MODEL), "utf8"));
    expect(readModelFacts(readFileSync(MODEL))).toEqual({
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
    expect(() => readModelFacts(new Uint8Array())).toThrow(/lacks the metadata/);
    expect(() => readModelFacts(file.subarray(0, file.length >> 1))).toThrow(/model file/);
  });
});

describe("places", () => {
  const one = { fx: 1, fy: 1, cx: 0, cy: 0, source: "assumed" } as const;
  const none = new Float32Array(3);
  const maps = {
    height: 1,
    width: 3,
    visibleGroundProbability: Float32Array.from([0.6, 0.4, 0.5]),
    groundProbability: Float32Array.from([0.2, 0.9, 0.5]),
    visibleDepthM: none,
    groundDepthM: none,
    camera: one,
  };

  it("are visible, hidden or none, strictly above the threshold", () => {
    expect([0, 1, 2].map((pixel) => placeAt(maps, pixel))).toEqual(["visible", "hidden", "none"]);
  });

  it("belong to the pixel that they are in, also on the border", () => {
    const at = (x: number) => pixelAt(maps, { x, y: 1 });
    expect([0, 0.33, 0.34, 0.99, 1].map(at)).toEqual([0, 0, 1, 2, 2]);
  });
});

describe("colours", () => {
  it("are the runtime's, to one level", () => {
    const worst = Math.max(...known.colours.map((each, i) => Math.abs(each - COLOUR_SCALE[i])));
    expect(worst).toBeLessThanOrEqual(1);
    for (const [depthM, position] of known.positions) expect(scalePosition(depthM)).toBe(position);
  });
});

import { describe, expect, it } from "vitest";

import { flatten } from "../../src/core/flat-ground";
import type { Maps } from "../../src/core/maps";
import { facts, fixturePath, readFloats } from "../fixtures";

function mapsOf(name: string): { plain: Maps; flatM: Float32Array } {
  const { shape, data } = readFloats(fixturePath(`${name}.npy`));
  const [, height, width] = shape;
  const channel = (k: number) => data.slice(k * height * width, (k + 1) * height * width);
  const [fx, fy, cx, cy, source] = facts().photos[name].camera;
  const plain = {
    height,
    width,
    visibleGroundProbability: channel(0),
    groundProbability: channel(1),
    visibleDepthM: channel(2),
    groundDepthM: readFloats(fixturePath(`${name}-plain-depth.npy`)).data,
    camera: { fx, fy, cx, cy, source },
  };
  return { plain, flatM: channel(3) };
}

function off(one: Float32Array, other: Float32Array): number[] {
  return Array.from(one, (each, i) => Math.abs(Math.log(each / other[i]))).sort((a, b) => a - b);
}

describe("flat ground", () => {
  it.each(Object.keys(facts().photos))("of %s is the runtime's", (name) => {
    const { plain, flatM } = mapsOf(name);
    const found = flatten(plain).groundDepthM;
    const middle = found.length >> 1;
    expect(off(found, flatM)[middle]).toBeLessThan(0.01);
    expect(off(plain.groundDepthM, flatM)[middle]).toBeGreaterThan(0.015);
  });

  it("is left alone where the ground is no plane", () => {
    const { plain } = mapsOf("room.jpg");
    const steps = plain.groundDepthM.map((depthM, i) => depthM * (i % 3 === 0 ? 0.5 : 1 + (i % 2)));
    const stairs = { ...plain, groundDepthM: steps };
    expect(flatten(stairs)).toBe(stairs);
  });

  it("is left alone where there is none", () => {
    const { plain } = mapsOf("room.jpg");
    const nothing = { ...plain, groundProbability: plain.groundProbability.map(() => 0) };
    expect(flatten(nothing)).toBe(nothing);
  });
});

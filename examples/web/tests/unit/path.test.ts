import { describe, expect, it } from "vitest";

import { type Maps } from "../../src/core/maps";
import { findPath, type GroundPath } from "../../src/core/path";
import { facts, fixturePath, readFloats } from "../fixtures";

const FLAT = { fx: 100, fy: 100, cx: 0, cy: 0, source: "assumed" } as const;

/** Maps from a drawing: `#` is no ground, `.` sure ground, `?` doubtful ground. */
function drawn(...rows: string[]): Maps {
  const probability: Record<string, number> = { "#": 0.1, ".": 1, "?": 0.6 };
  const ground = Float32Array.from([...rows.join("")].map((each) => probability[each]));
  return {
    height: rows.length,
    width: rows[0].length,
    groundProbability: ground,
    visibleGroundProbability: ground,
    visibleDepthM: ground,
    groundDepthM: ground,
    camera: FLAT,
  };
}

function pathOn(maps: Maps, x: number, y: number): GroundPath {
  const path = findPath(maps, { x: (x + 0.5) / maps.width, y: (y + 0.5) / maps.height });
  if (typeof path === "string") throw new Error(path);
  return path;
}

const cells = (maps: Maps, path: GroundPath) =>
  path.points.map(({ x, y }) => [Math.floor(x * maps.width), Math.floor(y * maps.height)]);

describe("paths of the runtime", () => {
  const photos = Object.entries(facts().photos);
  const cases = photos.flatMap(([name, photo]) => photo.paths.map((path) => ({ name, photo, path })));

  it.each(cases)("cost the same: $name to $path.goal", ({ name, photo, path }) => {
    const { shape, data } = readFloats(fixturePath(`${name}.npy`));
    const [, height, width] = shape;
    const channel = (i: number) => data.slice(i * height * width, (i + 1) * height * width);
    const [fx, fy, cx, cy, source] = photo.camera;
    const maps: Maps = {
      height,
      width,
      visibleGroundProbability: channel(0),
      groundProbability: channel(1),
      visibleDepthM: channel(2),
      groundDepthM: channel(3),
      camera: { fx, fy, cx, cy, source },
    };
    const [x, y] = path.goal;
    const found = findPath(maps, { x, y }) as GroundPath;
    expect(found.cost).toBeCloseTo(path.cost, 4);
    expect(Math.abs(found.lengthM! / path.length_m - 1)).toBeLessThan(0.05);
  });
});

describe("a path", () => {
  it("starts on the ground nearest to the bottom centre", () => {
    const maps = drawn("....#", "....#", "..###", "#####");
    expect(cells(maps, pathOn(maps, 0, 0))[0]).toEqual([1, 2]);
  });

  it("goes around what is no ground, and prefers sure ground to a short cut over doubtful", () => {
    const maps = drawn(".......", ".?????.", ".##.##.", ".......");
    expect(cells(maps, pathOn(maps, 3, 0)).some(([x, y]) => y === 1 && x > 0 && x < 6)).toBe(false);
  });

  it("is straight on even ground, at the cost of its length", () => {
    const maps = drawn(...Array.from({ length: 9 }, () => "....."));
    const path = pathOn(maps, 2, 0);
    expect(cells(maps, path)).toEqual([8, 7, 6, 5, 4, 3, 2, 1, 0].map((y) => [2, y]));
    expect(path.cost).toBeCloseTo(8 * 0.01, 6);
  });

  it("is refused with the reason", () => {
    const maps = drawn(".#.", ".#.", ".#.");
    expect(findPath(maps, { x: 0.5, y: 0.5 })).toBe("goal off ground");
    const start = cells(maps, pathOn(maps, 0, 0))[0][0];
    expect(findPath(maps, { x: start === 0 ? 0.9 : 0.1, y: 0.5 })).toBe("no way");
  });
});

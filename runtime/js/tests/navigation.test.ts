/** The rules on grounds whose answer is known in closed form. */

import { describe, expect, it } from "vitest";

import { GroundPlaneError, NoPathError, OffGroundError, OutsideError, PlanningError } from "../src/errors.ts";
import { cheapestRoute } from "../src/navigation/cheapest-route.ts";
import { distanceTo } from "../src/navigation/distance-transform.ts";
import { Prediction } from "../src/prediction.ts";
import { drawGround } from "../src/drawing/overlay.ts";
import { drawTopDown } from "../src/drawing/top-down.ts";

const SIZE = { height: 96, width: 160 };
const CAMERA = { fx: 120, fy: 120, cx: 79.5, cy: 47.5, source: "given" } as const;
const HEIGHT_M = 1.5;
const HORIZON = 47.5;

/**
 * A level floor below a camera that looks at the horizon. `wallM`: a wall ahead, 2 m wide, that hides the
 * floor behind it.
 */
function floor({ wallM = Infinity, farthestM = 12, height = HEIGHT_M } = {}): Prediction {
  const count = SIZE.height * SIZE.width;
  const maps = Array.from({ length: 4 }, () => new Float32Array(count));
  const [visible, ground, depthM, groundDepthM] = maps;
  for (let i = 0; i < count; i++) {
    const x = (i % SIZE.width) - CAMERA.cx;
    const y = Math.floor(i / SIZE.width) - HORIZON;
    const floorM = y > 0 ? (height * CAMERA.fy) / y : 100;
    const isWall = floorM > wallM && Math.abs((x / CAMERA.fx) * wallM) < 1 && Math.abs(y) < 1.5 * (CAMERA.fy / wallM);
    groundDepthM[i] = floorM;
    ground[i] = floorM < farthestM ? 0.99 : 0.01;
    visible[i] = isWall ? 0.01 : ground[i];
    depthM[i] = isWall ? wallM : floorM;
  }
  return new Prediction({
    visibleGroundProbability: visible,
    groundProbability: ground,
    visibleDepthM: depthM,
    unmaskedGroundDepthM: groundDepthM,
    mapSize: SIZE,
    imageSize: { height: 192, width: 320 },
    intrinsics: CAMERA,
    threshold: 0.5,
    model: { name: "floor", precision: "fp32", runtime: "" },
    timingsMs: { decode: 0, preprocess: 0, inference: 0, postprocess: 0 },
    pose: { heightM: null, pitchDeg: null, rollDeg: null },
    panorama: false,
    laidOnto: null,
  });
}

describe("a level floor", () => {
  it("has its plane, and the ground's places on it", () => {
    const plane = floor().groundPlane();
    expect(plane.cameraHeightM).toBeCloseTo(HEIGHT_M, 4);
    expect(plane.pitchDeg).toBeCloseTo(0, 3);
    const [forwardM, leftM] = plane.atPixel([79.5 - 40, 47.5 + 30], CAMERA);
    expect(forwardM).toBeCloseTo(6, 3);
    expect(leftM).toBeCloseTo(2, 3);
    expect(plane.toPixel([forwardM, leftM], CAMERA)[0]).toBeCloseTo(39.5, 3);
    expect(plane.atPixel([0, 0], CAMERA)[0]).toBeNaN();
  });

  it("says what is at a pixel of the picture", () => {
    const seen = floor().at([160, 2 * (47.5 + 30)]);
    expect(seen.ground).toBe("visible");
    expect(seen.groundDepthM).toBeCloseTo((HEIGHT_M * CAMERA.fy) / 29.5, 4); // row 77 of the maps
    expect(seen.visibleDepthM).toBe(seen.groundDepthM);
    expect(floor().at([160, 10])).toMatchObject({ ground: "none", groundDepthM: NaN });
    const behind = floor({ wallM: 4.5 }).at([160, 2 * (47.5 + 30)]);
    expect(behind).toMatchObject({ ground: "hidden", groundDepthM: seen.groundDepthM, visibleDepthM: 4.5 });
  });

  it("has no plane where there is none, and says why", () => {
    const nothing = floor({ farthestM: 0 });
    expect(() => nothing.topDown()).toThrow(GroundPlaneError);
    expect(nothing.flattened()).toBe(nothing);
    const steps = floor();
    steps.unmaskedGroundDepthM.forEach((depthM, i, all) => (all[i] = depthM * (i % 3 === 0 ? 0.5 : 1 + (i % 2))));
    expect(() => steps.groundPlane()).toThrow(/not flat/);
  });
});

describe("a picture without ground", () => {
  const unsure = floor();
  unsure.groundProbability.forEach((each, i) => (unsure.groundProbability[i] = Math.min(each, 0.8)));

  it("has no plane, and says why each time", () => {
    expect(unsure.showsGround).toBe(false);
    for (let i = 0; i < 2; i++) {
      expect(() => unsure.groundPlane()).toThrow(expect.objectContaining({ reason: "no_ground" }));
    }
    expect(() => unsure.plan([160, 190], [160, 150])).toThrow(GroundPlaneError);
    expect(floor().showsGround).toBe(true);
  });

  it("is a wall that looks like ground up to the upper border, unless that is very sure", () => {
    const seen = ([upper, rest]: [number, number]) => {
      const maps = floor();
      const clear = maps.groundProbability.length / 4;
      maps.groundProbability.fill(upper, 0, clear).fill(rest, clear);
      return maps.showsGround;
    };
    const cases: [number, number][] = [[0.95, 0.95], [0.02, 0.95], [0.999, 0.999]];
    expect(cases.map(seen)).toEqual([false, true, true]);
  });

  it("has nothing drawn", () => {
    const { rgba, labels } = drawGround(unsure, { height: 10, width: 20 });
    expect([rgba.length, Math.max(...rgba), labels.length]).toEqual([800, 0, 0]);
    expect(Math.max(...drawGround(floor(), { height: 10, width: 20 }).rgba)).toBeGreaterThan(0);
  });
});

it("a grid reaches as far as its range", () => {
  expect(floor().topDown(0.3, 1).rows).toBe(4);
  expect(floor().topDown(0.1, 1.1).rows).toBe(11);
});

it("no bearing has no nearest obstacle", () => {
  expect([...floor().topDown().nearestObstacleM([NaN, Infinity])]).toEqual([NaN, NaN]);
});

it("options that are undefined are the usual ones", () => {
  const [start, goal] = [[160, 190], [160, 155]] as const;
  const options = { marginM: undefined, unit: undefined, ground: undefined, robotHeightM: undefined };
  expect(floor().plan(start, goal, options)).toEqual(floor().plan(start, goal));
});

describe("a wall", () => {
  const wall = floor({ wallM: 4.5 });

  it("is seen in its distance, and nothing beside it", () => {
    const { rangesM, confidence } = wall.scan([0, 45]);
    expect(rangesM[0]).toBeGreaterThan(4.3);
    expect(rangesM[0]).toBeLessThan(4.7);
    expect(confidence[0]).toBeGreaterThan(0.3);
    expect(wall.scan([30]).rangesM[0]).toBe(Infinity);
    expect(wall.scan([80]).rangesM[0]).toBeNaN();
    expect(wall.topDown(0.05, 6).nearestObstacleM([0])[0]).toBeCloseTo(rangesM[0], 0);
  });

  it("hides ground, which a path may use and a path on visible ground may not", () => {
    const behind = [160, 2 * (47.5 + 30)] as const;
    const near = [160, 190] as const;
    const path = wall.plan(near, behind, { marginM: 0.1 });
    expect(path.passesHiddenGround).toBe(true);
    expect(path.placesM.at(-1)![0]).toBeCloseTo(6, 0);
    expect(path.lengthM).toBeGreaterThan(2.4);
    // around the wall, not through it
    expect(Math.max(...path.placesM.map(([, leftM]) => Math.abs(leftM)))).toBeGreaterThan(0.9);
    expect(() => wall.plan(near, behind, { ground: "visible" })).toThrow(OffGroundError);
    expect(wall.topDown(0.1, 8).hiddenAreaM2).toBeGreaterThan(1);
    expect(wall.walkableBehindThings(0.1, 8).hiddenAreaM2).toBeGreaterThan(1);
  });

  it("refuses ends with the reason", () => {
    const near = [160, 190] as const;
    expect(() => wall.plan(near, [400, 10])).toThrow(OutsideError);
    expect(() => wall.plan(near, [160, 20])).toThrow(OffGroundError);
    expect(() => wall.plan(near, [160, NaN])).toThrow(PlanningError);
    const island = floor();
    const row = (metres: number) => Math.round(HORIZON + (HEIGHT_M * CAMERA.fy) / metres);
    const gap = [row(5) * SIZE.width, (row(5) + 3) * SIZE.width];
    island.groundProbability.fill(0.01, ...gap);
    expect(() => island.plan(near, [160, 2 * row(7)])).toThrow(NoPathError);
    expect(() => wall.plan(near, [160, 2 * row(6)], { marginM: 3 })).toThrow(OffGroundError);
  });
});

describe("pictures", () => {
  it("have lines where the metres are", () => {
    const { labels } = drawGround(floor().flattened(), { height: 192, width: 320 });
    expect(labels.map(({ metres }) => metres)).toContain(5);
    for (const { metres, x, y } of labels) {
      expect(floor().flattened().at([x * 320 - 0.5, y * 192 - 0.5]).groundDepthM / metres).toBeCloseTo(1, 1);
    }
  });

  it("show a grid from above", () => {
    const { data, width, height } = drawTopDown(floor({ wallM: 4.5 }).topDown(0.05, 6), 120);
    expect([width, height, data.length]).toEqual([240, 120, 4 * 240 * 120]);
    const at = (x: number, y: number) => [...data.slice(4 * (y * width + x), 4 * (y * width + x) + 3)];
    const ahead = Array.from({ length: 8 }, (_, i) => at(120, 26 + i).join());
    expect(ahead).toContain("8,9,13"); // the wall, 4.5 m of 6 m ahead
    expect(at(2, 2)).toEqual([44, 48, 58]); // out of view
  });
});

it("distances to a set are Euclidean", () => {
  const set = new Uint8Array(35);
  set[0] = set[23] = 1;
  const found = distanceTo(set, 7);
  found.forEach((each, i) => {
    const away = (cell: number) => Math.hypot((i % 7) - (cell % 7), Math.floor(i / 7) - Math.floor(cell / 7));
    expect(each).toBeCloseTo(Math.min(away(0), away(23)), 9);
  });
  expect(distanceTo(new Uint8Array(4), 2)[0]).toBe(Infinity);
});

it("no route slips between two closed cells that meet in a corner", () => {
  const costs = new Float64Array(54).fill(0.1);
  for (let row = 0; row < 5; row++) costs[9 * row + row + 2] = -1; // a slanting wall, open at the bottom
  const route = cheapestRoute(costs, 9, 10, 14)!;
  expect(Math.max(...route)).toBeGreaterThanOrEqual(45);
  costs[9 * 5 + 7] = -1;
  expect(cheapestRoute(costs, 9, 10, 14)).toBeNull();
});

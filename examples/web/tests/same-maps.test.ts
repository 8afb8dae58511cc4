/** The page sees what the Python runtime sees. */

import { afterAll, beforeAll, expect, inject, it } from "vitest";

import { facts, fixturePath, readFloats } from "../../../runtime/js/tests/fixtures";
import { Visit } from "./visit";

let visit: Visit;

beforeAll(async () => {
  visit = await Visit.begin();
  await visit.page.goto(inject("isolatedUrl"));
  await visit.resultCount(1);
});

afterAll(() => visit.end());

function iou(one: boolean[], other: boolean[]): number {
  let both = 0;
  let either = 0;
  one.forEach((each, i) => {
    both += Number(each && other[i]);
    either += Number(each || other[i]);
  });
  return either === 0 ? 1 : both / either;
}

it.each(Object.keys(facts().photos))("in %s", async (name) => {
  const before = await visit.results();
  await visit.page.setInputFiles("#file", fixturePath(name));
  await visit.resultCount(before + 1);
  const [found, expected] = [await visit.maps(), readFloats(fixturePath(`${name}.npy`))];
  expect(found.shape).toEqual(expected.shape);
  const pixels = found.shape[1] * found.shape[2];

  const masks = (maps: Float32Array) => {
    const [visible, ground] = [0, 1].map((channel) =>
      Array.from(maps.subarray(channel * pixels, (channel + 1) * pixels), (each) => each > 0.5),
    );
    return { visible, ground, hidden: ground.map((each, i) => each && !visible[i]) };
  };
  const [ours, theirs] = [masks(found.data), masks(expected.data)];
  for (const kind of ["visible", "ground", "hidden"] as const) {
    expect(theirs[kind]).toContain(true);
    expect(iou(ours[kind], theirs[kind]), `IoU of ${kind}`).toBeGreaterThanOrEqual(0.995);
  }
  for (const channel of [2, 3]) {
    const off = Array.from({ length: pixels }, (_, i) => {
      const at = channel * pixels + i;
      return Math.abs(found.data[at] / expected.data[at] - 1);
    });
    expect(off.sort((a, b) => a - b)[Math.floor(0.9 * pixels)]).toBeLessThan(0.02);
  }
  expect(visit.errors).toEqual([]);
});

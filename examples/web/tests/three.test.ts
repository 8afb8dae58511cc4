/** The example with three.js. */

import { afterAll, beforeAll, expect, inject, it } from "vitest";

import { PATIENCE, Visit } from "./visit";

let visit: Visit;

beforeAll(async () => {
  visit = await Visit.begin({ flags: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
});
afterAll(() => visit.end());

/** Pixels in the colour of the walker's shirt, after a share of the path. */
async function shirt(share: number): Promise<number> {
  await visit.page.evaluate((each) => (globalThis as unknown as { hold(s: number): void }).hold(each), share);
  await visit.page.waitForTimeout(500);
  return visit.page.evaluate(async () => {
    const stage = document.querySelector<HTMLCanvasElement>("#scene")!;
    const drawn = new Promise<ImageBitmap>((resolve) =>
      requestAnimationFrame(() => setTimeout(() => resolve(createImageBitmap(stage)))),
    );
    const picture = await drawn;
    const context = new OffscreenCanvas(picture.width, picture.height).getContext("2d")!;
    context.drawImage(picture, 0, 0);
    const { data } = context.getImageData(0, 0, picture.width, picture.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (data[i] > 170 && data[i + 1] > 120 && data[i + 2] < 60) count++;
    }
    return count;
  });
}

it("hides the walker behind the table", { timeout: 60_000 * PATIENCE }, async () => {
  await visit.page.goto(new URL("three.html", inject("isolatedUrl")).href);
  await visit.page.waitForFunction(
    () => (globalThis as unknown as { hold?(s: number): { ready: boolean } }).hold?.(0).ready,
    null,
    { timeout: 40_000 * PATIENCE, polling: 500 },
  );
  const [inView, behind] = [await shirt(0.6), await shirt(0.96)];
  console.log(`shirt: ${inView} pixels in view, ${behind} behind the table`);
  expect(inView).toBeGreaterThan(behind + 100);
  expect(visit.errors).toEqual([]);
});

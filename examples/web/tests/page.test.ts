/** What a visitor meets. */

import { crc32, deflateSync } from "node:zlib";

import type { Prediction } from "footprints-edge";
import { afterAll, afterEach, beforeAll, describe, expect, inject, it } from "vitest";

import { fixturePath } from "../../../runtime/js/tests/fixtures";
import { PATIENCE, Visit, type VisitOptions } from "./visit";

/** Seconds from the start of loading to the first result, on a machine that does nothing else. */
const FIRST_RESULT_S = 3;

let visit: Visit;

async function open(options: VisitOptions = {}, url = inject("isolatedUrl")): Promise<Visit> {
  visit = await Visit.begin(options);
  await visit.page.goto(url);
  await visit.resultCount(1);
  return visit;
}

/** Waits until the page is kept on the device, and comes back to it. */
async function comeBack({ page }: Visit): Promise<void> {
  await page.evaluate(() => navigator.serviceWorker.ready);
  await page.waitForFunction(() => navigator.serviceWorker.controller !== null);
  await page.reload();
}

/** A black PNG of so many pixels along each side, a bit a pixel. */
function blackPng(side: number): Buffer {
  const chunk = (kind: string, data: Buffer) => {
    const body = Buffer.concat([Buffer.from(kind, "latin1"), data]);
    const whole = Buffer.alloc(body.length + 8);
    whole.writeUInt32BE(data.length, 0);
    body.copy(whole, 4);
    whole.writeUInt32BE(crc32(body), body.length + 4);
    return whole;
  };
  const head = Buffer.alloc(13);
  head.writeUInt32BE(side, 0);
  head.writeUInt32BE(side, 4);
  head.writeUInt8(1, 8);
  const rows = deflateSync(Buffer.alloc((1 + Math.ceil(side / 8)) * side));
  const start = Buffer.from("\x89PNG\r\n\x1a\n", "latin1");
  return Buffer.concat([start, chunk("IHDR", head), chunk("IDAT", rows), chunk("IEND", Buffer.alloc(0))]);
}

const PHONE = { width: 360, height: 800, touch: true };

describe("a first visit", () => {
  afterEach(() => visit.end());

  it("shows a result soon, asks no other host, and complains about nothing", async () => {
    const { page, errors, requests } = await open();
    const firstMs = await page.evaluate(
      () => performance.getEntriesByName("first result")[0].startTime,
    );
    console.log(`first result after ${(firstMs / 1000).toFixed(2)} s`);
    expect(firstMs).toBeLessThan(1000 * FIRST_RESULT_S * PATIENCE);
    await comeBack(visit);
    await visit.resultCount(1);
    const hosts = new Set(requests.filter((url) => !/^(blob|data):/.test(url)).map((url) => new URL(url).host));
    expect([...hosts]).toEqual([new URL(inject("isolatedUrl")).host]);
    expect(requests.some((url) => url.endsWith(".onnx"))).toBe(true);
    expect(requests.some((url) => /asyncify|webgpu/.test(url))).toBe(false);
    expect(errors).toEqual([]);
  });

  it("forbids the page itself to ask another host", async () => {
    const { page, errors } = await open();
    const asked = page.evaluate(() => fetch("https://example.org/").then(String, String));
    expect(await asked).toContain("Failed to fetch");
    expect(errors.join()).toContain("Content Security Policy");
  });

  it.each([PHONE, { width: 1280, height: 800 }])("fits on $width x $height", async (size) => {
    const { page } = await open(size);
    const { wide, picture } = await page.evaluate(() => ({
      wide: document.documentElement.scrollWidth,
      picture: document.querySelector("#picture")!.getBoundingClientRect().toJSON(),
    }));
    expect(wide).toBe(size.width);
    expect(picture.width).toBeGreaterThan(0.6 * size.width);
    expect(picture.width / picture.height).toBeCloseTo(1280 / 720, 1);
    for (const button of ["#camera", "#photo-label"]) {
      const box = (await page.locator(button).boundingBox())!;
      expect(box.y + box.height).toBeLessThanOrEqual(size.height);
      expect(box.height).toBeGreaterThanOrEqual(44);
    }
  });
});

describe("a visit whose network fails", () => {
  afterEach(() => visit.end());

  it("says what does not start, and starts it with the next photo", async () => {
    visit = await Visit.begin();
    const { page } = visit;
    const lost = /\.(onnx|jpg)$/;
    await page.context().route(lost, (route) => route.abort());
    await page.goto(inject("isolatedUrl"));
    expect(await visit.says("#notice", /./)).toMatch(/does not start on this device: .*fetch/);
    await page.context().unroute(lost);
    await page.setInputFiles("#file", fixturePath("upright.png"));
    await visit.resultCount(1);
    expect(await page.isVisible("#notice")).toBe(false);
  });
});

describe("a second visit", () => {
  afterEach(() => visit.end());

  it("needs no network", async () => {
    const { context, page, errors } = await open();
    await comeBack(visit);
    await visit.resultCount(1);
    await context.setOffline(true);
    await page.reload();
    await visit.resultCount(1);
    await page.setInputFiles("#file", fixturePath("upright.png"));
    await visit.resultCount(2);
    expect(await visit.text("#run")).toContain("288 × 384");
    expect(errors).toEqual([]);
  });

  it("has threads, also from a server without the headers for them", async () => {
    const { page, errors } = await open({}, inject("plainUrl"));
    expect(await page.evaluate(() => crossOriginIsolated)).toBe(false);
    expect(await visit.text("#run")).toContain("1 thread ");
    await comeBack(visit);
    await visit.resultCount(1);
    expect(await page.evaluate(() => crossOriginIsolated)).toBe(true);
    const cores = await page.evaluate(() => navigator.hardwareConcurrency);
    expect(await visit.text("#run")).toContain(`${Math.min(4, cores)} thread`);
    expect(errors).toEqual([]);
  });

  it("can be installed", async () => {
    const { page } = await open();
    const client = await page.context().newCDPSession(page);
    await comeBack(visit);
    const { installabilityErrors } = await client.send("Page.getInstallabilityErrors");
    const reasons = installabilityErrors.map(({ errorId }) => errorId);
    expect(reasons.filter((reason) => reason !== "in-incognito")).toEqual([]);
  });
});

describe("the camera", () => {
  afterEach(() => visit.end());

  it("is shown live, with a path to where one taps", async () => {
    const { page, errors } = await open({ ...PHONE, film: "camera-upright.mjpeg" });
    await page.click("#camera");
    await visit.resultCount(5);
    expect(await visit.says("#speed", /^[0-9.]+ frames\/s$/)).toBeTruthy();
    const sums = await page.evaluate(() =>
      (globalThis as unknown as { results: { prediction: { groundProbability: Float32Array } }[] }).results
        .slice(-3)
        .map(({ prediction }) => prediction.groundProbability.reduce((sum, each) => sum + each)),
    );
    expect(new Set(sums).size).toBeGreaterThan(1);

    const box = (await page.locator("#picture").boundingBox())!;
    await page.touchscreen.tap(box.x + 0.5 * box.width, box.y + 0.9 * box.height);
    expect(await visit.says("#path", /./)).toMatch(/^(Path of \d|No path)/);
    await page.click("#camera");
    expect(await visit.says("#status", /off/)).toBe("The camera is off.");
    const shown = await visit.results();
    await page.waitForTimeout(1000);
    expect(await visit.results()).toBeLessThanOrEqual(shown + 1);
    expect(errors).toEqual([]);
  });

  it("says so where it is not allowed", async () => {
    const options = { film: "camera.mjpeg", allowCamera: false, flags: ["--deny-permission-prompts"] };
    const { page, errors } = await open(options);
    await page.click("#camera");
    expect(await visit.says("#notice", /./)).toMatch(/not allowed.*choose a photo/);
    expect(await page.isVisible("#notice")).toBe(true);
    expect(errors).toEqual([]);
  });
});

describe("on a desk without a camera", () => {
  beforeAll(() => open());
  afterAll(() => visit.end());
  afterEach(() => expect(visit.errors).toEqual([]));

  it("says that there is no camera", async () => {
    await visit.page.click("#camera");
    expect(await visit.says("#notice", /./)).toMatch(/No camera was found.*choose a photo/);
  });

  it("refuses a photo that is none in words, and goes on", async () => {
    const { page } = visit;
    const before = await visit.results();
    await page.setInputFiles("#file", { name: "a.jpg", mimeType: "image/jpeg", buffer: Buffer.from("no") });
    expect(await visit.says("#notice", /./)).toContain("a.jpg is not a picture");
    await page.setInputFiles("#file", fixturePath("room.jpg"));
    await visit.resultCount(before + 1);
    expect(await page.isVisible("#notice")).toBe(false);
  });

  it("takes a photo of 144 megapixels, or says why not, and goes on", async () => {
    const { page } = visit;
    const before = await visit.results();
    await page.setInputFiles("#file", { name: "a.png", mimeType: "image/png", buffer: blackPng(12000) });
    await page.waitForFunction(
      (count) =>
        (globalThis as unknown as { results: unknown[] }).results.length > count ||
        /smaller|cannot|can read/.test(document.querySelector("#notice")!.textContent!),
      before,
      { timeout: 50_000 * PATIENCE },
    );
    const shown = await visit.results();
    await page.setInputFiles("#file", fixturePath("room.jpg"));
    await visit.resultCount(shown + 1);
    expect(await page.isVisible("#notice")).toBe(false);
  });

  it("starts another worker where one has ended", async () => {
    const { page } = visit;
    const analyst = () => page.workers().find((worker) => /analyst/.test(worker.url()))!;
    const shown = await visit.results();
    await analyst().evaluate(() => {
      self.onmessage = () => self.close();
    });
    await page.setInputFiles("#file", fixturePath("room.jpg"));
    expect(await visit.says("#notice", /./)).toMatch(/more memory than there is/);
    await page.setInputFiles("#file", fixturePath("room.jpg"));
    await visit.resultCount(shown + 1);
    expect(await page.isVisible("#notice")).toBe(false);
  });

  it("reads the distance under the pointer", async () => {
    const { page } = visit;
    const box = (await page.locator("#picture").boundingBox())!;
    const readAt = async (y: number) => {
      await page.mouse.move(box.x + box.width / 2, box.y + y * box.height);
      return [await visit.text("#distance"), await visit.text("#what")];
    };
    const [near, nearWords] = await readAt(0.97);
    const [far, farWords] = await readAt(0.75);
    expect(nearWords).toMatch(/^ground you can see, \d\.\d m along it$/);
    expect(farWords).toMatch(/^ground you can see, /);
    expect(parseFloat(near)).toBeGreaterThan(1.5);
    expect(parseFloat(far)).toBeGreaterThan(parseFloat(near));
    expect((await readAt(0.1))[1]).toBe("not walkable");
  });

  it("reads on each line the distance that stands on the line", async () => {
    const off = await visit.page.evaluate(() => {
      type Result = { prediction: Prediction; labels: { metres: number; x: number; y: number }[] };
      const { prediction, labels } = (globalThis as unknown as { results: Result[] }).results.at(-1)!;
      const { width, height } = prediction.imageSize;
      return labels.map(({ metres, x, y }) =>
        Math.abs(prediction.at([x * width, y * height]).groundDepthM / metres - 1),
      );
    });
    expect(off.length).toBeGreaterThan(1);
    // a line runs between two pixels of the maps
    expect(Math.max(...off)).toBeLessThan(0.05);
  });

  it("takes a lens and a height, and moves the metres by them", async () => {
    const { page } = visit;
    const set = async (id: string, value: string) => {
      const before = await visit.results();
      await page.fill(id, value);
      await page.press(id, "Tab");
      await visit.resultCount(before + 1);
    };
    const plane = () =>
      page.evaluate(() => {
        const results = (globalThis as unknown as { results: { prediction: Prediction }[] }).results;
        const { laidOnto, intrinsics } = results.at(-1)!.prediction;
        return { heightM: laidOnto!.cameraHeightM, focalPx: intrinsics.fx };
      });
    const estimated = await plane();
    await set("#height", "2.5");
    expect((await plane()).heightM).toBeCloseTo(2.5, 6);
    expect(await visit.text("#pose")).toMatch(/^Camera 2\.50 m above the ground, looks down by/);
    await set("#height", "");
    await set("#lens", "90");
    expect((await plane()).focalPx).toBeCloseTo(448 / 2, 6);
    expect(await visit.text("#run")).toContain("lens as set");
    await set("#lens", "");
    expect(await plane()).toEqual(estimated);
  });

  it("finds a path by keys alone, and says so aloud", async () => {
    const { page } = visit;
    await page.mouse.move(0, 0);
    const reached = new Set<string>();
    for (let i = 0; i < 8; i++) {
      await page.keyboard.press("Tab");
      reached.add(await page.evaluate(() => document.activeElement!.id || document.activeElement!.tagName));
    }
    expect([...reached]).toEqual(expect.arrayContaining(["picture", "camera", "file", "lens", "height"]));

    await page.focus("#picture");
    await page.keyboard.press("ArrowUp");
    await page.keyboard.press("Shift+ArrowLeft");
    expect(await visit.says("#status", /m, /)).toMatch(/^\d+\.\d m, ground you can see, \d+\.\d m along it$/);
    await page.keyboard.press("Enter");
    expect(await visit.says("#status", /Path of/)).toMatch(/^Path of \d+\.\d m/);
    expect(await page.locator("#marks .path-line").count()).toBe(1);
    await page.keyboard.press("Escape");
    expect(await visit.text("#path")).toBe("");
    expect(await page.locator("#marks .path-line").count()).toBe(0);
  });

  it("has a name for everything one can reach", async () => {
    const tree = await visit.page.locator("body").ariaSnapshot();
    for (const line of [
      'application "Picture with walkable ground"',
      'button "Camera"',
      'button "Photo"',
      'group "Your camera"',
      'group "Runs on"',
      'radio "WebAssembly" [checked]',
      'radio "WebGPU"',
    ]) {
      expect(tree).toContain(line);
    }
  });

  it("does not offer WebGPU where there is none, and says why", async () => {
    expect(await visit.page.isDisabled("input[value=webgpu]")).toBe(true);
    expect(await visit.says("#engine-note", /./)).toMatch(/WebGPU/);
  });
});

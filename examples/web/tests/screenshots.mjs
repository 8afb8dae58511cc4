/** Takes the pictures in docs/web.md and docs/javascript.md anew: `node tests/screenshots.mjs`, while `make web` serves. */

import { fileURLToPath } from "node:url";

import { chromium } from "playwright-core";

const url = process.env.PAGE ?? "http://localhost:4173/";
const fileOf = (path) => fileURLToPath(new URL(path, import.meta.url));
const film = fileOf("../../../runtime/js/tests/fixtures/camera-upright.mjpeg");

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--use-fake-device-for-media-stream",
    `--use-file-for-fake-video-capture=${film}`,
  ],
});

/** Opens the page, shows so many results, points at a place, and takes the picture. */
async function take(name, { size, scale, colours, hasTouch, camera, results, at }) {
  const context = await browser.newContext({
    viewport: size,
    deviceScaleFactor: scale,
    colorScheme: colours,
    hasTouch,
    permissions: ["camera"],
  });
  const page = await context.newPage();
  page.setDefaultTimeout(240_000);
  await page.addInitScript(() => {
    globalThis.count = 0;
    document.addEventListener("footprints-result", () => globalThis.count++);
  });
  await page.goto(url);
  await page.waitForFunction(() => globalThis.count >= 1);
  if (camera) await page.click("#camera");
  else await page.setInputFiles("#file", fileOf("../../room.jpg"));
  await page.waitForFunction((wanted) => globalThis.count >= wanted, results);
  const box = await page.locator("#picture").boundingBox();
  const place = [box.x + at[0] * box.width, box.y + at[1] * box.height];
  if (hasTouch) await page.touchscreen.tap(...place);
  else await page.mouse.click(...place);
  await page.waitForFunction(() => document.querySelector("#path").textContent !== "");
  await page.screenshot({ path: fileOf(`../../../docs/images/${name}.jpg`), quality: 82 });
  await context.close();
}

/** The walker of three.html after shares of its path, side by side. */
async function takeWalk(name, shares, clip) {
  const page = await browser.newPage({ viewport: { width: 1320, height: 860 } });
  page.setDefaultTimeout(240_000);
  await page.goto(new URL("three.html", url).href);
  await page.waitForFunction(() => globalThis.hold?.(0).ready, null, { polling: 500 });
  const pictures = [];
  for (const share of shares) {
    await page.evaluate((each) => hold(each), share);
    await page.waitForTimeout(1500);
    pictures.push((await page.screenshot({ clip })).toString("base64"));
  }
  const images = pictures.map((each) => `<img src="data:image/png;base64,${each}">`).join(" ");
  await page.goto("about:blank");
  await page.setContent(`<style>body { margin: 0; white-space: nowrap; font-size: 8px }</style>${images}`);
  await page.setViewportSize({ width: shares.length * (clip.width + 2), height: clip.height });
  await page.screenshot({ path: fileOf(`../../../docs/images/${name}.jpg`), quality: 82 });
  await page.close();
}

await takeWalk("three-walk", [0.5, 0.62, 0.72], { x: 700, y: 280, width: 500, height: 420 });
await take("web-desktop", {
  size: { width: 1280, height: 800 },
  scale: 1,
  colours: "light",
  hasTouch: false,
  camera: false,
  results: 2,
  at: [0.61, 0.66],
});
await take("web-phone", {
  size: { width: 360, height: 800 },
  scale: 2,
  colours: "dark",
  hasTouch: true,
  camera: true,
  results: 9,
  at: [0.33, 0.66],
});
await browser.close();

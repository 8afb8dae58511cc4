/** Takes the pictures in docs/web.md anew: `node tests/screenshots.mjs`, while `make web` serves. */

import { fileURLToPath } from "node:url";

import { chromium } from "playwright-core";

const url = process.env.PAGE ?? "http://localhost:4173/";
const fileOf = (path) => fileURLToPath(new URL(path, import.meta.url));
const film = fileOf("fixtures/camera-upright.mjpeg");

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: [
    "--no-sandbox",
    "--disable-gpu",
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

await take("web-desktop", {
  size: { width: 1280, height: 800 },
  scale: 1,
  colours: "light",
  hasTouch: false,
  camera: false,
  results: 2,
  at: [0.38, 0.62],
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

/**
 * How long the built page takes for a frame of a camera, beside its network.
 *
 *     node tests/speed.mjs [FRAMES]     # in examples/web, after `npm run build`
 */

import { chromium } from "playwright-core";
import { preview } from "vite";

/** The first frames fill caches. */
const UNCOUNTED = 3;

const frames = Number(process.argv[2] ?? 40);
const server = await preview({ preview: { port: 0, host: "127.0.0.1" } });
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu", "--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"],
});
try {
  const context = await browser.newContext({ permissions: ["camera"] });
  const page = await context.newPage();
  page.setDefaultTimeout(120_000);
  await page.addInitScript(() => {
    globalThis.found = [];
    document.addEventListener("footprints-result", ({ detail }) => {
      const words = document.getElementById("run").textContent;
      const [network, all] = words.match(/network (\d+) ms of (\d+) ms/)?.slice(1).map(Number) ?? [];
      if (all) globalThis.found.push({ network, all, words, ...detail.prediction.timingsMs });
    });
  });
  await page.goto(server.resolvedUrls.local[0]);
  await page.click("#camera:enabled");
  const wanted = frames + UNCOUNTED;
  await page.waitForFunction((count) => globalThis.found.length >= count, wanted, { timeout: 10_000 * wanted });
  const counted = (await page.evaluate(() => globalThis.found)).slice(UNCOUNTED);
  const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];
  console.log(counted.at(-1).words);
  for (const step of ["decode", "preprocess", "inference", "postprocess", "all"])
    console.log(`${step}: ${median(counted.map((each) => each[step])).toFixed(0)} ms`);
  console.log(`all / network: ${median(counted.map(({ all, network }) => all / network)).toFixed(2)}`);
} finally {
  await browser.close();
  await server.close();
}

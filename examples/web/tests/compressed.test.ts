/** What the build compresses, and what a first visit needs of it. */

import { existsSync, readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliDecompressSync, gunzipSync } from "node:zlib";

import { expect, it } from "vitest";

const DIST = fileURLToPath(new URL("../dist", import.meta.url));
const MOST_BYTES = 10e6;

const KINDS = { br: brotliDecompressSync, gz: gunzipSync };

/** The files that the service worker keeps: all that the page needs. */
function filesOfTheFirstVisit(): string[] {
  const list = /\[[^\]]*"index\.html"[^\]]*\]/.exec(readFileSync(join(DIST, "service-worker.js"), "utf8"))!;
  return JSON.parse(list[0]) as string[];
}

for (const kind of Object.keys(KINDS) as (keyof typeof KINDS)[]) {
  it(`holds the same bytes in every .${kind}`, () => {
    const files = readdirSync(DIST, { recursive: true, encoding: "utf8" });
    const compressed = files.filter((file) => file.endsWith(`.${kind}`));
    expect(compressed.some((file) => file.includes(".wasm"))).toBe(true);
    for (const file of compressed) {
      const whole = readFileSync(join(DIST, file.slice(0, -3)));
      expect(KINDS[kind](readFileSync(join(DIST, file))).equals(whole), file).toBe(true);
    }
  });

  it(`sends at most 10 MB on a first visit by .${kind}`, () => {
    const sent = filesOfTheFirstVisit().map((file) => {
      const path = join(DIST, file);
      return readFileSync(existsSync(`${path}.${kind}`) ? `${path}.${kind}` : path).length;
    });
    expect(sent.length).toBeGreaterThan(5);
    expect(sent.reduce((a, b) => a + b)).toBeLessThan(MOST_BYTES);
  });
}

it("keeps no compressed file in the service worker's list", () => {
  expect(filesOfTheFirstVisit().filter((file) => /\.(br|gz)$/.test(file))).toEqual([]);
});

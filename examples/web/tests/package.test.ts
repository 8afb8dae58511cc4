/** The page of docs/javascript.md, in a folder into which the packed package was installed. */

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

import { preview, type PreviewServer } from "vite";
import { afterAll, beforeAll, expect, it } from "vitest";

import { PATIENCE, Visit } from "./visit";

const at = (path: string) => fileURLToPath(new URL(path, import.meta.url));

let folder: string;
let server: PreviewServer;
let visit: Visit;

beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "footprints-app-"));
  const pack = ["pack", "--silent", "--ignore-scripts", "--pack-destination", folder];
  const tarball = execFileSync("npm", pack, { cwd: at("../../../runtime/js"), encoding: "utf8" }).trim();
  const install = ["install", "--offline", "--no-audit", "--no-fund", join(folder, tarball)];
  execFileSync("npm", install, { cwd: folder });
  // The runtime beside it, as `npm install onnxruntime-web` puts it there.
  symlinkSync(at("../node_modules/onnxruntime-web"), join(folder, "node_modules/onnxruntime-web"));
  const page = /```html\n([^]*?)```/.exec(readFileSync(at("../../../docs/javascript.md"), "utf8"))![1];
  expect(page.trim().split("\n").length).toBeLessThanOrEqual(20);
  writeFileSync(join(folder, "index.html"), page);
  server = await preview({
    configFile: false,
    root: folder,
    build: { outDir: "." },
    preview: { port: 0, host: "127.0.0.1" },
  });
  visit = await Visit.begin({ film: "camera-upright.mjpeg" });
});

afterAll(async () => {
  await visit.end();
  await server.close();
  rmSync(folder, { recursive: true });
});

it("shows walkable ground over the camera, and asks no other host", async () => {
  const url = server.resolvedUrls!.local[0];
  await visit.page.goto(url);
  await visit.page.waitForFunction(
    () => {
      const canvas = document.querySelector("canvas")!;
      const { data } = canvas.getContext("2d")!.getImageData(0, 0, canvas.width, canvas.height);
      return data.some((value, i) => i % 4 === 3 && value > 0);
    },
    null,
    { timeout: 40_000 * PATIENCE, polling: 500 },
  );
  const hosts = new Set(visit.requests.filter((each) => !/^(blob|data):/.test(each)).map((each) => new URL(each).host));
  expect([...hosts]).toEqual([new URL(url).host]);
  expect(visit.errors.filter((error) => !error.includes("favicon") && !error.includes("404"))).toEqual([]);
});

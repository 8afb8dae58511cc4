/** The page's code, held against the test vectors that `fp-export vectors` writes. */

import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { afterAll, beforeAll, expect, inject, it } from "vitest";

import { fixturePath, numpyFile } from "../../../runtime/js/tests/fixtures";
import type { Outputs, Vector } from "./vectors-page";
import { PATIENCE, Visit } from "./visit";

type Entry = Omit<Vector, "image" | "swapped"> & { name: string; files: { image: string } };

const vectors = fixturePath("vectors");
const python = process.env.PYTHON ?? "python3";
const { vectors: entries } = JSON.parse(readFileSync(join(vectors, "vectors.json"), "utf8")) as {
  vectors: Entry[];
};

let visit: Visit;
let scratch: string;

beforeAll(async () => {
  scratch = mkdtempSync(join(tmpdir(), "footprints-web-"));
  visit = await Visit.begin();
  await visit.page.goto(new URL("tests/vectors.html", inject("sourceUrl")).href);
  await visit.page.waitForFunction(() => "run" in globalThis, null, { timeout: 30_000 * PATIENCE });
});

afterAll(async () => {
  await visit.end();
  rmSync(scratch, { recursive: true });
});

async function write(entry: Entry, swapped: boolean, folder: string): Promise<void> {
  const png = readFileSync(join(vectors, entry.files.image)).toString("base64");
  const outputs = await visit.page.evaluate(
    (vector) => (globalThis as unknown as { run: (v: Vector) => Promise<Outputs> }).run(vector),
    { ...entry, image: `data:image/png;base64,${png}`, swapped },
  );
  mkdirSync(join(folder, entry.name), { recursive: true });
  for (const [name, { shape, bytes, url }] of Object.entries(outputs)) {
    const data = Uint8Array.from(Buffer.from(url.slice(url.indexOf(",") + 1), "base64"));
    const values = bytes ? data : new Float32Array(data.buffer);
    writeFileSync(join(folder, entry.name, `${name}.npy`), numpyFile(values, shape));
  }
}

/** The checker's report; it throws where the checker finds a difference. */
function check(folder: string): string {
  const program = "from footprints_edge_export.cli import app; app()";
  return execFileSync(python, ["-c", program, "check-vectors", vectors, folder], {
    encoding: "utf8",
    stdio: "pipe",
  });
}

it("agrees with every vector", async () => {
  const folder = process.env.VECTOR_OUTPUTS ?? join(scratch, "right"); // tests/ports/run.py wants them
  for (const entry of entries) await write(entry, false, folder);
  expect(check(folder)).not.toContain("DIFFERS");
  expect(visit.errors).toEqual([]);
});

it("would not, with red and blue swapped", async () => {
  const folder = join(scratch, "swapped");
  for (const entry of entries) await write(entry, true, folder);
  let report = "";
  try {
    check(folder);
  } catch (error) {
    report = (error as { stdout: string }).stdout;
  }
  for (const { name } of entries) expect(report).toContain(`DIFFERS ${name}: input`);
});

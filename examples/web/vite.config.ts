import { createHash } from "node:crypto";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join, relative, sep } from "node:path";
import { fileURLToPath } from "node:url";

import { defaultClientConditions, type Plugin } from "vite";
import { defineConfig } from "vitest/config";

const repository = fileURLToPath(new URL("../..", import.meta.url));

/** Servers that send these let the page use threads; see docs/web.md. */
const isolation = {
  "Cross-Origin-Opener-Policy": "same-origin",
  "Cross-Origin-Embedder-Policy": "require-corp",
};

/** Files that are fetched, and then kept, only once someone asks for WebGPU, or opens the other page. */
const ON_DEMAND = /asyncify|webgpu|three/;

export default defineConfig({
  base: "./",
  resolve: {
    // The runtime's own files stay files of their own: its threads load them by address.
    conditions: ["onnxruntime-web-use-extern-wasm", ...defaultClientConditions],
    // The package is linked here, and would find the runtime beside its own sources.
    dedupe: ["onnxruntime-web"],
  },
  optimizeDeps: { exclude: ["footprints-edge", "onnxruntime-web"] },
  server: { headers: isolation, fs: { allow: [repository] } },
  preview: { headers: isolation },
  worker: { format: "es" },
  build: {
    target: "es2022",
    assetsInlineLimit: 0,
    rolldownOptions: {
      input: {
        main: fileURLToPath(new URL("index.html", import.meta.url)),
        three: fileURLToPath(new URL("three.html", import.meta.url)),
        "service-worker": fileURLToPath(new URL("src/workers/service-worker.ts", import.meta.url)),
      },
      output: {
        entryFileNames: ({ name }) =>
          name === "service-worker" ? "service-worker.js" : "assets/[name]-[hash].js",
      },
    },
  },
  plugins: [fillInServiceWorker()],
  test: {
    include: ["tests/**/*.test.ts"],
    globalSetup: "tests/serve.ts",
    fileParallelism: false,
    testTimeout: 60_000 * Number(process.env.PATIENCE ?? 1),
    hookTimeout: 60_000 * Number(process.env.PATIENCE ?? 1),
  },
});

/** Tells the service worker which files make up the page, and a version that changes with them. */
function fillInServiceWorker(): Plugin {
  let folder = "";
  return {
    name: "fill-in-service-worker",
    apply: "build",
    configResolved(config) {
      folder = join(config.root, config.build.outDir);
    },
    closeBundle() {
      const script = join(folder, "service-worker.js");
      const files = readdirSync(folder, { recursive: true, withFileTypes: true })
        .filter((entry) => entry.isFile() && !ON_DEMAND.test(entry.name))
        .map((entry) => relative(folder, join(entry.parentPath, entry.name)))
        .filter((file) => file !== "service-worker.js")
        .sort();
      const hash = createHash("sha256");
      for (const file of files) hash.update(file).update(readFileSync(join(folder, file)));
      const text = readFileSync(script, "utf8")
        .replace(/["'`]%FILES%["'`]/, JSON.stringify(files.map((file) => file.replaceAll(sep, "/"))))
        .replace("%VERSION%", hash.digest("hex").slice(0, 16));
      writeFileSync(script, text);
    },
  };
}

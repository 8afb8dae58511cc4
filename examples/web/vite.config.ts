import { createHash } from "node:crypto";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join, relative, sep } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync, constants, gzipSync } from "node:zlib";

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

const COMPRESSED = /\.(br|gz)$/;

/** Files of these kinds are compressed already. */
const PACKED = /\.(png|jpe?g|webp|avif|woff2)$/;

/** More takes up to six times as long, for 5 % less. */
const BROTLI_QUALITY = 5;

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
  plugins: [fillInServiceWorker(), compress()],
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
        .filter((entry) => entry.isFile() && !ON_DEMAND.test(entry.name) && !COMPRESSED.test(entry.name))
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

/** Writes FILE.br and FILE.gz beside each file that gets smaller, for servers that send those. */
function compress(): Plugin {
  let folder = "";
  return {
    name: "compress",
    apply: "build",
    configResolved(config) {
      folder = join(config.root, config.build.outDir);
    },
    closeBundle: {
      order: "post",
      sequential: true,
      handler() {
        for (const entry of readdirSync(folder, { recursive: true, withFileTypes: true })) {
          if (!entry.isFile() || COMPRESSED.test(entry.name) || PACKED.test(entry.name)) continue;
          const file = join(entry.parentPath, entry.name);
          const data = readFileSync(file);
          const params = {
            [constants.BROTLI_PARAM_QUALITY]: BROTLI_QUALITY,
            [constants.BROTLI_PARAM_SIZE_HINT]: data.length,
          };
          const packed = { br: brotliCompressSync(data, { params }), gz: gzipSync(data) };
          for (const [kind, bytes] of Object.entries(packed))
            if (bytes.length < data.length) writeFileSync(`${file}.${kind}`, bytes);
        }
      },
    },
  };
}

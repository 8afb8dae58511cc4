/** Copies the bundled model and the licence here: the repository has one copy of each. */

import { cpSync, mkdirSync } from "node:fs";

const data = new URL("../footprints_edge/model_files/data/", import.meta.url);
const folder = new URL("model/", import.meta.url);
mkdirSync(folder, { recursive: true });
for (const name of ["edge.onnx", "edge-model-card.md", "edge-credits.md"]) cpSync(new URL(name, data), new URL(name, folder));
cpSync(new URL("../../LICENSE", import.meta.url), new URL("LICENSE", import.meta.url));

/** Copies the bundled model out of the Python package: the repository has one copy of it. */

import { cpSync, mkdirSync } from "node:fs";

const data = new URL("../footprints_edge/model_files/data/", import.meta.url);
const folder = new URL("model/", import.meta.url);
mkdirSync(folder, { recursive: true });
for (const name of ["edge.onnx", "edge-model-card.md"]) cpSync(new URL(name, data), new URL(name, folder));

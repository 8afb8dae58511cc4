/** The worker that looks at pictures, so that the page stays free for the hand. */

import { drawGround, type GroundModel, type Prediction } from "footprints-edge";

import type { Asked, Replied, Reply, Request, Sent } from "../messages";
import { loadModel } from "./load-model";
import { findPath } from "./paths";

let model: GroundModel;
let last: Prediction | null = null;

self.onmessage = async ({ data: { id, request } }: MessageEvent<Asked>) => {
  const reply = await answer(request).catch(
    (error): Reply => ({ kind: "failed", message: error instanceof Error ? error.message : String(error) }),
  );
  const transfer = reply.kind === "analysed" ? [reply.result.picture, reply.result.layer] : [];
  self.postMessage({ id, reply } satisfies Replied, { transfer });
};

async function answer(request: Request): Promise<Reply> {
  switch (request.kind) {
    case "start":
      void navigator.locks?.request(self.name, () => new Promise(() => {}));
      model = await loadModel(request.engine);
      return { kind: "started", threads: model.engine.threads };
    case "analyse":
      return { kind: "analysed", result: await analyse(request) };
    case "path":
      return { kind: "path", path: last && findPath(last, request.goal) };
  }
}

async function analyse(request: Request & { kind: "analyse" }): Promise<Sent> {
  const { picture, camera, lens, cameraHeightM, goal, longestPx } = request;
  const begin = performance.now();
  const prediction = await model.predict(picture, { camera, lens, cameraHeightM });
  last = prediction;
  const path = goal && findPath(prediction, goal);
  const scale = longestPx / Math.max(picture.height, picture.width);
  const height = Math.max(1, Math.round(picture.height * scale));
  const width = Math.max(1, Math.round(picture.width * scale));
  const { rgba, labels } = drawGround(prediction, { height, width });
  const layer = await createImageBitmap(new ImageData(rgba, width, height));
  return { prediction, picture, layer, labels, path, totalMs: performance.now() - begin };
}

/** The worker that looks at pictures, so that the page stays free for the hand. */

import { cameraOf, scaledCamera } from "../core/camera";
import { flatten } from "../core/flat-ground";
import { readMaps, type Maps } from "../core/maps";
import { drawGround } from "../core/overlay";
import { findPath } from "../core/path";
import { resizeToRgb } from "../core/resize";
import { workingSize } from "../core/working-size";
import type { Analysis, Asked, Reply, Replied, Request } from "../messages";
import { Network } from "./network";

/** Larger pictures are scaled down before they are read: phones refuse larger canvases. */
const MOST_CANVAS_PX = 4096 * 4096;

let network: Network;
let lastMaps: Maps | null = null;

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
      network = await Network.load(request.engine);
      return { kind: "started", facts: network.facts, threads: network.threads };
    case "analyse":
      return { kind: "analysed", result: await analyse(request) };
    case "path":
      return { kind: "path", path: lastMaps && findPath(lastMaps, request.goal) };
  }
}

async function analyse(request: Request & { kind: "analyse" }): Promise<Analysis> {
  const { picture, focal35mm, goal } = request;
  const times = [performance.now()];
  const pixels = readPixels(picture);
  const size = network.inputSize ?? workingSize(picture);
  const input = resizeToRgb(pixels.data, pixels, size, network.facts.resize);
  times.push(performance.now());
  const output = await network.run(input, size);
  times.push(performance.now());
  const camera = scaledCamera(cameraOf(picture, focal35mm), picture, size);
  const maps = flatten(readMaps(output, size, network.facts, camera));
  lastMaps = maps;
  const path = goal && findPath(maps, goal);
  times.push(performance.now());
  const scale = request.longestPx / Math.max(picture.height, picture.width);
  const height = Math.max(1, Math.round(picture.height * scale));
  const width = Math.max(1, Math.round(picture.width * scale));
  const { rgba, labels } = drawGround(maps, { height, width });
  const layer = await createImageBitmap(new ImageData(rgba, width, height));
  times.push(performance.now());
  const [preprocess, inference, postprocess, draw] = times.slice(1).map((t, i) => t - times[i]);
  const timingsMs = { preprocess, inference, postprocess, draw };
  return { maps, picture, layer, labels, path, timingsMs };
}

let canvas: OffscreenCanvas | undefined;

/** The picture's pixels; what is transparent becomes white. */
function readPixels(picture: ImageBitmap): ImageData {
  const shrink = Math.min(1, Math.sqrt(MOST_CANVAS_PX / (picture.width * picture.height)));
  const width = Math.max(1, Math.floor(picture.width * shrink));
  const height = Math.max(1, Math.floor(picture.height * shrink));
  canvas ??= new OffscreenCanvas(width, height);
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) throw new Error("this browser gives no canvas to read the picture with");
  context.fillStyle = "white";
  context.fillRect(0, 0, width, height);
  context.drawImage(picture, 0, 0, width, height);
  return context.getImageData(0, 0, width, height);
}

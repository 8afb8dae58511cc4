/** Results in words. */

import { placeAt, THRESHOLD, type Maps } from "../core/maps";
import type { GroundPath, NoPath } from "../core/path";
import type { Analysis, Engine } from "../messages";

/** A distance for people: `2.4 m`, `12 m`. */
export function metres(distanceM: number): string {
  return `${distanceM < 9.95 ? distanceM.toFixed(1) : distanceM.toFixed(0)} m`;
}

/** What is at a place: the distance that matters most, and what it is the distance of. */
export function describePlace(maps: Maps, pixel: number): { distance: string; what: string } {
  const seen = metres(maps.visibleDepthM[pixel]);
  const ground = metres(maps.groundDepthM[pixel]);
  switch (placeAt(maps, pixel)) {
    case "visible":
      return { distance: seen, what: "ground you can see" };
    case "hidden":
      return { distance: ground, what: `hidden ground, behind something at ${seen}` };
    case "none":
      return { distance: seen, what: "not walkable" };
  }
}

const NO_PATH: Record<NoPath, string> = {
  "goal off ground": "No path: that place is not walkable.",
  "no ground": "No path: there is no walkable ground in this picture.",
  "no way": "No path: no walkable ground joins you and that place.",
};

/** A path, or why there is none. */
export function describePath(path: GroundPath | NoPath): string {
  if (typeof path === "string") return NO_PATH[path];
  const hidden = path.hidden.filter(Boolean).length;
  const words = path.lengthM === null ? "Path found" : `Path of ${metres(path.lengthM)}`;
  if (hidden === 0) return `${words}, all of it in sight.`;
  return `${words}, ${Math.max(1, Math.round((100 * hidden) / path.hidden.length))} % of it hidden.`;
}

/** How much of the picture is ground, for those who do not see it. */
export function describeGround({ maps }: Analysis): string {
  const share = (probability: Float32Array) =>
    Math.round((100 * probability.filter((each) => each > THRESHOLD).length) / probability.length);
  const visible = share(maps.visibleGroundProbability);
  const all = share(maps.groundProbability);
  if (all === 0) return "No walkable ground found.";
  return `Walkable ground on ${Math.max(visible, all)} % of the picture, ${visible} % in sight.`;
}

export const ENGINE_NAMES: Record<Engine, string> = { wasm: "WebAssembly", webgpu: "WebGPU" };

/** What ran, on what, and how long it took. */
export function describeRun(engine: Engine, threads: number, analysis: Analysis): string {
  const { preprocess, inference, postprocess, draw } = analysis.timingsMs;
  const workers = engine === "wasm" ? `, ${threads} ${threads === 1 ? "thread" : "threads"}` : "";
  const { width, height, camera } = analysis.maps;
  const lens = camera.source === "exif" ? "lens from the photo" : "lens assumed: 60° wide";
  return (
    `${ENGINE_NAMES[engine]}${workers} · network ${inference.toFixed(0)} ms of ` +
    `${(preprocess + inference + postprocess + draw).toFixed(0)} ms · ${width} × ${height} · ${lens}`
  );
}

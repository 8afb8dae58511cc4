/** Results in words. */

import { ASSUMED_FOV_DEG, type GroundPath, type Prediction } from "footprints-edge";

import type { Analysis, Engine, NoPath, Point } from "../messages";

/** A distance for people: `2.4 m`, `12 m`. */
export function metres(distanceM: number): string {
  return `${distanceM < 9.95 ? distanceM.toFixed(1) : distanceM.toFixed(0)} m`;
}

/** What is at a place: the distance that matters most, and what it is the distance of. */
export function describePlace(
  prediction: Prediction,
  { x, y }: Point,
): { distance: string; what: string } {
  const { imageSize, mapSize } = prediction;
  const place = prediction.at([x * imageSize.width - 0.5, y * imageSize.height - 0.5]);
  const seen = metres(place.visibleDepthM);
  if (place.ground === "none" || !prediction.showsGround) return { distance: seen, what: "not walkable" };
  const inMaps = [x * mapSize.width - 0.5, y * mapSize.height - 0.5] as const;
  const placeM = prediction.laidOnto?.atPixel(inMaps, prediction.intrinsics);
  const alongFloor = placeM && Number.isFinite(placeM[0]) ? `, ${metres(Math.hypot(...placeM))} along it` : "";
  const what =
    place.ground === "visible" ? "ground you can see" : `hidden ground, behind something at ${seen}`;
  return { distance: metres(place.groundDepthM), what: what + alongFloor };
}

const NO_PATH: Record<NoPath, string> = {
  "goal off ground": "No path: that place is not walkable.",
  "goal taken": "No path: something stands there.",
  "no ground": "No path: there is no walkable ground in this picture.",
  "no plane": "No path: the ground in this picture is not flat, or there is too little of it.",
  "no way": "No path: no walkable ground joins you and that place.",
};

/** A path, or why there is none. */
export function describePath(path: GroundPath | NoPath): string {
  if (typeof path === "string") return NO_PATH[path];
  const hidden = path.hidden.filter(Boolean).length;
  const words = `Path of ${metres(path.lengthM)}`;
  if (hidden === 0) return `${words}, all of it in sight.`;
  return `${words}, ${Math.max(1, Math.round((100 * hidden) / path.hidden.length))} % of it hidden.`;
}

/** How much of the picture is ground, for those who do not see it. */
export function describeGround({ prediction: { visibleGround, ground, showsGround } }: Analysis): string {
  if (!showsGround) return "No walkable ground found.";
  const share = (mask: Uint8Array) =>
    Math.round((100 * mask.reduce((sum, each) => sum + each, 0)) / mask.length);
  const [visible, all] = [share(visibleGround), share(ground)];
  return `Walkable ground on ${Math.max(visible, all)} % of the picture, ${visible} % in sight.`;
}

/** Height and pitch of the camera: as set, or as the ground shows them. */
export function describePose({ laidOnto, pose, showsGround }: Prediction): string {
  if (!showsGround) return "No ground found: nothing is drawn.";
  if (!laidOnto) return "The ground shows no plane: distances are the network's own.";
  const height = `${laidOnto.cameraHeightM.toFixed(2)} m above the ground`;
  const pitch = `looks down by ${laidOnto.pitchDeg.toFixed(0)}°`;
  return `Camera ${height}${pose.heightM === null ? " (estimated)" : ""}, ${pitch}.`;
}

export const ENGINE_NAMES: Record<Engine, string> = { wasm: "WebAssembly", webgpu: "WebGPU" };

/** What ran, on what, and how long it took. `lens` says where the focal length came from. */
export function describeRun(
  engine: Engine,
  threads: number | null,
  { prediction, totalMs }: Analysis,
  lens: "set" | "photo" | "assumed",
): string {
  const workers = threads === null ? "" : `, ${threads} ${threads === 1 ? "thread" : "threads"}`;
  const { width, height } = prediction.mapSize;
  const lenses = {
    set: "lens as set",
    photo: "lens from the photo",
    assumed: `lens assumed: ${ASSUMED_FOV_DEG}° wide`,
  };
  return (
    `${ENGINE_NAMES[engine]}${workers} · network ${prediction.timingsMs.inference.toFixed(0)} ms of ` +
    `${totalMs.toFixed(0)} ms · ${width} × ${height} · ${lenses[lens]}`
  );
}

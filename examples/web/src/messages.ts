/** What the page and its worker say to each other. */

import type { Camera, DistanceLabel, GroundMapsData, GroundPath, Lens, Prediction } from "footprints-edge";

/** What runs the network: the processor through WebAssembly, or the graphics chip. */
export type Engine = "wasm" | "webgpu";

/** A place in a picture, as fractions of its sides: (0, 0) is its top left corner, (1, 1) the other. */
export interface Point {
  x: number;
  y: number;
}

/** Why there is no path. */
export type NoPath = "goal off ground" | "goal taken" | "no ground" | "no way" | "no plane";

/** A picture to look at. */
export interface Task {
  picture: ImageBitmap;
  /** Null for what is usual: see `PredictOptions`. */
  camera: Camera | null;
  lens: Lens | null;
  cameraHeightM: number | null;
  /** The longer side of the layer that is drawn, in pixels. */
  longestPx: number;
  /** Where a path shall lead; null for nowhere. */
  goal: Point | null;
}

/** The result for one picture, as the page has it. */
export interface Analysis {
  prediction: Prediction;
  /** The picture as it was analysed, to show below the layer. */
  picture: ImageBitmap;
  /** The ground, drawn on transparency. */
  layer: ImageBitmap;
  labels: DistanceLabel[];
  /** To the goal; null where none was given. */
  path: GroundPath | NoPath | null;
  /** Milliseconds, drawing among them. */
  totalMs: number;
}

/** The result as it travels. */
export type Sent = Omit<Analysis, "prediction"> & { prediction: GroundMapsData };

/** What the page asks. */
export type Request =
  | { kind: "start"; engine: Engine }
  | ({ kind: "analyse" } & Task)
  | { kind: "path"; goal: Point };

/** What the worker answers. */
export type Reply =
  | { kind: "started"; threads: number | null }
  | { kind: "analysed"; result: Sent }
  | { kind: "path"; path: GroundPath | NoPath | null }
  | { kind: "failed"; message: string };

/** A request and its reply carry the same number. */
export interface Asked {
  id: number;
  request: Request;
}
export interface Replied {
  id: number;
  reply: Reply;
}

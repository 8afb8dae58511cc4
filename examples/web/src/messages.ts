/** What the page and its worker say to each other. */

import type { Maps, Point } from "./core/maps";
import type { ModelFacts } from "./core/model-facts";
import type { DistanceLabel } from "./core/overlay";
import type { GroundPath, NoPath } from "./core/path";

/** What runs the network: the processor through WebAssembly, or the graphics chip. */
export type Engine = "wasm" | "webgpu";

/** A picture to look at. */
export interface Task {
  picture: ImageBitmap;
  /** Its 35 mm equivalent focal length in millimetres; null if it states none. */
  focal35mm: number | null;
  /** The longer side of the layer that is drawn, in pixels. */
  longestPx: number;
  /** Where a path shall lead; null for nowhere. */
  goal: Point | null;
}

/** The result for one picture. */
export interface Analysis {
  maps: Maps;
  /** The picture as it was analysed, to show below the layer. */
  picture: ImageBitmap;
  /** The ground, drawn on transparency. */
  layer: ImageBitmap;
  labels: DistanceLabel[];
  /** To the goal; null where none was given. */
  path: GroundPath | NoPath | null;
  timingsMs: { preprocess: number; inference: number; postprocess: number; draw: number };
}

/** What the page asks. */
export type Request =
  | { kind: "start"; engine: Engine }
  | ({ kind: "analyse" } & Task)
  | { kind: "path"; goal: Point };

/** What the worker answers. */
export type Reply =
  | { kind: "started"; facts: ModelFacts; threads: number }
  | { kind: "analysed"; result: Analysis }
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

/** What the package offers in browsers and in Node alike. */

export * from "./errors.ts";
export type { Mask, Pair, Pixels, Size } from "./foundation/types.ts";
export {
  ASSUMED_FOV_DEG,
  disparityToDepth,
  intrinsicsOf,
  scaledCamera,
  type Camera,
  type Intrinsics,
} from "./geometry/camera.ts";
export type { CameraPose, PoseOptions } from "./geometry/camera-pose.ts";
export { GroundPlane } from "./geometry/ground-plane.ts";
export { readLens, type Lens } from "./inputs/lens.ts";
export type { GroundMapsData, ModelInfo, Timings } from "./maps/ground-maps.ts";
export type { ModelMetadata } from "./model-files/metadata.ts";
export { HIDDEN, OCCUPIED, OccupancyGrid, UNKNOWN, VISIBLE } from "./navigation/occupancy-grid.ts";
export { ROBOT_HEIGHT_M, STEP_HEIGHT_M } from "./navigation/obstacles.ts";
export type { GroundPath, PlanOptions } from "./navigation/path-planning.ts";
export type { RangeScan } from "./navigation/range-scan.ts";
export { Prediction, type Place } from "./prediction.ts";
export { scaleFraction, scaleGradient, TICKS_M } from "./drawing/colours.ts";
export { drawGround, type DistanceLabel } from "./drawing/overlay.ts";
export { drawTopDown } from "./drawing/top-down.ts";
export type { Engine } from "./engines/engine.ts";
export type { NetworkRun, PredictOptions } from "./model.ts";

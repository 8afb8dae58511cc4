/** The package's errors. A message says what happened, with which value, and what to do. */

/** Base class of all errors of footprints-edge. */
export class FootprintsError extends Error {
  override get name(): string {
    return this.constructor.name;
  }
}

/** An input is not a usable picture. */
export class ImageError extends FootprintsError {}

/** Camera intrinsics or a field of view are impossible. */
export class IntrinsicsError extends FootprintsError {}

/** A camera's height, pitch, roll or gravity is impossible, or contradicts another. */
export class CameraPoseError extends FootprintsError {}

/** A model cannot be fetched, is damaged, breaks the file contract, or cannot run here. */
export class ModelError extends FootprintsError {}

/** Why no plane fits, or why the one that fits is refused. */
export type NoPlane =
  | "no_ground"
  | "panorama"
  | "few_pixels"
  | "one_line"
  | "above_camera"
  | "little_ground"
  | "impossible_pose"
  | "not_flat";

/** There is no ground plane: too little ground, uneven ground, or a plane that cannot be. */
export class GroundPlaneError extends FootprintsError {
  readonly reason: NoPlane;

  constructor(message: string, reason: NoPlane) {
    super(message);
    this.reason = reason;
  }
}

/** A path cannot be planned. Base class of the more specific reasons below. */
export class PlanningError extends FootprintsError {}

/** The start or the goal is outside the picture. */
export class OutsideError extends PlanningError {}

/** The start or the goal is not on the ground, or closer to an obstacle than the margin. */
export class OffGroundError extends PlanningError {}

/** The start and the goal are on the ground, but no path over the ground connects them. */
export class NoPathError extends PlanningError {}

/** The data of a prediction: four maps, with their masks and their camera. */

import { GroundPlaneError } from "../errors.ts";
import { select } from "../foundation/median.ts";
import type { Mask, Size } from "../foundation/types.ts";
import { scaledCamera, type Intrinsics } from "../geometry/camera.ts";
import { knowsEverything, type CameraPose } from "../geometry/camera-pose.ts";
import { findGroundPlane, GroundPlane } from "../geometry/ground-plane.ts";
import type { DecodedMaps } from "./decode.ts";
import { resizeDepth, resizeMap } from "./resize.ts";

/** Weight of a clear top, and the least evidence of ground: docs/porting-metres.md of the project. */
const [CLEAR_TOP, LEAST_EVIDENCE] = [2.500, 5.209];

/** The model that made a prediction. */
export interface ModelInfo {
  name: string;
  precision: string;
  /** Package, version and provider that ran it. */
  runtime: string;
}

/** Milliseconds by stage. */
export interface Timings {
  decode: number;
  preprocess: number;
  inference: number;
  postprocess: number;
}

/** All that a prediction consists of. It survives `postMessage`: `new Prediction(data)` has it back. */
export interface GroundMapsData extends DecodedMaps {
  /** Size of the maps. */
  mapSize: Size;
  /** Size of the upright picture. */
  imageSize: Size;
  /** The camera in pixels of the maps. */
  intrinsics: Intrinsics;
  /** Probability above which a pixel counts as ground. */
  threshold: number;
  model: ModelInfo;
  timingsMs: Timings;
  /** What is known of the camera's height, pitch and roll. */
  pose: CameraPose;
  /** Whether the picture is a wide panorama, which no pinhole camera takes. */
  panorama: boolean;
  /** The plane that the ground's depth was laid onto; null for the network's own depth. */
  laidOnto: { up: GroundPlane["up"]; cameraHeightM: number; errorM: number } | null;
}

/** Walkable ground, seen and hidden, and depths. Maps and masks lie row by row. */
export class GroundMaps implements GroundMapsData {
  readonly visibleGroundProbability: Float32Array;
  readonly groundProbability: Float32Array;
  readonly visibleDepthM: Float32Array;
  readonly unmaskedGroundDepthM: Float32Array;
  readonly mapSize: Size;
  readonly imageSize: Size;
  readonly intrinsics: Intrinsics;
  readonly threshold: number;
  readonly model: ModelInfo;
  readonly timingsMs: Timings;
  readonly pose: CameraPose;
  readonly panorama: boolean;
  readonly laidOnto: GroundPlane | null;

  // Private, so that `postMessage` does not copy what follows from the rest.
  #visibleGround?: Mask;
  #ground?: Mask;
  #hiddenGround?: Mask;
  #groundDepthM?: Float32Array;
  #showsGround?: boolean;
  #plane?: GroundPlane | GroundPlaneError;

  constructor(data: GroundMapsData) {
    this.visibleGroundProbability = data.visibleGroundProbability;
    this.groundProbability = data.groundProbability;
    this.visibleDepthM = data.visibleDepthM;
    this.unmaskedGroundDepthM = data.unmaskedGroundDepthM;
    this.mapSize = data.mapSize;
    this.imageSize = data.imageSize;
    this.intrinsics = data.intrinsics;
    this.threshold = data.threshold;
    this.model = data.model;
    this.timingsMs = data.timingsMs;
    this.pose = data.pose;
    this.panorama = data.panorama;
    const plane = data.laidOnto;
    this.laidOnto = plane && new GroundPlane(plane.up, plane.cameraHeightM, plane.errorM);
  }

  /** 1 where the surface seen at this pixel is walkable (the paper's S). */
  get visibleGround(): Mask {
    return (this.#visibleGround ??= above(this.visibleGroundProbability, this.threshold));
  }

  /** 1 where the ray meets a walkable surface, seen or hidden (the paper's S*). */
  get ground(): Mask {
    return (this.#ground ??= above(this.groundProbability, this.threshold));
  }

  /** 1 where there is ground, but something stands in front of it. */
  get hiddenGround(): Mask {
    const { ground, visibleGround } = this;
    return (this.#hiddenGround ??= ground.map((each, i) => each & (1 - visibleGround[i])));
  }

  /** Metres along the optical axis to the walkable surface; NaN where there is none. */
  get groundDepthM(): Float32Array {
    const { ground } = this;
    return (this.#groundDepthM ??= this.unmaskedGroundDepthM.map((each, i) => (ground[i] ? each : NaN)));
  }

  /**
   * Whether the picture shows ground: without, there is no plane, and nothing is drawn. The masks stay
   * those of the network, thresholded.
   */
  get showsGround(): boolean {
    return (this.#showsGround ??= evidenceOfGround(this.groundProbability, this.mapSize) >= LEAST_EVIDENCE);
  }

  /**
   * The plane of the ground, with the camera's height and pitch above it. The known part of the
   * camera's pose holds; the rest is fitted.
   *
   * @throws GroundPlaneError If the picture shows no ground, or too little to fit a plane, if the ground
   *   is not flat, or if the plane cannot be the ground.
   */
  groundPlane(): GroundPlane {
    const plane = (this.#plane ??= this.laidOnto ?? this.#findPlane());
    if (plane instanceof GroundPlaneError) throw new GroundPlaneError(plane.message, plane.reason);
    return plane;
  }

  /** The plane, or why there is none. */
  #findPlane(): GroundPlane | GroundPlaneError {
    if (this.panorama && this.intrinsics.source === "assumed") {
      return new GroundPlaneError(
        "the picture is a panorama, which no pinhole camera takes; cut a view out of it, or give the camera",
        "panorama",
      );
    }
    if (!this.showsGround && !knowsEverything(this.pose)) {
      return new GroundPlaneError(
        "the picture shows no ground; use a picture that shows some, or give the camera's height, pitch and roll",
        "no_ground",
      );
    }
    try {
      return findGroundPlane(this.unmaskedGroundDepthM, this.ground, this.mapSize, this.intrinsics, this.pose);
    } catch (error) {
      if (error instanceof GroundPlaneError) return error;
      throw error;
    }
  }

  /** The data of the same maps at another size: probabilities as such, depths as inverse depth. */
  protected dataAtSize(size: Size): GroundMapsData {
    const from = this.mapSize;
    return {
      ...(this as GroundMapsData),
      visibleGroundProbability: resizeMap(this.visibleGroundProbability, from, size),
      groundProbability: resizeMap(this.groundProbability, from, size),
      visibleDepthM: resizeDepth(this.visibleDepthM, from, size),
      unmaskedGroundDepthM: resizeDepth(this.unmaskedGroundDepthM, from, size),
      mapSize: size,
      intrinsics: scaledCamera(this.intrinsics, from, size),
    };
  }
}

/** How sure the surest ground is, and how little of it reaches the upper border, as walls do. */
function evidenceOfGround(probability: Float32Array, { height, width }: Size): number {
  const surest = select(Float64Array.from(probability), Math.floor(0.98 * (probability.length - 1)));
  const p = Math.min(Math.max(surest, 0.002473), 0.997527);
  const upper = probability.subarray(0, Math.max(1, height >> 2) * width);
  const clearTop = 1 - upper.reduce((sum, each) => sum + each, 0) / upper.length;
  return Math.log(p / (1 - p)) + CLEAR_TOP * clearTop;
}

function above(probability: Float32Array, threshold: number): Mask {
  const mask = new Uint8Array(probability.length); // `from` takes ten times as long
  for (let i = 0; i < mask.length; i++) mask[i] = probability[i] > threshold ? 1 : 0;
  return mask;
}

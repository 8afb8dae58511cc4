/** A model file in onnxruntime-node: picture in, maps out. The arithmetic is the web page's. */

import { readFile } from "node:fs/promises";
import "./no-telemetry"; // before onnxruntime, which reads it when it starts
import { InferenceSession, Tensor } from "onnxruntime-node";
import { scaledCamera, type Intrinsics } from "../web/src/core/camera";
import { readMaps, THRESHOLD, type Maps } from "../web/src/core/maps";
import { readModelFacts, type ModelFacts } from "../web/src/core/model-facts";
import { resizeToRgb, type Size } from "../web/src/core/resize";
import { workingSize } from "../web/src/core/working-size";

/** A picture: four bytes a pixel, row by row; the fourth is ignored. */
export interface Picture extends Size {
  rgba: Uint8Array;
}

export interface Found extends Maps {
  /** What the network saw: uint8 [1, height, width, 3]. */
  input: Uint8Array;
  /** What it said: float32 [1, 4, height, width]. */
  output: Float32Array;
}

export class GroundFinder {
  private constructor(
    private readonly session: InferenceSession,
    readonly facts: ModelFacts,
  ) {}

  static async load(modelPath: string): Promise<GroundFinder> {
    const file = await readFile(modelPath);
    return new GroundFinder(await InferenceSession.create(file), readModelFacts(file));
  }

  /** The (height, width) at which the network sees a picture. */
  networkSize(picture: Size): Size {
    const input = this.session.inputMetadata[0];
    const [, height, width] = input.isTensor ? input.shape : [];
    const isFixed = typeof height === "number" && typeof width === "number" && height > 0;
    return isFixed ? { height, width: width as number } : workingSize(picture);
  }

  /** @param camera Of the whole picture, in its pixels. */
  async find(
    picture: Picture,
    camera: Intrinsics,
    size = this.networkSize(picture),
  ): Promise<Found> {
    const input = resizeToRgb(picture.rgba, picture, size, this.facts.resize);
    const image = new Tensor("uint8", input, [1, size.height, size.width, 3]);
    const { maps } = await this.session.run({ image }, ["maps"]);
    const output = maps.data as Float32Array;
    const scaled = scaledCamera(camera, picture, size);
    return { ...readMaps(output, size, this.facts, scaled), input, output };
  }
}

/** The three masks by name: 1 where there is such ground. */
export function masksOf(maps: Maps): Record<string, Uint8Array> {
  const isGround = (probability: number) => Number(probability > THRESHOLD);
  const visible = Uint8Array.from(maps.visibleGroundProbability, isGround);
  const ground = Uint8Array.from(maps.groundProbability, isGround);
  return {
    visible_ground: visible,
    ground,
    hidden_ground: ground.map((value, i) => value & (1 - visible[i])),
  };
}

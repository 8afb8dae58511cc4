/** A loaded model, and the stages of a prediction in order. */

import { checkedMaps, type Engine } from "./engines/engine.ts";
import { ModelError } from "./errors.ts";
import type { Size } from "./foundation/types.ts";
import { intrinsicsOf, scaledCamera, type Camera } from "./geometry/camera.ts";
import { poseOf, type PoseOptions } from "./geometry/camera-pose.ts";
import type { Lens } from "./inputs/lens.ts";
import type { DecodedImage } from "./inputs/pixels.ts";
import { resizeToRgb } from "./inputs/resize.ts";
import { workingSize } from "./inputs/working-size.ts";
import { decodeMaps } from "./maps/decode.ts";
import type { ModelMetadata } from "./model-files/metadata.ts";
import { Prediction } from "./prediction.ts";

const STRIDE = 32;

export interface PredictOptions extends PoseOptions {
  /**
   * The camera of the full upright picture. Without it, the lens that the picture's EXIF states, or else
   * a field of view of 60 degrees; `intrinsics.source` says which.
   */
  camera?: Camera | null | undefined;
  /** What `readLens` made of the file, where the picture was decoded before; files are asked themselves. */
  lens?: Lens | null | undefined;
  /** Probability above which a pixel counts as ground, 0.5 if not given. */
  threshold?: number | undefined;
  /** Whether to lay flat ground onto its plane, as `Prediction.flattened` does; true if not given. */
  flatten?: boolean | undefined;
}

/** What the network saw and said, beside the prediction made of it. */
export interface NetworkRun {
  prediction: Prediction;
  /** uint8 [1, height, width, 3]. */
  input: Uint8Array;
  /** float32 [1, 4, height, width]. */
  output: Float32Array;
}

/** A loaded model; it keeps no state between calls. `Source` is what it takes as a picture. */
export class Model<Source> {
  readonly metadata: ModelMetadata;
  readonly engine: Engine;
  readonly #decode: (source: Source) => Promise<DecodedImage>;

  constructor(
    metadata: ModelMetadata,
    engine: Engine,
    decode: (source: Source) => Promise<DecodedImage>,
  ) {
    this.metadata = metadata;
    this.engine = engine;
    this.#decode = decode;
    const size = engine.inputSize;
    if (size && (size.height % STRIDE || size.width % STRIDE)) {
      throw new ModelError(
        `the model has the fixed input size ${size.height} x ${size.width}; both sides must be multiples ` +
          `of ${STRIDE}; convert it again`,
      );
    }
  }

  /** The network's input size for a picture. */
  inputSize(imageSize: Size): Size {
    return this.engine.inputSize ?? workingSize(imageSize);
  }

  /**
   * Finds the ground in one picture.
   *
   * @param image What `load`'s package takes: in browsers a file, an `ImageBitmap`, `ImageData`, a video
   *   or a canvas; in Node decoded pixels.
   * @returns Maps at the network's input size; see `Prediction.atImageSize`.
   * @throws ImageError If the image cannot be read.
   * @throws IntrinsicsError If the camera is impossible.
   * @throws CameraPoseError If the pose is impossible.
   * @throws ModelError If the network gives no maps from 0 to 1: the file is damaged.
   * @throws RangeError If the threshold is not between 0 and 1.
   */
  async predict(image: Source, options: PredictOptions = {}): Promise<Prediction> {
    return (await this.run(image, options)).prediction;
  }

  /**
   * As `predict`, with the network's own input and output.
   *
   * @param size Overrules the usual input size; multiples of 32.
   */
  async run(image: Source, options: PredictOptions = {}, size?: Size): Promise<NetworkRun> {
    const { camera = null, lens = null, threshold = 0.5, flatten = true } = options;
    if (!(threshold >= 0 && threshold <= 1)) {
      throw new RangeError(`threshold is ${threshold}; it is a probability: give 0 to 1`);
    }
    if (size && !(isMultiple(size.height) && isMultiple(size.width))) {
      throw new RangeError(`size is ${size.height} x ${size.width}; give positive multiples of ${STRIDE}`);
    }
    const pose = poseOf(options);
    const times = [performance.now()];
    const decoded = await this.#decode(image);
    const { imageSize } = decoded;
    const stated = lens ?? decoded;
    const given = intrinsicsOf(imageSize, camera, stated.focal35mm);
    times.push(performance.now());
    const mapSize = size ?? this.inputSize(imageSize);
    const input = resizeToRgb(decoded, mapSize, this.metadata.resize);
    times.push(performance.now());
    const output = checkedMaps(await this.engine.run(input, mapSize), mapSize);
    times.push(performance.now());
    const intrinsics = scaledCamera(given, imageSize, mapSize);
    const timingsMs = { decode: 0, preprocess: 0, inference: 0, postprocess: 0 };
    const plain = new Prediction({
      ...decodeMaps(output, mapSize, this.metadata, intrinsics),
      mapSize,
      imageSize,
      intrinsics,
      threshold,
      model: {
        name: this.metadata.name,
        precision: this.metadata.precision,
        runtime: this.engine.runtime,
      },
      timingsMs,
      pose,
      panorama: stated.panorama,
      laidOnto: null,
    });
    const prediction = flatten ? plain.flattened() : plain;
    times.push(performance.now());
    const [decode, preprocess, inference, postprocess] = times.slice(1).map((t, i) => t - times[i]);
    Object.assign(timingsMs, { decode, preprocess, inference, postprocess });
    return { prediction, input, output };
  }

  /** Frees the engine's memory. */
  async release(): Promise<void> {
    await this.engine.release();
  }
}

function isMultiple(side: number): boolean {
  return side > 0 && side % STRIDE === 0;
}

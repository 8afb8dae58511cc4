/** Runs the package on a test vector whose camera and size are given. */

import { load, PlanningError } from "footprints-edge";

export interface Vector {
  /** The picture, as a data URL. */
  image: string;
  network_size_px: [number, number];
  image_intrinsics_px: { fx: number; fy: number; cx: number; cy: number };
  known_pose: { camera_height_m: number | null; pitch_deg: number | null; roll_deg: number | null };
  grid: { cell_m: number; range_m: number; robot_height_m: number };
  path: { start_px: [number, number]; goal_px: [number, number]; margin_m: number } | null;
  /** A fault to be found: blue and red swapped. */
  swapped: boolean;
}

/** Arrays by name; their bytes as a data URL, which travels far faster than numbers. */
export type Outputs = Record<string, { shape: number[]; bytes: boolean; url: string }>;

const model = await load();
const BEARINGS = Array.from({ length: 181 }, (_, i) => i - 90);

async function run({ image, known_pose: pose, grid, path, ...vector }: Vector): Promise<Outputs> {
  const picture = await createImageBitmap(await (await fetch(image)).blob());
  const context = new OffscreenCanvas(picture.width, picture.height).getContext("2d")!;
  context.drawImage(picture, 0, 0);
  const pixels = context.getImageData(0, 0, picture.width, picture.height);
  const { data } = pixels;
  if (vector.swapped) {
    for (let i = 0; i < data.length; i += 4) [data[i], data[i + 2]] = [data[i + 2], data[i]];
  }
  const [height, width] = vector.network_size_px;
  const shape = [height, width];
  const options = {
    camera: vector.image_intrinsics_px,
    flatten: false,
    cameraHeightM: pose.camera_height_m,
    pitchDeg: pose.pitch_deg,
    rollDeg: pose.roll_deg,
  };
  const { prediction, input, output } = await model.run(pixels, options, { height, width });
  const outputs: Outputs = {
    input: await packed([1, height, width, 3], input),
    maps: await packed([1, 4, height, width], output),
    visible_ground: await packed(shape, prediction.visibleGround),
    ground: await packed(shape, prediction.ground),
    hidden_ground: await packed(shape, prediction.hiddenGround),
    visible_depth_m: await packed(shape, prediction.visibleDepthM),
    ground_depth_m: await packed(shape, prediction.groundDepthM),
  };
  const flat = prediction.flattened();
  outputs.flat_ground_depth_m = await packed(shape, flat.groundDepthM);
  if (!flat.laidOnto) return outputs;
  const robotHeightM = grid.robot_height_m;
  const found = prediction.topDown(grid.cell_m, grid.range_m, { robotHeightM });
  outputs.occupancy = await packed([found.rows, found.columns], found.cells);
  outputs.nearest_obstacle_m = await packed([181], found.nearestObstacleM(BEARINGS));
  outputs.scan_m = await packed([181], prediction.scan(BEARINGS, { robotHeightM }).rangesM);
  try {
    if (!path) return outputs;
    const { placesM } = prediction.plan(path.start_px, path.goal_px, { marginM: path.margin_m, robotHeightM });
    outputs.path_m = await packed([placesM.length, 2], Float32Array.from(placesM.flat()));
  } catch (error) {
    if (!(error instanceof PlanningError)) throw error; // these maps have none
  }
  return outputs;
}

async function packed(shape: number[], data: Uint8Array | Float32Array): Promise<Outputs[string]> {
  const reader = new FileReader();
  reader.readAsDataURL(new Blob([data as BlobPart]));
  await new Promise((resolve) => (reader.onload = resolve));
  return { shape, bytes: data instanceof Uint8Array, url: reader.result as string };
}

Object.assign(globalThis, { run });

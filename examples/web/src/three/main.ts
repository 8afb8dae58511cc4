/** Someone walks in a photo: on its floor, behind its things. */

import { GroundPlaneError, type GroundPath, type Prediction } from "footprints-edge";
import * as three from "three";

import roomUrl from "../../../room.jpg?url";
import { loadModel } from "../workers/load-model";
import { cameraOf, floorOf, onFloor, thingsOf, upOf } from "./ground-scene";
import { hiddenTour, pathTo } from "./tours";
import { Walker } from "./walker";

/** Small enough for the room beneath tables and chairs, where the network sees ground. */
const WALKER_M = 0.3;
const METRES_A_SECOND = 0.6;
const LONGEST_PX = 1280;

const canvas = document.querySelector<HTMLCanvasElement>("#scene")!;
const words = document.querySelector("#words")!;
const renderer = new three.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
renderer.shadowMap.enabled = true;

/** What is on the stage. */
interface Play {
  prediction: Prediction;
  scene: three.Scene;
  camera: three.Camera;
  walker: Walker;
  path: GroundPath | null;
  begunMs: number;
  dots: three.Group;
}

let play: Play | null = null;
const model = loadModel("wasm");

async function show(photo: Blob): Promise<void> {
  const prediction = await (await model).predict(photo);
  const scene = new three.Scene();
  scene.background = await backdropOf(photo);
  const up = upOf(prediction);
  scene.add(thingsOf(prediction), floorOf(prediction), new three.HemisphereLight(0xffffff, 0x8a7a6a, 2.2));
  const lamp = new three.DirectionalLight(0xfff2dd, 2.2);
  const middle = onFloor(prediction)([4, 0]);
  lamp.position.copy(middle).addScaledVector(up, 6).add(new three.Vector3(-2, 0, 1));
  lamp.target.position.copy(middle);
  lamp.castShadow = true;
  lamp.shadow.mapSize.set(2048, 2048);
  Object.assign(lamp.shadow.camera, { left: -5, right: 5, top: 5, bottom: -5, near: 0.5, far: 14 });
  const [walker, dots] = [new Walker(WALKER_M), new three.Group()];
  scene.add(lamp, lamp.target, walker.object, dots);
  play = { prediction, scene, camera: cameraOf(prediction), walker, dots, path: null, begunMs: 0 };
  walk(hiddenTour(prediction, WALKER_M));
}

/** The photo as a texture; the stage takes its size. */
async function backdropOf(photo: Blob): Promise<three.Texture> {
  const picture = await createImageBitmap(photo);
  const scale = LONGEST_PX / Math.max(picture.width, picture.height);
  const paper = document.createElement("canvas");
  paper.width = Math.round(picture.width * scale);
  paper.height = Math.round(picture.height * scale);
  paper.getContext("2d")!.drawImage(picture, 0, 0, paper.width, paper.height);
  renderer.setSize(paper.width, paper.height, false);
  const backdrop = new three.CanvasTexture(paper);
  backdrop.colorSpace = three.SRGBColorSpace;
  return backdrop;
}

function walk(path: GroundPath | null): void {
  if (!play) return;
  words.textContent = path
    ? `${path.lengthM.toFixed(1)} m to walk. Click on the floor for another way.`
    : "There is no way to there. Click on another piece of floor.";
  if (!path) return;
  Object.assign(play, { path, begunMs: performance.now() });
  const place = onFloor(play.prediction);
  const dot = new three.CircleGeometry(0.03, 20);
  const facing = new three.Quaternion().setFromUnitVectors(new three.Vector3(0, 0, 1), upOf(play.prediction));
  play.dots.clear();
  path.placesM.forEach((at, i) => {
    if (i % 4 !== 0) return;
    // Hidden ones shine through what hides them.
    const material = new three.MeshBasicMaterial({
      color: 0xffffff,
      transparent: true,
      opacity: path.hidden[i] ? 0.35 : 0.85,
      depthTest: !path.hidden[i],
    });
    const mesh = new three.Mesh(dot, material);
    mesh.quaternion.copy(facing);
    mesh.position.copy(place(at)).addScaledVector(upOf(play!.prediction), 0.005);
    play!.dots.add(mesh);
  });
}

/** Draws the walker after so many metres of its path. */
function draw(walkedM: number): void {
  if (!play) return;
  const { prediction, path, walker, scene, camera } = play;
  if (path) {
    const place = onFloor(prediction);
    const points = path.placesM.map(place);
    let left = Math.min(walkedM, path.lengthM);
    let i = 1;
    for (; i < points.length - 1; i++) {
      const stepM = points[i].distanceTo(points[i - 1]);
      if (left <= stepM) break;
      left -= stepM;
    }
    // It looks a little ahead, so that corners are turned and not jumped.
    const later = points[Math.min(points.length - 1, i + 6)];
    const from = points[Math.max(0, i - 6)];
    const ahead = later.clone().sub(from);
    const stepM = points[i].distanceTo(points[i - 1]) || 1;
    const at = points[i - 1].clone().lerp(points[i], Math.min(1, left / stepM));
    walker.stand(at, ahead, upOf(prediction), walkedM);
  }
  renderer.render(scene, camera);
}

renderer.setAnimationLoop((nowMs) => {
  if (!play?.path || held !== null) return draw(held ?? 0);
  // There and back again, with a rest at both ends.
  const { lengthM } = play.path;
  const cycle = ((nowMs - play.begunMs) / 1000) * METRES_A_SECOND;
  const way = cycle % (2 * lengthM + 2);
  draw(Math.min(lengthM, way <= lengthM + 1 ? way : Math.max(0, 2 * lengthM + 2 - way)));
});

/** For programs around the page, and for its pictures: holds the walker after a share of its path. */
let held: number | null = null;
Object.assign(globalThis, {
  hold(share: number): { ready: boolean } {
    held = play?.path ? share * play.path.lengthM : null;
    if (held !== null) draw(held);
    return { ready: held !== null };
  },
});

canvas.addEventListener("click", (event) => {
  if (!play) return;
  const { prediction, path } = play;
  const box = canvas.getBoundingClientRect();
  const { width, height } = prediction.mapSize;
  const x = ((event.clientX - box.left) / box.width) * width - 0.5;
  const y = ((event.clientY - box.top) / box.height) * height - 0.5;
  const goal = prediction.groundPlane().atPixel([x, y], prediction.intrinsics);
  const start = path?.placesM.at(-1) ?? hiddenTour(prediction, WALKER_M)?.placesM[0];
  walk(start && goal.every(Number.isFinite) ? pathTo(prediction, start, goal, WALKER_M) : null);
});

document.querySelector<HTMLInputElement>("#file")!.addEventListener("change", (event) => {
  const file = (event.target as HTMLInputElement).files?.[0];
  if (file) void show(file).catch(complain);
});

function complain(error: unknown): void {
  words.textContent =
    error instanceof GroundPlaneError
      ? "This photo shows no flat floor to walk on. Choose another."
      : error instanceof Error
        ? error.message
        : String(error);
}

void fetch(roomUrl)
  .then((response) => response.blob())
  .then(show)
  .catch(complain);

/** The page: pictures in, ground, distances and paths out. */

import { scaleFraction, scaleGradient, TICKS_M, type GroundPath } from "footprints-edge";

import roomUrl from "../../room.jpg?url";
import type { Analysis, Engine, NoPath, Point } from "./messages";
import { Analyst } from "./page/analyst";
import { Camera, CameraError } from "./page/camera";
import { readPhoto, type Photo } from "./page/photo";
import { PictureView, type Pointing } from "./page/picture-view";
import {
  describeGround,
  describePath,
  describePlace,
  describePose,
  describeRun,
  ENGINE_NAMES,
} from "./page/words";

/** The longer side of what is drawn, in pixels: a film has less time for each picture. */
const PHOTO_PX = 1280;
const FILM_PX = 800;

/** A finger that moves less than this between touching and lifting has tapped. */
const TAP_PX = 10;

const byId = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;

const pictureElement = byId("picture");
const view = new PictureView(pictureElement);
const cameraButton = byId<HTMLButtonElement>("camera");
const fileInput = byId<HTMLInputElement>("file");
const lensInput = byId<HTMLInputElement>("lens");
const heightInput = byId<HTMLInputElement>("height");
const engineInputs = [...document.querySelectorAll<HTMLInputElement>("input[name=engine]")];

let analyst: Analyst | null = null;
let camera: Camera | null = null;
let photo: Photo | null = null;
let analysis: Analysis | null = null;
let goal: Point | null = null;
let pointer: Point | null = null;
let pointing: Pointing = "mouse";

/** Jobs of the worker, one after the other: a picture that it works on cannot be handed over. */
let busy: Promise<unknown> = Promise.resolve();

function inTurn(job: () => Promise<void>): Promise<void> {
  const done = busy.then(job).catch(complain);
  busy = done;
  return done;
}

// --- results

async function analysePhoto(): Promise<void> {
  if (!photo) return;
  const worker = await ready(); // where none starts, the photo is still there
  const given = photo;
  photo = null; // handed over: where that fails, it is lost
  const result = await worker.analyse(taskOf(given, PHOTO_PX));
  photo = { ...given, picture: result.picture };
  show(result);
  showSpeed(`${result.totalMs.toFixed(0)} ms`);
  say(describeGround(result));
}

function taskOf({ picture, lens }: Photo, longestPx: number) {
  const fovDeg = valueOf(lensInput);
  const camera = fovDeg === null ? null : { fovDeg };
  return { picture, camera, lens, cameraHeightM: valueOf(heightInput), longestPx, goal };
}

/** What someone typed; null where it is nothing, or no number within the field's bounds. */
function valueOf(input: HTMLInputElement): number | null {
  return input.value !== "" && input.validity.valid ? input.valueAsNumber : null;
}

function show(result: Analysis): void {
  analysis = result;
  view.showAnalysis(result);
  showPath(result.path);
  showReading();
  byId("pose").textContent = describePose(result.prediction);
  const lens = valueOf(lensInput) !== null ? "set" : photo?.lens?.focal35mm ? "photo" : "assumed";
  if (analyst) byId("run").textContent = describeRun(analyst.engine, analyst.threads, result, lens);
  // For programs around the page, and for its tests.
  if (performance.getEntriesByName("first result").length === 0) performance.mark("first result");
  document.dispatchEvent(new CustomEvent("footprints-result", { detail: result }));
}

function showPath(path: GroundPath | NoPath | null): void {
  view.showPath(goal, path && typeof path !== "string" ? path : null);
  byId("path").textContent = path ? describePath(path) : "";
}

/** The distance at the pointer, or where the path leads. */
function showReading(): void {
  const place = pointer ?? goal;
  if (!analysis || !place) {
    byId("distance").textContent = "";
    byId("what").textContent = analysis ? "Point at the picture for a distance, tap for a path." : "";
    view.showPointer(null);
    return;
  }
  const { distance, what } = describePlace(analysis.prediction, place);
  byId("distance").textContent = distance;
  byId("what").textContent = what;
  view.showPointer(pointer && { at: pointer, text: distance, by: pointing });
}

async function setGoal(place: Point | null): Promise<void> {
  goal = place;
  if (!goal || !analyst || analyst.ended || !analysis) {
    showPath(null);
    showReading();
    return;
  }
  const path = await analyst.findPath(goal);
  if (goal !== place) return;
  showPath(path);
  showReading();
  if (path) say(describePath(path));
}

// --- pictures

async function showPhoto(file: Blob, name: string): Promise<void> {
  notice("");
  let next: Photo;
  try {
    next = await readPhoto(file, name);
  } catch (error) {
    complain(error);
    return;
  }
  stopCamera();
  forgetResult();
  view.showPhoto(next.picture, PHOTO_PX);
  await inTurn(async () => {
    photo = next;
    await analysePhoto();
  });
}

function forgetResult(): void {
  analysis = goal = pointer = null;
  view.clear();
  byId("path").textContent = "";
  showReading();
}

async function startCamera(): Promise<void> {
  notice("");
  cameraButton.disabled = true;
  try {
    camera = await Camera.open();
  } catch (error) {
    if (!(error instanceof CameraError)) throw error;
    notice(error.message);
    return;
  } finally {
    cameraButton.disabled = false;
  }
  byId("camera-label").textContent = "Stop";
  cameraButton.classList.add("running");
  say("The camera is on.");
  forgetResult();
  await film(camera);
}

/** Looks at one frame after the other until the camera stops. */
async function film(running: Camera): Promise<void> {
  const finished: number[] = [];
  while (camera === running && !running.ended) {
    const picture = await running.nextFrame();
    await inTurn(async () => {
      if (camera !== running) return;
      const result = await analyseFrame(picture);
      photo = { picture: result.picture, lens: null }; // the last frame stays when it stops
      show(result);
      finished.push(performance.now());
      if (finished.length > 12) finished.shift();
      showSpeed(`${framesASecond(finished)} frames/s`);
    });
  }
  if (camera === running) {
    stopCamera();
    notice("The camera has stopped. Start it again, or choose a photo.");
  }
}

/** The next frame would fail as this one did, with a new worker each time: the camera stops. */
async function analyseFrame(picture: ImageBitmap): Promise<Analysis> {
  try {
    return await (await ready()).analyse(taskOf({ picture, lens: null }, FILM_PX));
  } catch (error) {
    stopCamera();
    throw error;
  }
}

function framesASecond(finished: number[]): string {
  const rate = (1000 * (finished.length - 1)) / (finished[finished.length - 1] - finished[0]);
  return finished.length < 2 ? "–" : rate.toFixed(rate < 9.95 ? 1 : 0);
}

/** Stops the camera. */
function stopCamera(): void {
  if (!camera) return;
  camera.stop();
  camera = null;
  byId("camera-label").textContent = "Camera";
  cameraButton.classList.remove("running");
  say("The camera is off.");
}

// --- engines

/** The worker; a new one where none could be started, or where it has ended. */
async function ready(): Promise<Analyst> {
  if (!analyst || analyst.ended) analyst = await Analyst.start(analyst?.engine ?? "wasm");
  return analyst;
}

async function useEngine(engine: Engine): Promise<void> {
  await inTurn(async () => {
    say(`Loading ${ENGINE_NAMES[engine]} and the model.`);
    pictureElement.classList.add("loading");
    try {
      const next = await Analyst.start(engine);
      analyst?.stop();
      analyst = next;
      notice("");
    } catch (error) {
      const reason = error instanceof Error ? error.message : String(error);
      notice(`${ENGINE_NAMES[engine]} does not start on this device: ${reason}`);
    } finally {
      pictureElement.classList.remove("loading");
      for (const input of engineInputs) input.checked = input.value === analyst?.engine;
    }
    await analysePhoto();
  });
}

async function offerWebGpu(): Promise<void> {
  const input = engineInputs.find(({ value }) => value === "webgpu")!;
  const adapter = await navigator.gpu?.requestAdapter().catch(() => null);
  input.disabled = !adapter;
  byId("engine-note").textContent = adapter
    ? ""
    : navigator.gpu
      ? "WebGPU finds no graphics chip that it can use here."
      : "This browser has no WebGPU.";
}

// --- words

function say(words: string): void {
  byId("status").textContent = words;
}

function notice(words: string): void {
  const element = byId("notice");
  element.textContent = words;
  element.hidden = words === "";
}

function complain(error: unknown): void {
  notice(error instanceof Error ? error.message : String(error));
}

function showSpeed(words: string): void {
  const chip = byId("speed");
  chip.textContent = words;
  chip.hidden = false;
}

// --- hand and keys

let touchedAt: { x: number; y: number } | null = null;

pictureElement.addEventListener("pointerdown", (event) => {
  touchedAt = { x: event.clientX, y: event.clientY };
  pictureElement.setPointerCapture(event.pointerId);
  point(event);
});

pictureElement.addEventListener("pointermove", (event) => {
  if (event.pointerType === "mouse" || touchedAt) point(event);
});

pictureElement.addEventListener("pointerup", (event) => {
  const moved =
    touchedAt && Math.hypot(event.clientX - touchedAt.x, event.clientY - touchedAt.y) > TAP_PX;
  touchedAt = null;
  if (event.pointerType !== "mouse") pointer = null;
  if (!moved) void setGoal(view.placeOf(event)).catch(complain);
  else showReading();
});

for (const kind of ["pointercancel", "pointerleave"]) {
  pictureElement.addEventListener(kind, () => {
    touchedAt = pointer = null;
    showReading();
  });
}

function point(event: PointerEvent): void {
  pointer = view.placeOf(event);
  pointing = event.pointerType === "touch" ? "touch" : "mouse";
  showReading();
}

const STEPS: Record<string, [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

pictureElement.addEventListener("keydown", (event) => {
  const step = STEPS[event.key];
  if (step) {
    const from = pointer ?? goal ?? { x: 0.5, y: 0.75 };
    const reach = event.shiftKey ? 0.1 : 0.02;
    const moved = (value: number, by: number) => Math.min(1, Math.max(0, value + by * reach));
    pointer = { x: moved(from.x, step[0]), y: moved(from.y, step[1]) };
    pointing = "keyboard";
    showReading();
    if (analysis) say(`${byId("distance").textContent}, ${byId("what").textContent}`);
  } else if (event.key === "Enter" || event.key === " ") {
    void setGoal(pointer ?? { x: 0.5, y: 0.75 }).catch(complain);
  } else if (event.key === "Escape") {
    pointer = null;
    void setGoal(null);
    say("Path removed.");
  } else return;
  event.preventDefault();
});

cameraButton.addEventListener("click", () => {
  if (camera) stopCamera();
  else void startCamera().catch(complain);
});

fileInput.addEventListener("change", () => {
  const file = fileInput.files?.[0];
  if (file) void showPhoto(file, file.name);
  fileInput.value = ""; // the same file may be chosen again
});

for (const input of engineInputs) {
  input.addEventListener("change", () => void useEngine(input.value as Engine));
}

// What is known of a camera holds for the next visit.
for (const input of [lensInput, heightInput]) {
  try {
    input.value = localStorage.getItem(input.id) ?? "";
  } catch {
    // Some private windows keep nothing.
  }
  input.addEventListener("change", () => {
    try {
      localStorage.setItem(input.id, input.validity.valid ? input.value : "");
    } catch {
      // As above.
    }
    if (!camera) void inTurn(analysePhoto);
  });
}

// --- start

function drawLegend(): void {
  byId("scale-bar").style.background = scaleGradient();
  const ticks = TICKS_M.map((tick) => {
    const element = document.createElement("span");
    element.textContent = tick === TICKS_M.at(-1) ? `${tick}+ m` : String(tick);
    element.style.left = `${100 * scaleFraction(tick)}%`;
    return element;
  });
  byId("scale-ticks").replaceChildren(...ticks);
}

async function start(): Promise<void> {
  drawLegend();
  void offerWebGpu();
  const example = fetch(roomUrl).then((response) => response.blob());
  const loaded = useEngine("wasm");
  const room = await example.catch(() => null);
  if (room) await showPhoto(room, "The example picture");
  await loaded;
  cameraButton.disabled = fileInput.disabled = false;
  if (import.meta.env.PROD) {
    // Some private windows refuse it: there is no copy for later then, and all else works.
    await navigator.serviceWorker?.register("service-worker.js").catch(() => undefined);
  }
}

void start().catch(complain);

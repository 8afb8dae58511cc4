/** The picture with its layer, and what is drawn on top: numbers, path, pointer. */

import { TICKS_M, type GroundPath, type Size } from "footprints-edge";

import type { Analysis, Point } from "../messages";

const SVG = "http://www.w3.org/2000/svg";

/** A finger covers what it points at: its number stands this far above it. */
const LIFT_PX = { touch: 58, pen: 26, mouse: 26, keyboard: 26 };

/** The lines' numbers keep so far from what the user points at. */
const CLEAR_PX = 60;

export type Pointing = keyof typeof LIFT_PX;

export class PictureView {
  private readonly photo: HTMLCanvasElement;
  private readonly layer: HTMLCanvasElement;
  private readonly marks: SVGSVGElement;
  private analysis: Analysis | null = null;
  private path: GroundPath | null = null;
  private goal: Point | null = null;
  private pointer: { at: Point; text: string; by: Pointing } | null = null;

  constructor(private readonly element: HTMLElement) {
    this.photo = element.querySelector("#photo")!;
    this.layer = element.querySelector("#layer")!;
    this.marks = element.querySelector("#marks")!;
    new ResizeObserver(() => this.drawMarks()).observe(element);
  }

  /** Shows a picture that has no result yet. */
  showPhoto(picture: ImageBitmap, longestPx: number): void {
    const scale = longestPx / Math.max(picture.width, picture.height);
    const width = Math.max(1, Math.round(picture.width * scale));
    const height = Math.max(1, Math.round(picture.height * scale));
    if (this.photo.width !== width || this.photo.height !== height) {
      Object.assign(this.photo, { width, height });
      this.element.style.setProperty("--aspect", String(width / height));
    }
    const context = this.photo.getContext("2d")!;
    context.fillStyle = "white";
    context.fillRect(0, 0, width, height);
    context.imageSmoothingQuality = "high";
    context.drawImage(picture, 0, 0, width, height);
  }

  /** Shows a result, in place of what was there. */
  showAnalysis(analysis: Analysis): void {
    const { width, height } = analysis.layer;
    this.showPhoto(analysis.picture, Math.max(width, height));
    Object.assign(this.layer, { width, height });
    this.layer.getContext("bitmaprenderer")!.transferFromImageBitmap(analysis.layer);
    this.layer.classList.add("shown");
    this.analysis = analysis;
    this.drawMarks();
  }

  /** Removes the result: another picture is coming. */
  clear(): void {
    this.layer.classList.remove("shown");
    this.analysis = this.path = this.goal = this.pointer = null;
    this.drawMarks();
  }

  showPath(goal: Point | null, path: GroundPath | null): void {
    this.goal = goal;
    this.path = path;
    this.drawMarks();
  }

  /** Shows the pointer and its distance; null takes it away. */
  showPointer(pointer: { at: Point; text: string; by: Pointing } | null): void {
    this.pointer = pointer;
    this.drawMarks();
  }

  /** The place in the picture that a mouse or finger is at. */
  placeOf(event: MouseEvent): Point {
    const box = this.element.getBoundingClientRect();
    const within = (value: number) => Math.min(1, Math.max(0, value));
    return {
      x: within((event.clientX - box.left) / box.width),
      y: within((event.clientY - box.top) / box.height),
    };
  }

  private drawMarks(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    this.marks.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const at = ({ x, y }: Point) => ({ x: x * width, y: y * height });
    const drawn: SVGElement[] = [];
    const inTheWay = [this.goal, this.pointer?.at].flatMap((place) => (place ? [at(place)] : []));
    for (const label of this.analysis?.labels ?? []) {
      const { x, y } = at(label);
      if (inTheWay.some((place) => Math.hypot(place.x - x, place.y - y) < CLEAR_PX)) continue;
      drawn.push(pill({ x, y }, tickWords(label.metres), "tick", width));
    }
    const size = this.analysis?.prediction.imageSize;
    if (this.path && size) drawn.push(...pathMarks(this.path, size, at));
    if (this.goal) {
      const { x, y } = at(this.goal);
      drawn.push(shape("circle", { class: this.path ? "goal" : "goal missed", cx: x, cy: y, r: 7 }));
    }
    if (this.pointer) {
      const { x, y } = at(this.pointer.at);
      const lift = LIFT_PX[this.pointer.by];
      drawn.push(shape("circle", { class: "aim-rim", cx: x, cy: y, r: 9 }));
      drawn.push(shape("circle", { class: "aim", cx: x, cy: y, r: 9 }));
      const above = y - lift > 16 ? y - lift : y + lift;
      drawn.push(pill({ x, y: above }, this.pointer.text, "reading", width));
    }
    this.marks.replaceChildren(...drawn);
  }
}

function tickWords(metres: number): string {
  return metres === TICKS_M.at(-1) ? `${metres}+ m` : `${metres} m`;
}

function pathMarks(path: GroundPath, size: Size, at: (point: Point) => Point): SVGElement[] {
  const line = path.pixels.map(([x, y]) => at({ x: (x + 0.5) / size.width, y: (y + 0.5) / size.height }));
  const draw = (points: Point[], kind: string) =>
    shape("polyline", {
      class: kind,
      points: points.map(({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" "),
    });
  const marks = [draw(line, "path-rim"), draw(line, "path-line")];
  for (const [from, to] of runsOf(path.hidden)) {
    marks.push(draw(line.slice(Math.max(0, from - 1), to + 1), "path-hidden"));
  }
  const { x, y } = line[0];
  marks.push(shape("circle", { class: "stand", cx: x, cy: y - 4, r: 6 }));
  return marks;
}

/** First and last index of each run of `true`. */
function runsOf(flags: boolean[]): [number, number][] {
  const runs: [number, number][] = [];
  flags.forEach((flag, i) => {
    if (!flag) return;
    if (i > 0 && flags[i - 1]) runs[runs.length - 1][1] = i;
    else runs.push([i, i]);
  });
  return runs;
}

/** Text on a rounded ground, kept inside the picture from side to side. */
function pill({ x, y }: Point, words: string, kind: string, pictureWidth: number): SVGElement {
  const [letter, height] = kind === "reading" ? [8.6, 28] : [6.2, 19];
  const width = words.length * letter + height * 0.7;
  const middle = Math.min(pictureWidth - width / 2 - 4, Math.max(width / 2 + 4, x));
  const group = shape("g", { class: kind });
  const text = shape("text", { x: middle, y });
  text.textContent = words;
  group.append(
    shape("rect", { x: middle - width / 2, y: y - height / 2, width, height, rx: height / 2 }),
    text,
  );
  return group;
}

function shape(name: string, attributes: Record<string, string | number>): SVGElement {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  return element;
}

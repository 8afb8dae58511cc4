/**
 * The picture for people, as a transparent layer in the style of the Python runtime's overlay:
 * visible ground is a solid tint of its distance, hidden ground a hatching, both outlined; thin
 * lines mark round distances.
 */

import type { Size } from "../foundation/types.ts";
import type { GroundMaps } from "../maps/ground-maps.ts";
import { COLOUR_SCALE, scalePosition, TICKS_M } from "./colours.ts";

/** Where a line of equal distance carries its number: x and y as fractions of the picture. */
export interface DistanceLabel {
  metres: number;
  x: number;
  y: number;
}

/** Outlines round off what is finer, in pixels of the maps. */
const OUTLINE_BLUR_PX = 1.5;

/** Lines of equal distance follow the ground's broad shape, not ripples finer than this. */
const RIPPLE_PX = 12;

/** A line shorter than this share of the picture's width carries no number. */
const LABELLED_SHARE = 0.12;

/** What the layer is drawn from: one value for each pixel of the maps. */
interface Fields {
  /** How far inside visible ground, in pixels of the maps; negative outside. */
  visible: Float32Array;
  /** The same for hidden ground. */
  hidden: Float32Array;
  /** The ground's place on the colour scale. */
  scale: Float32Array;
  /** Inverse depth of the ground's broad shape, and the length of its gradient. */
  nearness: Float32Array;
  steepness: Float32Array;
}

/**
 * Draws the ground; nothing if the picture shows none.
 *
 * @param size Size of the layer; its shape is that of the picture.
 * @returns Four bytes a pixel (red, green, blue, opacity), and the numbers to write on the lines.
 */
export function drawGround(
  maps: GroundMaps,
  size: Size,
): { rgba: Uint8ClampedArray<ArrayBuffer>; labels: DistanceLabel[] } {
  if (!maps.showsGround) return { rgba: new Uint8ClampedArray(size.height * size.width * 4), labels: [] };
  const fields = fieldsOf(maps);
  return { rgba: paint(maps, fields, size), labels: labelsOf(maps, fields.nearness) };
}

function fieldsOf(maps: GroundMaps): Fields {
  const { mapSize } = maps;
  const scale = maps.unmaskedGroundDepthM.map(scalePosition);
  let nearness: Float32Array = maps.unmaskedGroundDepthM.map((depthM) => 1 / depthM);
  // Ground that lies on its plane has no ripples, and its lines are where its metres are.
  if (!maps.laidOnto) nearness = broad(nearness, mapSize);
  return {
    visible: signedDistance(Float32Array.from(maps.visibleGround), mapSize),
    hidden: signedDistance(Float32Array.from(maps.hiddenGround), mapSize),
    scale,
    nearness,
    steepness: steepness(nearness, mapSize),
  };
}

/** The loop over every pixel that people see: plain arithmetic, for the sake of films on phones. */
function paint(maps: GroundMaps, fields: Fields, size: Size): Uint8ClampedArray<ArrayBuffer> {
  const { height, width } = size;
  const penPx = Math.max(1, Math.max(height, width) / 700);
  const perMapPx = width / maps.mapSize.width;
  const periodPx = 10 * penPx;
  const stripePx = 4.4 * penPx;
  const ticks = Float64Array.from(TICKS_M, (tick) => 1 / tick);
  const rgba = new Uint8ClampedArray(height * width * 4);
  const columns = between(width, maps.mapSize.width);
  const rows = between(height, maps.mapSize.height);
  const row = {
    visible: new Float32Array(maps.mapSize.width),
    hidden: new Float32Array(maps.mapSize.width),
    scale: new Float32Array(maps.mapSize.width),
    nearness: new Float32Array(maps.mapSize.width),
    steepness: new Float32Array(maps.mapSize.width),
  };

  // The layer's colour so far, weighted with its opacity; `over` puts a colour on top.
  let red = 0;
  let green = 0;
  let blue = 0;
  let opacity = 0;
  const over = (r: number, g: number, b: number, share: number) => {
    const rest = 1 - share;
    red = red * rest + r * share;
    green = green * rest + g * share;
    blue = blue * rest + b * share;
    opacity = opacity * rest + share;
  };

  for (let y = 0; y < height; y++) {
    const above = rows.first[y] * maps.mapSize.width;
    const below = rows.second[y] * maps.mapSize.width;
    const down = rows.part[y];
    const blend = (field: Float32Array, into: Float32Array) => {
      for (let x = 0; x < maps.mapSize.width; x++) {
        into[x] = field[above + x] + down * (field[below + x] - field[above + x]);
      }
    };
    blend(fields.visible, row.visible);
    blend(fields.hidden, row.hidden);
    blend(fields.scale, row.scale);
    blend(fields.nearness, row.nearness);
    blend(fields.steepness, row.steepness);
    for (let x = 0; x < width; x++) {
      const left = columns.first[x];
      const right = columns.second[x];
      const along = columns.part[x];
      const at = (values: Float32Array) => values[left] + along * (values[right] - values[left]);
      const visiblePx = at(row.visible) * perMapPx;
      const hiddenPx = at(row.hidden) * perMapPx;
      if (visiblePx < -2.2 * penPx && hiddenPx < -2.2 * penPx) continue;
      red = green = blue = opacity = 0;
      const visible = coverage(visiblePx);
      const hidden = coverage(hiddenPx);
      if (visible > 0 || hidden > 0) {
        const tint = 3 * Math.round(at(row.scale));
        const r = COLOUR_SCALE[tint];
        const g = COLOUR_SCALE[tint + 1];
        const b = COLOUR_SCALE[tint + 2];
        if (visible > 0) over(r, g, b, 0.6 * visible);
        if (hidden > 0) {
          const position = (((x + y) * Math.SQRT1_2) % periodPx) - periodPx / 2;
          const stripe = coverage(stripePx / 2 - Math.abs(position));
          const rim = coverage(0.6 * penPx - Math.abs(position + stripePx / 2));
          over(14, 16, 22, 0.45 * hidden * (1 - stripe));
          over(r, g, b, hidden * (0.12 + 0.83 * stripe));
          over(255, 255, 255, 0.8 * hidden * rim);
        }
        const nearness = at(row.nearness);
        let off = Infinity;
        for (let i = 0; i < ticks.length; i++) off = Math.min(off, Math.abs(nearness - ticks[i]));
        const awayPx = (off / (at(row.steepness) + 1e-9)) * perMapPx;
        const isoline = coverage(0.5 * penPx - awayPx);
        over(255, 255, 255, 0.5 * isoline * Math.max(visible, hidden));
      }
      const nearerPx = Math.min(Math.abs(hiddenPx), Math.abs(visiblePx));
      over(14, 16, 22, 0.4 * coverage(1.6 * penPx - nearerPx));
      over(255, 255, 255, coverage(0.7 * penPx - nearerPx));
      if (opacity > 0) {
        const write = (y * width + x) * 4;
        rgba[write] = red / opacity;
        rgba[write + 1] = green / opacity;
        rgba[write + 2] = blue / opacity;
        rgba[write + 3] = 255 * opacity;
      }
    }
  }
  return rgba;
}

/** How much of a pixel is inside an edge that is so far away: antialiasing. */
function coverage(insidePx: number): number {
  return insidePx >= 0.5 ? 1 : insidePx <= -0.5 ? 0 : insidePx + 0.5;
}

/** For each of `to` pixels, the two of `from` that it lies between, and how far along. */
function between(to: number, from: number) {
  const first = new Int32Array(to);
  const second = new Int32Array(to);
  const part = new Float32Array(to);
  for (let i = 0; i < to; i++) {
    const at = Math.min(from - 1, Math.max(0, ((i + 0.5) * from) / to - 0.5));
    first[i] = Math.floor(at);
    second[i] = Math.min(from - 1, first[i] + 1);
    part[i] = at - first[i];
  }
  return { first, second, part };
}

/**
 * How far inside (positive) or outside a mask's smoothed outline a pixel is, near to it. A straight
 * edge blurred by a Gaussian is that Gaussian's distribution function of the distance; its inverse,
 * for which the logistic function stands here, gives the distance back.
 */
function signedDistance(mask: Float32Array, size: Size): Float32Array {
  const reach = Math.ceil(3 * OUTLINE_BLUR_PX);
  const weights = Float64Array.from({ length: 2 * reach + 1 }, (_, i) =>
    Math.exp(-((i - reach) ** 2) / (2 * OUTLINE_BLUR_PX ** 2)),
  );
  const total = weights.reduce((sum, weight) => sum + weight);
  const levels = alongRowsAndColumns(mask, size, reach, (line, into) => {
    for (let i = 0; i < into.length; i++) {
      let sum = 0;
      for (let k = 0; k < weights.length; k++) sum += weights[k] * line[i + k];
      into[i] = sum / total;
    }
  });
  for (let i = 0; i < levels.length; i++) {
    const inside = Math.min(1 - 1e-3, Math.max(1e-3, levels[i]));
    levels[i] = (OUTLINE_BLUR_PX * Math.log(inside / (1 - inside))) / 1.702;
  }
  return levels;
}

/** Inverse depth without its ripples: its moving mean, taken twice, which keeps planes planes. */
function broad(nearness: Float32Array, size: Size): Float32Array {
  const reach = Math.min(RIPPLE_PX, size.height - 1, size.width - 1);
  const movingMean = (line: Float32Array, into: Float32Array) => {
    let sum = 0;
    for (let i = 0; i < 2 * reach; i++) sum += line[i];
    for (let i = 0; i < into.length; i++) {
      sum += line[i + 2 * reach];
      into[i] = sum / (2 * reach + 1);
      sum -= line[i];
    }
  };
  const once = alongRowsAndColumns(nearness, size, reach, movingMean);
  const twice = alongRowsAndColumns(once, size, reach, movingMean);
  return twice.map((each) => Math.max(each, 1e-3));
}

/**
 * Changes every row, then every column. `change` gets a line that goes on for `reach` values beyond
 * both ends, as it slopes there, and fills in the line without them.
 */
function alongRowsAndColumns(
  values: Float32Array,
  { height, width }: Size,
  reach: number,
  change: (line: Float32Array, into: Float32Array) => void,
): Float32Array {
  const result = values.slice();
  const alongLines = (lines: number, length: number, perLine: number, perStep: number) => {
    const line = new Float32Array(length + 2 * reach);
    const into = new Float32Array(length);
    const last = reach + length - 1;
    for (let i = 0; i < lines; i++) {
      const start = i * perLine;
      for (let k = 0; k < length; k++) line[reach + k] = result[start + k * perStep];
      for (let k = 1; k <= reach; k++) {
        line[reach - k] = 2 * line[reach] - line[reach + k];
        line[last + k] = 2 * line[last] - line[last - k];
      }
      change(line, into);
      for (let k = 0; k < length; k++) result[start + k * perStep] = into[k];
    }
  };
  alongLines(height, width, width, 1);
  alongLines(width, height, 1, width);
  return result;
}

/** Length of the gradient, for one pixel of the maps. */
function steepness(nearness: Float32Array, { height, width }: Size): Float32Array {
  const result = new Float32Array(nearness.length);
  for (let y = 0; y < height; y++) {
    const above = Math.max(0, y - 1);
    const below = Math.min(height - 1, y + 1);
    for (let x = 0; x < width; x++) {
      const left = Math.max(0, x - 1);
      const right = Math.min(width - 1, x + 1);
      const across = nearness[y * width + right] - nearness[y * width + left];
      const down = nearness[below * width + x] - nearness[above * width + x];
      const dx = across / (right - left);
      const dy = down / (below - above);
      result[y * width + x] = Math.sqrt(dx * dx + dy * dy);
    }
  }
  return result;
}

function labelsOf(maps: GroundMaps, nearness: Float32Array): DistanceLabel[] {
  const { height, width } = maps.mapSize;
  const labels: DistanceLabel[] = [];
  for (const metres of TICKS_M) {
    const crossings: number[] = [];
    for (let x = 0; x < width; x++) {
      for (let pixel = x; pixel < (height - 1) * width; pixel += width) {
        const crosses = nearness[pixel] <= 1 / metres && nearness[pixel + width] > 1 / metres;
        if (crosses && (maps.ground[pixel] || maps.visibleGround[pixel])) crossings.push(pixel);
      }
    }
    if (crossings.length < LABELLED_SHARE * width) continue;
    const middle = crossings[crossings.length >> 1];
    const x = ((middle % width) + 0.5) / width;
    const y = (Math.floor(middle / width) + 1) / height;
    const inTheWay = labels.some((other) => Math.abs(other.x - x) < 0.12 && Math.abs(other.y - y) < 0.06);
    if (!inTheWay && y > 0.03 && y < 0.97) labels.push({ metres, x, y });
  }
  return labels;
}

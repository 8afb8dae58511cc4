/**
 * The colour scale of distance, the same as in the Python runtime's pictures: logarithmic from
 * 0.5 m (pale yellow) over red to 20 m (indigo), a path through Oklab walked at constant speed, so
 * that lightness falls all the way and the order survives grey print and colour blindness.
 */

export const NEAREST_M = 0.5;
export const FARTHEST_M = 20;

/** Distances that are marked with lines in the picture and on the legend. */
export const TICKS_M = [0.5, 1, 2, 3, 5, 10, 20];

const STEPS = 256;
const FINE = 64 * STEPS;
/** Lightness, chroma, and hue in degrees, in Oklab's polar form. */
const NEAR = [0.94, 0.09, 98];
const MIDDLE = [0.64, 0.183, 25];
const FAR = [0.33, 0.145, -75];

type Triple = [number, number, number];

/** 256 colours of three bytes, from near to far. */
export const COLOUR_SCALE: Uint8Array = colourScale();

/** Where a distance lies on the scale, 0 (near) to 1 (far); what is no number counts as far. */
export function scaleFraction(depthM: number): number {
  const fraction = Math.log(depthM / NEAREST_M) / Math.log(FARTHEST_M / NEAREST_M);
  return Number.isNaN(fraction) ? 1 : Math.min(1, Math.max(0, fraction));
}

/** The index of a distance in `COLOUR_SCALE`. */
export function scalePosition(depthM: number): number {
  return Math.round(scaleFraction(depthM) * (STEPS - 1));
}

/** The colour scale as a CSS gradient from left (near) to right (far). */
export function scaleGradient(): string {
  const stops = Array.from({ length: 33 }, (_, i) => {
    const at = 3 * Math.round((i / 32) * (STEPS - 1));
    return `rgb(${COLOUR_SCALE.slice(at, at + 3).join(" ")})`;
  });
  return `linear-gradient(to right, ${stops.join(", ")})`;
}

function colourScale(): Uint8Array {
  const path = Array.from({ length: FINE }, (_, i) => oklabAt(i / (FINE - 1)));
  const walked = new Float64Array(FINE);
  for (let i = 1; i < FINE; i++) {
    walked[i] = walked[i - 1] + Math.hypot(...path[i].map((each, k) => each - path[i - 1][k]));
  }
  const scale = new Uint8Array(3 * STEPS);
  for (let step = 0, i = 0; step < STEPS; step++) {
    const target = (walked[FINE - 1] * step) / (STEPS - 1);
    while (i < FINE - 2 && walked[i + 1] < target) i++;
    const part = (target - walked[i]) / (walked[i + 1] - walked[i]);
    const lab = path[i].map((each, k) => each + part * (path[i + 1][k] - each)) as Triple;
    scale.set(srgbOf(lab), 3 * step);
  }
  return scale;
}

/** The parabolas from near over middle (at one half) to far. */
function oklabAt(fraction: number): Triple {
  const [lightness, chroma, hueDeg] = NEAR.map((start, i) => {
    const bend = 4 * MIDDLE[i] - 2 * (start + FAR[i]);
    return start + (FAR[i] - start) * fraction + bend * fraction * (1 - fraction);
  });
  const hue = (hueDeg * Math.PI) / 180;
  return [lightness, chroma * Math.cos(hue), chroma * Math.sin(hue)];
}

/** Björn Ottosson, "A perceptual color space for image processing" (2020). */
function srgbOf([l, a, b]: Triple): number[] {
  const long = (l + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const middle = (l - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const short = (l - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * long - 3.3077115913 * middle + 0.2309699292 * short,
    -1.2684380046 * long + 2.6097574011 * middle - 0.3413193965 * short,
    -0.0041960863 * long - 0.7034186147 * middle + 1.707614701 * short,
  ].map((value) => {
    const linear = Math.min(1, Math.max(0, value));
    return Math.round(255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055));
  });
}

/**
 * Antialiased resizing with the very arithmetic of Pillow's `Image.resize`: two passes, each a
 * convolution in fixed point whose result is rounded to 8 bits. The network was calibrated on
 * pictures resized like this, and a browser's own scaling differs from browser to browser.
 */

import type { Pixels, Size } from "../foundation/types.ts";

/** The filters that a model file may name. */
export const FILTERS = ["lanczos", "bilinear", "hamming"] as const;

export type Filter = (typeof FILTERS)[number];

const KERNELS: Record<Filter, { support: number; weight: (x: number) => number }> = {
  lanczos: { support: 3, weight: (x) => (x >= -3 && x < 3 ? sinc(x) * sinc(x / 3) : 0) },
  bilinear: { support: 1, weight: (x) => Math.max(0, 1 - Math.abs(x)) },
  hamming: {
    support: 1,
    weight: (x) => (Math.abs(x) < 1 ? sinc(x) * (0.54 + 0.46 * Math.cos(Math.PI * x)) : 0),
  },
};

/** Fraction bits of the weights: 32 less 8 of the values, one of the sign, one for overshoot. */
const FRACTION_BITS = 22;

/** Where each result of a pass begins to read, how many values it reads, and their weights. */
export interface Taps {
  first: Int32Array;
  count: Int32Array;
  weights: Float64Array;
  stride: number;
}

/**
 * The network's input: the whole picture, resized.
 *
 * @param picture Three or four bytes a pixel; the fourth is ignored.
 * @param to Size of the result.
 * @returns Three bytes a pixel: red, green, blue.
 */
export function resizeToRgb(picture: Pixels, to: Size, filter: Filter): Uint8Array {
  const narrow = resizeRows(picture, to.width, filter);
  return resizeColumns(narrow, { height: picture.height, width: to.width }, to.height, filter);
}

function resizeRows(from: Pixels, width: number, filter: Filter): Uint8Array {
  const bytes = from.data;
  const narrow = new Uint8Array(from.height * width * 3);
  const channels = bytes.length / (from.height * from.width);
  if (width === from.width) {
    for (let read = 0, write = 0; write < narrow.length; read += channels) {
      narrow[write++] = bytes[read];
      narrow[write++] = bytes[read + 1];
      narrow[write++] = bytes[read + 2];
    }
    return narrow;
  }
  const { first, count, weights, stride } = inFixedPoint(tapsOf(from.width, width, filter));
  let write = 0;
  for (let y = 0; y < from.height; y++) {
    const row = y * from.width;
    for (let x = 0; x < width; x++) {
      let red = HALF;
      let green = HALF;
      let blue = HALF;
      let read = (row + first[x]) * channels;
      const begin = x * stride;
      const end = begin + count[x];
      for (let k = begin; k < end; k++, read += channels) {
        const weight = weights[k];
        red += bytes[read] * weight;
        green += bytes[read + 1] * weight;
        blue += bytes[read + 2] * weight;
      }
      narrow[write++] = toByte(red);
      narrow[write++] = toByte(green);
      narrow[write++] = toByte(blue);
    }
  }
  return narrow;
}

function resizeColumns(rgb: Uint8Array, from: Size, height: number, filter: Filter): Uint8Array {
  if (height === from.height) return rgb;
  const { first, count, weights, stride } = inFixedPoint(tapsOf(from.height, height, filter));
  const rowLength = from.width * 3;
  const result = new Uint8Array(height * rowLength);
  const sums = new Int32Array(rowLength);
  for (let y = 0; y < height; y++) {
    sums.fill(HALF);
    for (let k = 0; k < count[y]; k++) {
      const weight = weights[y * stride + k];
      const row = (first[y] + k) * rowLength;
      for (let i = 0; i < rowLength; i++) sums[i] += rgb[row + i] * weight;
    }
    const row = y * rowLength;
    for (let i = 0; i < rowLength; i++) result[row + i] = toByte(sums[i]);
  }
  return result;
}

const HALF = 1 << (FRACTION_BITS - 1);

function toByte(sum: number): number {
  const value = sum >> FRACTION_BITS;
  return value < 0 ? 0 : value > 255 ? 255 : value;
}

/** The weights of a pass from `from` to `to` values. */
export function tapsOf(from: number, to: number, filter: Filter): Taps {
  const { support, weight } = KERNELS[filter];
  const scale = from / to;
  const stretch = Math.max(1, scale);
  const reach = support * stretch;
  const stride = Math.ceil(reach) * 2 + 1;
  const taps: Taps = {
    first: new Int32Array(to),
    count: new Int32Array(to),
    weights: new Float64Array(to * stride),
    stride,
  };
  for (let i = 0; i < to; i++) {
    const centre = (i + 0.5) * scale;
    const first = Math.max(0, Math.trunc(centre - reach + 0.5));
    const count = Math.min(from, Math.trunc(centre + reach + 0.5)) - first;
    let total = 0;
    for (let k = 0; k < count; k++) {
      const each = weight((k + first - centre + 0.5) * (1 / stretch));
      taps.weights[i * stride + k] = each;
      total += each;
    }
    for (let k = 0; k < count; k++) taps.weights[i * stride + k] /= total;
    taps.first[i] = first;
    taps.count[i] = count;
  }
  return taps;
}

function inFixedPoint({ weights, ...taps }: Taps): Omit<Taps, "weights"> & { weights: Int32Array } {
  const rounded = Int32Array.from(weights, (each) => {
    const scaled = each * (1 << FRACTION_BITS);
    return Math.trunc(scaled + (scaled < 0 ? -0.5 : 0.5));
  });
  return { ...taps, weights: rounded };
}

function sinc(x: number): number {
  return x === 0 ? 1 : Math.sin(Math.PI * x) / (Math.PI * x);
}

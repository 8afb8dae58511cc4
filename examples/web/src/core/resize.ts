/**
 * Antialiased resizing with the very arithmetic of Pillow's `Image.resize`: two passes, each a
 * convolution in fixed point whose result is rounded to 8 bits. The network was calibrated on
 * pictures resized like this, and a browser's own scaling differs from browser to browser.
 */

export interface Size {
  height: number;
  width: number;
}

export type Filter = "lanczos" | "bilinear";

const FILTERS: Record<Filter, { support: number; weight: (x: number) => number }> = {
  lanczos: { support: 3, weight: (x) => (x >= -3 && x < 3 ? sinc(x) * sinc(x / 3) : 0) },
  bilinear: { support: 1, weight: (x) => Math.max(0, 1 - Math.abs(x)) },
};

/** Fraction bits of the weights: 32 less 8 of the values, one of the sign, one for overshoot. */
const FRACTION_BITS = 22;

/** Where each result of a pass begins to read, how many values it reads, and their weights. */
interface Taps {
  first: Int32Array;
  count: Int32Array;
  weights: Int32Array;
  stride: number;
}

/**
 * The network's input: the whole picture, resized.
 *
 * @param rgba Four bytes a pixel, row by row; the fourth is ignored.
 * @param from Size of `rgba`.
 * @param to Size of the result.
 * @returns Three bytes a pixel: red, green, blue.
 */
export function resizeToRgb(
  rgba: Uint8ClampedArray | Uint8Array,
  from: Size,
  to: Size,
  filter: Filter,
): Uint8Array {
  const narrow = resizeRows(rgba, from, to.width, filter);
  return resizeColumns(narrow, { height: from.height, width: to.width }, to.height, filter);
}

function resizeRows(
  rgba: Uint8ClampedArray | Uint8Array,
  from: Size,
  width: number,
  filter: Filter,
): Uint8Array {
  const narrow = new Uint8Array(from.height * width * 3);
  if (width === from.width) {
    for (let read = 0, write = 0; write < narrow.length; read += 4) {
      narrow[write++] = rgba[read];
      narrow[write++] = rgba[read + 1];
      narrow[write++] = rgba[read + 2];
    }
    return narrow;
  }
  const { first, count, weights, stride } = tapsOf(from.width, width, filter);
  let write = 0;
  for (let y = 0; y < from.height; y++) {
    const row = y * from.width;
    for (let x = 0; x < width; x++) {
      let red = HALF;
      let green = HALF;
      let blue = HALF;
      let read = (row + first[x]) * 4;
      const begin = x * stride;
      const end = begin + count[x];
      for (let k = begin; k < end; k++, read += 4) {
        const weight = weights[k];
        red += rgba[read] * weight;
        green += rgba[read + 1] * weight;
        blue += rgba[read + 2] * weight;
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
  const { first, count, weights, stride } = tapsOf(from.height, height, filter);
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

function tapsOf(from: number, to: number, filter: Filter): Taps {
  const { support, weight } = FILTERS[filter];
  const scale = from / to;
  const stretch = Math.max(1, scale);
  const reach = support * stretch;
  const stride = Math.ceil(reach) * 2 + 1;
  const taps: Taps = {
    first: new Int32Array(to),
    count: new Int32Array(to),
    weights: new Int32Array(to * stride),
    stride,
  };
  for (let i = 0; i < to; i++) {
    const centre = (i + 0.5) * scale;
    const first = Math.max(0, Math.trunc(centre - reach + 0.5));
    const count = Math.min(from, Math.trunc(centre + reach + 0.5)) - first;
    const exact = Array.from({ length: count }, (_, k) =>
      weight((k + first - centre + 0.5) * (1 / stretch)),
    );
    const total = exact.reduce((sum, each) => sum + each, 0);
    exact.forEach((each, k) => {
      const scaled = (each / total) * (1 << FRACTION_BITS);
      taps.weights[i * stride + k] = Math.trunc(scaled + (scaled < 0 ? -0.5 : 0.5));
    });
    taps.first[i] = first;
    taps.count[i] = count;
  }
  return taps;
}

function sinc(x: number): number {
  return x === 0 ? 1 : Math.sin(Math.PI * x) / (Math.PI * x);
}

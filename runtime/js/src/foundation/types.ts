/** What the stages exchange. Maps and masks lie row by row, one value for each pixel. */

export interface Size {
  height: number;
  width: number;
}

/** A decoded, upright picture: three (RGB) or four (RGBA) bytes a pixel, row by row. */
export interface Pixels extends Size {
  data: Uint8Array | Uint8ClampedArray;
}

/** x and y, or forward and left. */
export type Pair = readonly [number, number];

export type Triple = [number, number, number];

/** 1 where it holds, else 0. */
export type Mask = Uint8Array;

import { describe, expect, it } from "vitest";

import { decodedPixels } from "../src/inputs/pixels.ts";
import { FILTERS, resizeToRgb } from "../src/inputs/resize.ts";
import { workingSize } from "../src/inputs/working-size.ts";
import { facts, fixturePath, readBytes } from "./fixtures.ts";

function withOpacity(rgb: Uint8Array): Uint8Array {
  return Uint8Array.from({ length: (rgb.length / 3) * 4 }, (_, i) =>
    i % 4 === 3 ? 255 : rgb[(i >> 2) * 3 + (i % 4)],
  );
}

describe("resizing", () => {
  const cases = facts().resizes.flatMap((sizes, i) => FILTERS.map((filter) => ({ i, filter, sizes })));

  it.each(cases)("gives Pillow's pixels: $sizes, $filter", ({ i, filter, sizes }) => {
    const [height, width, toHeight, toWidth] = sizes;
    const rgb = readBytes(fixturePath(`resize-${i}.npy`)).data;
    const expected = readBytes(fixturePath(`resize-${i}-${filter}.npy`)).data;
    const to = { height: toHeight, width: toWidth };
    const resized = resizeToRgb({ data: rgb, height, width }, to, filter);
    expect(resizeToRgb({ data: withOpacity(rgb), height, width }, to, filter)).toEqual(resized);
    expect(resized.length).toBe(expected.length);
    const worst = expected.reduce((most, each, at) => Math.max(most, Math.abs(each - resized[at])), 0);
    expect(worst).toBeLessThanOrEqual(1);
  });
});

describe("working size", () => {
  it.each(facts().sizes)("of %i x %i is the runtime's", (height, width, toHeight, toWidth) => {
    expect(workingSize({ height, width })).toEqual({ height: toHeight, width: toWidth });
  });
});

describe("pixels", () => {
  it("are white where they are transparent", () => {
    const data = Uint8Array.from([10, 20, 30, 255, 10, 20, 30, 0, 0, 100, 200, 51]);
    const picture = decodedPixels({ data, width: 3, height: 1 });
    expect([...picture.data]).toEqual([10, 20, 30, 255, 255, 255, 255, 255, 204, 224, 244, 255]);
  });

  it("are refused with the number of bytes that they should have", () => {
    expect(() => decodedPixels({ data: new Uint8Array(10), width: 2, height: 2 })).toThrow(
      /2 x 2 pixels has 10 bytes; give 3 \(RGB\) or 4/,
    );
    expect(() => decodedPixels({ data: new Uint8Array(), width: 0, height: 2 })).toThrow(/0 x 2/);
  });
});

import { describe, expect, it } from "vitest";

import { resizeToRgb, type Filter } from "../../src/core/resize";
import { workingSize } from "../../src/core/working-size";
import { facts, fixturePath, readBytes } from "../fixtures";

function withOpacity(rgb: Uint8Array): Uint8Array {
  return Uint8Array.from({ length: (rgb.length / 3) * 4 }, (_, i) =>
    i % 4 === 3 ? 255 : rgb[(i >> 2) * 3 + (i % 4)],
  );
}

describe("resizing", () => {
  const cases = facts().resizes.flatMap((sizes, i) =>
    (["lanczos", "bilinear"] as Filter[]).map((filter) => ({ i, filter, sizes })),
  );

  it.each(cases)("gives Pillow's pixels: $sizes, $filter", ({ i, filter, sizes }) => {
    const [height, width, toHeight, toWidth] = sizes;
    const rgba = withOpacity(readBytes(fixturePath(`resize-${i}.npy`)).data);
    const expected = readBytes(fixturePath(`resize-${i}-${filter}.npy`)).data;
    const resized = resizeToRgb(
      rgba,
      { height, width },
      { height: toHeight, width: toWidth },
      filter,
    );
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

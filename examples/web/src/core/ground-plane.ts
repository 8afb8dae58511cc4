/** The one plane that the ground lies in, for lengths on it that no ripple of a depth disturbs. */

import { THRESHOLD, type Maps } from "./maps";

const FEWEST_PIXELS = 20;

/** Three numbers need no more pixels than this, drawn evenly. */
const FITTED = 2000;

const ROUNDS = 8;

type Triple = [number, number, number];

/** The ground as a plane: a viewing ray r meets it at the depth 1 / (slope . r). */
export class GroundPlane {
  private constructor(
    private readonly maps: Maps,
    private readonly slope: Triple,
  ) {}

  /**
   * The plane of most of the ground; null if there is too little ground to carry one, or it lies
   * above the camera.
   *
   * Along a plane the inverse depth is affine in the pixel, and a network's error is even in
   * inverse depth, not in metres. So these are least squares in inverse depth, done again without
   * what is far off, until it settles.
   */
  static fit(maps: Maps): GroundPlane | null {
    const ground: number[] = [];
    maps.groundProbability.forEach((each, pixel) => each > THRESHOLD && ground.push(pixel));
    if (ground.length < FEWEST_PIXELS) return null;
    const stride = Math.ceil(ground.length / FITTED);
    const chosen = ground.filter((_, i) => i % stride === 0);
    const rays = chosen.map((pixel) => rayOf(maps, pixel));
    const nearness = chosen.map((pixel) => 1 / maps.groundDepthM[pixel]);
    let slope = leastSquares(rays, nearness, () => true);
    for (let round = 0; round < ROUNDS && slope; round++) {
      const fitted = slope;
      const off = Float64Array.from(rays, (ray, i) => Math.abs(dot(fitted, ray) - nearness[i]));
      const median = off.toSorted()[off.length >> 1];
      const most = Math.max(2.5 * 1.4826 * median, 1e-9);
      slope = leastSquares(rays, nearness, (i) => off[i] <= most);
    }
    const isAbove = slope !== null && -slope[1] > 0.2 * Math.hypot(...slope);
    return slope === null || isAbove ? null : new GroundPlane(maps, slope);
  }

  /** The inverse of the plane's depth on a pixel's ray; not positive at and above the horizon. */
  nearnessAt(pixel: number): number {
    const { width, camera } = this.maps;
    const x = pixel % width;
    const y = (pixel - x) / width;
    const [a, b, c] = this.slope;
    return (a * (x - camera.cx)) / camera.fx + (b * (y - camera.cy)) / camera.fy + c;
  }

  /** Where a pixel's ray meets the plane, metres in camera axes; NaN at and above the horizon. */
  at(pixel: number): Triple {
    const ray = rayOf(this.maps, pixel);
    const nearness = this.nearnessAt(pixel);
    return ray.map((each) => (nearness > 1e-9 ? each / nearness : NaN)) as Triple;
  }
}

function rayOf({ width, camera }: Maps, pixel: number): Triple {
  const x = pixel % width;
  const y = (pixel - x) / width;
  return [(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1];
}

function dot(a: Triple, b: Triple): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a: Triple, b: Triple): Triple {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** The s with least sum of (s . ray - nearness)^2; null where the rays lie in one plane. */
function leastSquares(
  rays: Triple[],
  nearness: number[],
  counts: (i: number) => boolean,
): Triple | null {
  const normal: Triple[] = [[0, 0, 0], [0, 0, 0], [0, 0, 0]];
  const right: Triple = [0, 0, 0];
  rays.forEach((ray, i) => {
    if (!counts(i)) return;
    for (let row = 0; row < 3; row++) {
      right[row] += ray[row] * nearness[i];
      for (let column = 0; column < 3; column++) normal[row][column] += ray[row] * ray[column];
    }
  });
  // Cramer's rule; the matrix is symmetric, so its rows are its columns.
  const [a, b, c] = normal;
  const determinant = dot(a, cross(b, c));
  if (Math.abs(determinant) < 1e-12) return null;
  return [cross(b, c), cross(c, a), cross(a, b)].map((each) => dot(right, each) / determinant) as Triple;
}

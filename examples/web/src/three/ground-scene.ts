/**
 * A prediction as a scene of three.js: a camera like the photo's, the floor as a mesh, and what stands on
 * it as a mesh that hides what is behind.
 *
 * The photo's camera looks from the origin: x right, y up, z backwards, as in three.js, in metres.
 */

import type { Prediction } from "footprints-edge";
import * as three from "three";

/** Quads between pixels whose depths differ by more than this join two things, and are left out. */
const TORN = 1.25;

/** A camera that projects as the photo's does. */
export function cameraOf({ intrinsics, mapSize }: Prediction): three.Camera {
  const { fx, fy, cx, cy } = intrinsics;
  const [near, far] = [0.05, 200];
  const camera = new three.Camera();
  camera.projectionMatrix.makePerspective(
    (-(cx + 0.5) / fx) * near,
    ((mapSize.width - 0.5 - cx) / fx) * near,
    ((cy + 0.5) / fy) * near,
    (-(mapSize.height - 0.5 - cy) / fy) * near,
    near,
    far,
  );
  camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
  return camera;
}

/** The floor, seen and hidden: invisible but for the shadows that fall on it. */
export function floorOf(prediction: Prediction): three.Mesh {
  const { ground, unmaskedGroundDepthM } = prediction;
  const geometry = surface(prediction, (pixel) => (ground[pixel] ? unmaskedGroundDepthM[pixel] : NaN));
  const floor = new three.Mesh(geometry, new three.ShadowMaterial({ opacity: 0.4 }));
  floor.receiveShadow = true;
  return floor;
}

/** All that is seen and is no floor: it shows the photo, and hides what walks behind it. */
export function thingsOf(prediction: Prediction): three.Mesh {
  const { visibleGround, hiddenGround, visibleDepthM, unmaskedGroundDepthM } = prediction;
  const scale = scaleOf(prediction);
  const geometry = surface(prediction, (pixel) => {
    if (visibleGround[pixel]) return NaN;
    const depthM = scale * visibleDepthM[pixel];
    // What hides ground stands in front of it, whatever the depths say.
    return hiddenGround[pixel] ? Math.min(depthM, 0.97 * unmaskedGroundDepthM[pixel]) : depthM;
  });
  const things = new three.Mesh(geometry, new three.MeshBasicMaterial({ colorWrite: false }));
  things.renderOrder = -1;
  return things;
}

/** The function from a place on the floor, forward and left in metres, to the scene. */
export function onFloor(prediction: Prediction): (place: [number, number]) => three.Vector3 {
  const { axes, cameraHeightM } = prediction.groundPlane();
  const [forward, left, up] = axes.map(([x, y, z]) => new three.Vector3(x, -y, -z));
  return ([x, y]) =>
    new three.Vector3()
      .addScaledVector(forward, x)
      .addScaledVector(left, y)
      .addScaledVector(up, -cameraHeightM);
}

export function upOf(prediction: Prediction): three.Vector3 {
  const [x, y, z] = prediction.groundPlane().up;
  return new three.Vector3(x, -y, -z);
}

/** From the network's metres of what is seen to those of the floor, which the plane knows better. */
function scaleOf({ visibleGround, visibleDepthM, unmaskedGroundDepthM }: Prediction): number {
  const ratios = unmaskedGroundDepthM
    .map((depthM, i) => (visibleGround[i] ? depthM / visibleDepthM[i] : NaN))
    .filter((ratio) => ratio > 0)
    .sort();
  return ratios.length > 0 ? ratios[ratios.length >> 1] : 1;
}

/** The surface through the pixels of the maps whose depth is a number. */
function surface(
  { intrinsics: { fx, fy, cx, cy }, mapSize: { width, height } }: Prediction,
  depthAt: (pixel: number) => number,
): three.BufferGeometry {
  const positions = new Float32Array(3 * width * height);
  const depths = new Float32Array(width * height);
  for (let y = 0, pixel = 0; y < height; y++) {
    for (let x = 0; x < width; x++, pixel++) {
      depths[pixel] = depthAt(pixel);
      const depthM = Number.isFinite(depths[pixel]) ? depths[pixel] : 0;
      // The outermost pixels reach to the picture's border.
      const [u, v] = [x === 0 ? -0.5 : x === width - 1 ? width - 0.5 : x, y === height - 1 ? height - 0.5 : y];
      positions.set([((u - cx) / fx) * depthM, -((v - cy) / fy) * depthM, -depthM], 3 * pixel);
    }
  }
  const corners: number[] = [];
  for (let y = 0; y + 1 < height; y++) {
    for (let x = 0; x + 1 < width; x++) {
      const first = y * width + x;
      const quad = [first, first + width, first + 1, first + width + 1];
      const nearest = Math.min(...quad.map((pixel) => depths[pixel])); // NaN where one is none
      if (!(Math.max(...quad.map((pixel) => depths[pixel])) < TORN * nearest)) continue;
      corners.push(quad[0], quad[1], quad[2], quad[2], quad[1], quad[3]);
    }
  }
  const geometry = new three.BufferGeometry();
  geometry.setAttribute("position", new three.BufferAttribute(positions, 3));
  geometry.setIndex(corners);
  geometry.computeVertexNormals();
  return geometry;
}

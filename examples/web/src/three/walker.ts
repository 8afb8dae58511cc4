/** Someone to send across the floor: a figure of a few solids, with legs that swing. */

import * as three from "three";

/** Metres on the floor for a step of both legs, as a share of the figure's height. */
const STRIDE = 0.75;

export class Walker {
  readonly object = new three.Group();
  private readonly limbs: three.Group[] = [];

  constructor(private readonly heightM: number) {
    const [skin, shirt, trousers] = [0xf2c29b, 0xffd23f, 0x2b4a8b].map(
      (color) => new three.MeshStandardMaterial({ color, roughness: 0.8 }),
    );
    const add = (to: three.Object3D, shape: three.BufferGeometry, material: three.Material, y: number) => {
      const mesh = new three.Mesh(shape, material);
      mesh.position.y = y * heightM;
      mesh.castShadow = true;
      to.add(mesh);
    };
    const capsule = (radius: number, length: number) =>
      new three.CapsuleGeometry(radius * heightM, length * heightM, 6, 14);
    add(this.object, new three.SphereGeometry(0.1 * heightM, 24, 18), skin, 0.89);
    add(this.object, capsule(0.1, 0.2), shirt, 0.62);
    for (const [x, hang, radius, length, material] of [
      [-0.06, 0.48, 0.055, 0.36, trousers],
      [0.06, 0.48, 0.055, 0.36, trousers],
      [-0.145, 0.73, 0.035, 0.24, shirt],
      [0.145, 0.73, 0.035, 0.24, shirt],
    ] as const) {
      const limb = new three.Group();
      limb.position.set(x * heightM, hang * heightM, 0);
      add(limb, capsule(radius, length), material, -length / 2 - (material === trousers ? radius / 2 : 0));
      this.object.add(limb);
      this.limbs.push(limb);
    }
  }

  /** Stands at a place, looks along a direction, and has walked so far, metres. */
  stand(at: three.Vector3, ahead: three.Vector3, up: three.Vector3, walkedM: number): void {
    const back = ahead.clone().addScaledVector(up, -ahead.dot(up)).normalize().negate();
    const right = up.clone().cross(back);
    this.object.quaternion.setFromRotationMatrix(new three.Matrix4().makeBasis(right, up, back));
    this.object.position.copy(at);
    const swing = 0.55 * Math.sin((2 * Math.PI * walkedM) / (STRIDE * this.heightM));
    this.limbs.forEach((limb, i) => (limb.rotation.x = i % 3 === 0 ? swing : -swing));
  }
}

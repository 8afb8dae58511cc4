/** What is known of the camera's pose above level ground. */

import { CameraPoseError } from "../errors.ts";
import type { Triple } from "../foundation/types.ts";

/** The known part of a camera's pose; null where it is not known. */
export interface CameraPose {
  /** Height of the camera above the ground, metres. */
  heightM: number | null;
  /** Downward pitch in degrees: 0 looks at the horizon, 90 straight down. */
  pitchDeg: number | null;
  /** Roll about the optical axis in degrees, right side down. */
  rollDeg: number | null;
}

export interface PoseOptions {
  /** Height of the camera above the ground, metres, if known. */
  cameraHeightM?: number | null | undefined;
  /** Downward pitch of the camera, degrees, if known. */
  pitchDeg?: number | null | undefined;
  /** Roll about the optical axis, degrees, right side down, if known. */
  rollDeg?: number | null | undefined;
  /** Direction of gravity in camera axes (x right, y down, z forward), instead of pitch and roll. */
  gravity?: readonly [number, number, number] | null | undefined;
}

/** @throws CameraPoseError If a value is impossible, or gravity is given beside pitch or roll. */
export function poseOf({ cameraHeightM, pitchDeg, rollDeg, gravity }: PoseOptions): CameraPose {
  const pose = { heightM: cameraHeightM ?? null, pitchDeg: pitchDeg ?? null, rollDeg: rollDeg ?? null };
  if (gravity) {
    if (pose.pitchDeg !== null || pose.rollDeg !== null) {
      throw new CameraPoseError("gravity is given beside pitchDeg or rollDeg; give either");
    }
    Object.assign(pose, anglesOf(gravity));
  }
  if (pose.heightM !== null && !(Number.isFinite(pose.heightM) && pose.heightM > 0)) {
    throw new CameraPoseError(
      `the camera height is ${pose.heightM}; give it as a positive number of metres above the ground`,
    );
  }
  for (const [name, value, most] of [
    ["pitch", pose.pitchDeg, 90],
    ["roll", pose.rollDeg, 180],
  ] as const) {
    if (value !== null && !(Math.abs(value) <= most)) {
      throw new CameraPoseError(
        `the ${name} is ${value}; give degrees from -${most} to ${most} (pitch down and right side ` +
          "down are positive)",
      );
    }
  }
  return pose;
}

/** Whether anything is known. */
export function knowsAnything({ heightM, pitchDeg, rollDeg }: CameraPose): boolean {
  return heightM !== null || pitchDeg !== null || rollDeg !== null;
}

/** Whether all of it is known: then the ground plane is, too. */
export function knowsEverything({ heightM, pitchDeg, rollDeg }: CameraPose): boolean {
  return heightM !== null && pitchDeg !== null && rollDeg !== null;
}

/** The unit vector that points up, in camera axes. */
export function upVector(pitchDeg: number, rollDeg: number): Triple {
  const pitch = (pitchDeg * Math.PI) / 180;
  const roll = (rollDeg * Math.PI) / 180;
  const level = Math.cos(pitch);
  return [-Math.sin(roll) * level, -Math.cos(roll) * level, -Math.sin(pitch)];
}

function anglesOf(gravity: readonly [number, number, number]) {
  const length = Math.hypot(...gravity);
  if (gravity.length !== 3 || !Number.isFinite(length) || length === 0) {
    throw new CameraPoseError(
      `gravity is [${gravity}]; give its direction in camera axes as three numbers: x right, y down, ` +
        "z forward",
    );
  }
  const [x, y, z] = gravity.map((part) => part / length);
  return {
    pitchDeg: (Math.asin(Math.max(-1, Math.min(1, z))) * 180) / Math.PI,
    rollDeg: (Math.atan2(x, y) * 180) / Math.PI,
  };
}

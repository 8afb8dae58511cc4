/** Reads what `make_fixtures.py` wrote. */

import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";

export type Photo = {
  camera: [number, number, number, number, "exif" | "assumed"];
};

export interface Facts {
  resizes: [number, number, number, number][];
  sizes: [number, number, number, number][];
  colours: number[];
  positions: [number, number][];
  depths: [number, number, number][];
  /** What JPEG files say of their lens. */
  lenses: Record<string, { focal35mm: number | null; panorama: boolean }>;
  photos: Record<string, Photo>;
}

export function fixturePath(name: string): string {
  return fileURLToPath(new URL(`fixtures/${name}`, import.meta.url));
}

export function facts(): Facts {
  return JSON.parse(readFileSync(fixturePath("facts.json"), "utf8")) as Facts;
}

export interface NumpyArray<T> {
  shape: number[];
  data: T;
}

/** A `.npy` file of bytes. */
export function readBytes(path: string): NumpyArray<Uint8Array> {
  const { type, shape, body } = readNumpy(path);
  if (type !== "|u1") throw new Error(`${path} holds ${type}, not |u1`);
  return { shape, data: new Uint8Array(body) };
}

/** A `.npy` file of floats. */
export function readFloats(path: string): NumpyArray<Float32Array> {
  const { type, shape, body } = readNumpy(path);
  if (type === "<f8") return { shape, data: Float32Array.from(new Float64Array(body)) };
  if (type !== "<f4") throw new Error(`${path} holds ${type}, not <f4`);
  return { shape, data: new Float32Array(body) };
}

function readNumpy(path: string) {
  const file = readFileSync(path);
  const length = file.readUInt16LE(8);
  const header = file.toString("latin1", 10, 10 + length);
  const type = /'descr': '([^']+)'/.exec(header)![1];
  const shape = /'shape': \(([^)]*)\)/.exec(header)![1].split(",").filter((s) => s.trim()).map(Number);
  const body = file.buffer.slice(file.byteOffset + 10 + length, file.byteOffset + file.length);
  return { type, shape, body };
}

/** The bytes of a `.npy` file. */
export function numpyFile(data: Float32Array | Uint8Array, shape: number[]): Buffer {
  const type = data instanceof Uint8Array ? "|u1" : "<f4";
  const text = `{'descr': '${type}', 'fortran_order': False, 'shape': (${shape.join(", ")},), }`;
  const header = text.padEnd(Math.ceil((text.length + 11) / 64) * 64 - 11) + "\n";
  const start = Buffer.from([0x93, 0x4e, 0x55, 0x4d, 0x50, 0x59, 1, 0, 0, 0]);
  start.writeUInt16LE(header.length, 8);
  return Buffer.concat([start, Buffer.from(header), Buffer.from(data.buffer, data.byteOffset, data.byteLength)]);
}

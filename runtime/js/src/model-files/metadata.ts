/** What a model file says about itself, in the `metadata_props` of the ONNX file. */

import { ModelError } from "../errors.ts";
import { FILTERS, type Filter } from "../inputs/resize.ts";

export interface ModelMetadata {
  name: string;
  precision: string;
  licence: string;
  /** Depths in metres of disparity 1 and 0. */
  depthRangeM: [number, number];
  /** Focal length, in pixels of the network's input, that depths are for; null: as trained. */
  focalPx: number | null;
  /** The filter that makes the network's input. */
  resize: Filter;
}

const PREFIX = "footprints.";
const FORMAT = "1";

/** The ONNX schema's numbers of the fields that are read here. */
const METADATA_PROPS = 14;
const [KEY, VALUE] = [1, 2];

/**
 * Reads the facts that a prediction needs.
 *
 * @param file The bytes of an ONNX file.
 * @throws ModelError If it is not a model of the footprints-edge contract.
 */
export function readMetadata(file: Uint8Array): ModelMetadata {
  const props = metadataProps(file);
  const read = (key: string): string => {
    const value = props.get(PREFIX + key);
    if (value === undefined) throw new ModelError(`the model file lacks the metadata ${PREFIX}${key}`);
    return value;
  };
  const complaint = (key: string) =>
    new ModelError(`the model file's ${PREFIX}${key} is "${read(key)}", which this package cannot read`);
  if (read("format") !== FORMAT) throw complaint("format");
  // Only files that lack some of the four maps say so; this package wants all of them.
  if ((props.get(`${PREFIX}outputs`) ?? "all") !== "all") throw complaint("outputs");
  const [nearestM, farthestM] = read("depth_range_m").split(",").map(Number);
  if (!(0 < nearestM && nearestM < farthestM)) throw complaint("depth_range_m");
  const camera = read("camera");
  const focalPx = camera === "none" ? null : Number(camera.replace("focal_px=", ""));
  if (focalPx !== null && !(focalPx > 0)) throw complaint("camera");
  const resize = read("resize");
  if (!FILTERS.includes(resize as Filter)) throw complaint("resize");
  return {
    name: read("name"),
    precision: read("precision"),
    licence: read("licence"),
    depthRangeM: [nearestM, farthestM],
    focalPx,
    resize: resize as Filter,
  };
}

/** The `metadata_props` of an ONNX file: fields are skipped over, the graph is never looked into. */
function metadataProps(file: Uint8Array): Map<string, string> {
  const props = new Map<string, string>();
  const text = new TextDecoder();
  for (const field of fieldsOf(file)) {
    if (field.number !== METADATA_PROPS) continue;
    const entry = new Map(
      [...fieldsOf(field.bytes)].map(({ number, bytes }) => [number, text.decode(bytes)]),
    );
    props.set(entry.get(KEY) ?? "", entry.get(VALUE) ?? "");
  }
  return props;
}

/** The length-delimited fields of a protobuf message, in order. */
function* fieldsOf(message: Uint8Array): Generator<{ number: number; bytes: Uint8Array }> {
  let at = 0;
  const varint = (): number => {
    let value = 0;
    for (let place = 1; ; place *= 128) {
      const byte = message[at++];
      if (byte === undefined) throw new ModelError("the model file is damaged: it ends too early");
      value += (byte & 127) * place;
      if (byte < 128) return value;
    }
  };
  while (at < message.length) {
    const tag = varint();
    const kind = tag % 8;
    if (kind === 0) varint();
    else if (kind === 1) at += 8;
    else if (kind === 5) at += 4;
    else if (kind === 2) {
      const length = varint();
      yield { number: Math.floor(tag / 8), bytes: message.subarray(at, at + length) };
      at += length;
    } else throw new ModelError("the model file is damaged, or no ONNX file");
  }
}

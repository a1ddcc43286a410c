// The body that a page holds: its description, and its arrays in one run of bytes.
import type { ArrayPlace, BodyDescription } from "./protocol";

const BYTES = { f64: 8, f32: 4, u32: 4 } as const;

/** Reads base64. Throws: Error for other text. */
export function decodeBase64(text: string): Uint8Array<ArrayBuffer> {
  let letters: string;
  try {
    letters = atob(text.trim());
  } catch {
    throw new Error("its arrays are no base64");
  }
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

function checkPlace(name: string, place: ArrayPlace | undefined, size: number): void {
  const width = place && BYTES[place.type];
  const isWhole = width && Number.isInteger(place.at) && Number.isInteger(place.count) && place.at >= 0 && place.count >= 0 && place.at % width === 0;
  if (!isWhole) throw new Error(`its array ${name} is not described`);
  if (place.at + place.count * width > size) throw new Error(`its array ${name} ends behind its ${size} bytes`);
}

/**
 * Checks a description against its bytes, so that nothing is read that is not there and every vertex that is named exists.
 * Throws: Error in words for a reader.
 */
export function checkBody(value: unknown, bytes: ArrayBuffer): BodyDescription {
  const body = value as BodyDescription | null;
  if (!body || body.schema !== "palpate/live/1") throw new Error("it is no body of palpate/live/1");
  if (!Array.isArray(body.levels) || body.levels.length === 0) throw new Error("it has no mesh");
  body.levels.forEach((level, number) => {
    const name = (key: string) => `levels[${number}].${key}`;
    for (const key of ["points", "tets", "spring_ends", "spring_rest_m", "spring_n_per_m", "given_number"] as const) checkPlace(name(key), level[key], bytes.byteLength);
    const vertices = level.points.count / 3;
    const indices = { tets: level.tets, spring_ends: level.spring_ends } as Record<string, ArrayPlace>;
    (level.supports ?? []).forEach((support, k) => {
      checkPlace(name(`supports[${k}].weights`), support.weights, bytes.byteLength);
      indices[`supports[${k}].faces`] = support.faces;
    });
    (level.held ?? []).forEach((held, k) => (indices[`held[${k}].faces`] = held.faces));
    for (const [key, place] of Object.entries(indices)) {
      checkPlace(name(key), place, bytes.byteLength);
      for (const vertex of u32(bytes, place)) {
        if (vertex >= vertices) throw new Error(`its array ${name(key)} names vertex ${vertex}, and there are ${vertices}`);
      }
    }
    for (const x of f64(bytes, level.points)) if (!Number.isFinite(x)) throw new Error(`its array ${name("points")} has a coordinate that is no finite number`);
  });
  if (body.table) for (const key of ["vertices", "skin", "field"] as const) checkPlace(`table.${key}`, body.table[key], bytes.byteLength);
  return body;
}

export function f64(bytes: ArrayBuffer, place: ArrayPlace): Float64Array {
  return new Float64Array(bytes, place.at, place.count);
}

export function f32(bytes: ArrayBuffer, place: ArrayPlace): Float32Array {
  return new Float32Array(bytes, place.at, place.count);
}

export function u32(bytes: ArrayBuffer, place: ArrayPlace): Uint32Array {
  return new Uint32Array(bytes, place.at, place.count);
}

/** Bytes of the first table that is larger than all else: what a level leaves out. */
export function tableVertices(body: BodyDescription, bytes: ArrayBuffer): Uint32Array {
  return body.table ? u32(bytes, body.table.vertices) : new Uint32Array();
}

// A body of the page, unpacked: its mesh, its figures, and its shape at a moment.
import type { Scalars } from "../view/colour_scale";
import type { OrganMesh } from "../view/skin";
import { unpack, unpackField, type BodyData, type MeshData } from "./page_data";

/** The figure that a moving or loaded body has besides those it came with. */
export const DISPLACEMENT = "displacement";

export interface Body {
  data: BodyData;
  mesh: OrganMesh;
  fields: Map<string, Scalars>;
  /** Of a load: x, y, z of each vertex. */
  displacement: Float32Array | null;
  /** Displacements of each frame of a motion. */
  frames: Float32Array[];
  /** Displacements are shown in this unit: in mm where the mesh is in m. */
  unit: string;
  /** What a length of the mesh is multiplied by for it. */
  factor: number;
}

/** Throws: Error where the data is broken. */
export async function unpackMesh(data: MeshData): Promise<OrganMesh> {
  const positions = new Float32Array(await unpack(data.positions.data));
  const packed = await unpack(data.indices.data);
  const tets = data.indices.type === "u16" ? Uint32Array.from(new Uint16Array(packed)) : new Uint32Array(packed);
  if (positions.length !== 3 * data.vertices || tets.length !== 4 * data.tets) throw new Error("vertices or tetrahedra are missing");
  return { positions, tets };
}

/** A body on its mesh. Throws: Error where the data is broken. */
export async function unpackBody(data: BodyData, mesh: OrganMesh): Promise<Body> {
  const fields = new Map<string, Scalars>();
  for (const field of data.fields) {
    const values = await unpackField(field);
    fields.set(field.title, { values, on: field.on, name: field.title, unit: field.unit, range: [field.low, field.high], scale: field.scale });
  }
  const displacement = data.displacement ? new Float32Array(await unpack(data.displacement.data)) : null;
  const frames = data.motion ? await unpackFrames(data, mesh.positions.length / 3) : [];
  if (displacement && displacement.length !== mesh.positions.length) throw new Error(`${data.title}: displacements are missing`);
  const isInMetres = data.unit === "m";
  return { data, mesh, fields, displacement, frames, unit: isInMetres ? "mm" : data.unit, factor: isInMetres ? 1000 : 1 };
}

async function unpackFrames(data: BodyData, vertices: number): Promise<Float32Array[]> {
  const { motion } = data;
  const steps = new Int16Array(await unpack(motion!.data));
  if (steps.length !== 3 * vertices * motion!.times_s.length) throw new Error(`${data.title}: frames are missing`);
  // Each frame but the first is what it differs by from the one before.
  const size = motion!.most / motion!.levels;
  const sum = new Int32Array(3 * vertices);
  return motion!.times_s.map((_, frame) => {
    for (let i = 0; i < sum.length; i++) sum[i] = sum[i]! + steps[sum.length * frame + i]!;
    return Float32Array.from(sum, (step) => step * size);
  });
}

/** The vertices with a displacement added, `scale` times. */
export function moved(body: Body, displacement: Float32Array, scale: number): Float32Array {
  return body.mesh.positions.map((value, i) => value + scale * displacement[i]!);
}

/** The length of the displacement of each vertex, times `factor`. */
export function lengthsOf(displacement: Float32Array, factor = 1): Float32Array {
  return Float32Array.from({ length: displacement.length / 3 }, (_, i) => factor * Math.hypot(displacement[3 * i]!, displacement[3 * i + 1]!, displacement[3 * i + 2]!));
}

function mostOf(values: Float32Array): number {
  return values.reduce((most, value) => Math.max(most, value), 0);
}

/** The frame of a motion in which some vertex is farthest from rest. */
export function largestFrame(body: Body): number {
  const sizes = body.frames.map((frame) => mostOf(lengthsOf(frame)));
  return sizes.indexOf(Math.max(...sizes));
}

/** The largest displacement of any frame or load of these bodies: what the ends of a scale that all share stand for. */
export function displacementRange(bodies: readonly Body[]): [number, number] {
  let most = 0;
  for (const body of bodies)
    for (const field of [...body.frames, ...(body.displacement ? [body.displacement] : [])]) most = Math.max(most, mostOf(lengthsOf(field, body.factor)));
  return [0, most || 1];
}

/** One range of a figure for all bodies that have it, so that their colours can be compared. */
export function sharedRange(bodies: readonly Body[], title: string): [number, number] {
  let [low, high] = [Infinity, -Infinity];
  for (const body of bodies) {
    const range = body.fields.get(title)?.range;
    if (!range) continue;
    low = Math.min(low, range[0]);
    high = Math.max(high, range[1]);
  }
  return low < high ? [low, high] : [0, 1];
}

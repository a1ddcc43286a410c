// The data that the page was written with.
export interface AxisData {
  key: string;
  title: string;
  unit: string;
  log: boolean;
  factor: number;
}

export interface MarkData {
  value: number;
  title: string;
  facet?: string;
}

export interface ChartData {
  kind: "ranges" | "points" | "lines" | "bars";
  title: string;
  x: AxisData;
  y: AxisData;
  series: string;
  facet: string;
  shown: AxisData[];
  marks: MarkData[];
  rows: number;
  columns: Record<string, (string | number | boolean | null)[]>;
}

/** A figure in 255 levels; compressed, in base64. */
export interface FieldData {
  title: string;
  unit: string;
  on: "vertex" | "tet";
  low: number;
  high: number;
  scale: "viridis" | "cividis" | "difference";
  data: string;
}

export interface MeshData {
  vertices: number;
  tets: number;
  positions: { type: "f32"; data: string };
  indices: { type: "u16" | "u32"; data: string };
}

export interface BodyData {
  title: string;
  group: string;
  unit: string;
  note: string;
  /** The case that rows of charts name, if it is an answer. */
  case?: string;
  /** The place of its mesh. */
  mesh: number;
  fields: FieldData[];
  displacement?: { type: "f32"; data: string };
  motion?: { times_s: number[]; most: number; levels: number; of: number; data: string };
}

export interface BodiesData {
  meshes: MeshData[];
  bodies: BodyData[];
}

/** What a chart tells the bodies when a reader wants to see one; its detail is the case. */
export const SHOW_CASE = "palpate:show-case";

export interface RunData {
  plan: string;
  /** What repeats the run. */
  command: string;
  /** The cases whose bodies are shown in 3D. */
  shown_cases: string[];
}

/** A JSON block of the page. Throws: Error, in words for a reader, where it is missing or broken. */
export function readBlock<T>(id: string): T {
  const text = document.getElementById(id)?.textContent;
  if (text === null || text === undefined) throw new Error(`the page has no data "${id}"`);
  try {
    return JSON.parse(text) as T;
  } catch {
    throw new Error(`the page's data "${id}" is broken`);
  }
}

/** The bytes of a compressed block. Throws: Error where it is broken. */
export async function unpack(data: string): Promise<ArrayBuffer> {
  try {
    const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return await new Response(stream).arrayBuffer();
  } catch {
    throw new Error("compressed data is broken");
  }
}

/** A field's figures as numbers; NaN where it is not known. */
export async function unpackField(field: FieldData): Promise<Float32Array> {
  const levels = new Uint8Array(await unpack(field.data));
  const step = (field.high - field.low) / 254;
  return Float32Array.from(levels, (level) => (level === 255 ? NaN : field.low + level * step));
}

/** Puts a message where something could not be shown, so that nobody looks at a blank place. */
export function showFault(place: Element, what: string, error: unknown): void {
  const note = document.createElement("p");
  note.className = "fault";
  note.setAttribute("role", "alert");
  note.textContent = `${what}: ${error instanceof Error ? error.message : String(error)}.`;
  place.replaceChildren(note);
}

// Figures at vertices or tetrahedra as colours. The scales hold for the colour-blind and keep their order in grey print.
import { interpolateCividis, interpolateViridis } from "d3-scale-chromatic";

export type ScaleName = "viridis" | "cividis" | "difference";

/** A figure at each vertex or at each tetrahedron. */
export interface Scalars {
  values: Float32Array;
  on: "vertex" | "tet";
  /** What it is, for the legend. */
  name: string;
  /** Empty for a pure number. */
  unit: string;
  /** What the ends of the scale stand for; least and greatest value if it is not given. */
  range?: [number, number];
  scale?: ScaleName;
}

export const STEPS = 256;

// Blue over grey-white to orange: ends of Okabe and Ito, of equal lightness.
function interpolateDifference(share: number): string {
  const [end, t] = share < 0.5 ? [[0, 90, 160], 1 - 2 * share] : [[200, 85, 0], 2 * share - 1];
  const middle = 238;
  return `rgb(${(end as number[]).map((channel) => Math.round(middle + (channel - middle) * t)).join(", ")})`;
}

const SCALES: Record<ScaleName, (share: number) => string> = {
  viridis: interpolateViridis,
  cividis: interpolateCividis,
  difference: interpolateDifference,
};

/** A colour of the scale at `share` in [0, 1], as red, green, blue in 0..255. */
export function colourAt(scale: ScaleName, share: number): [number, number, number] {
  const text = SCALES[scale](Math.min(1, Math.max(0, share)));
  if (text.startsWith("#")) {
    const bits = parseInt(text.slice(1), 16);
    return [(bits >> 16) & 255, (bits >> 8) & 255, bits & 255];
  }
  const [r, g, b] = (text.match(/[\d.]+/g) ?? ["0", "0", "0"]).map(Number);
  return [r!, g!, b!];
}

/** The whole scale, red, green, blue, alpha of STEPS colours. */
export function colourTable(scale: ScaleName): Uint8Array {
  const table = new Uint8Array(4 * STEPS);
  for (let i = 0; i < STEPS; i++) table.set([...colourAt(scale, i / (STEPS - 1)), 255], 4 * i);
  return table;
}

/** Least and greatest finite value; [0, 1] where there is none, a little room where they are the same. */
export function rangeOf(values: Float32Array): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (!Number.isFinite(value)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (low > high) return [0, 1];
  return low === high ? [low, low + (Math.abs(low) || 1)] : [low, high];
}

/** A number in at most three digits and, where it is very large or small, a power of ten. */
export function shortNumber(value: number): string {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e4 || size < 1e-3 ? value.toExponential(2).replace("e+", "e") : String(Number(value.toPrecision(3)));
}

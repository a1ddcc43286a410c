// What the page says of the body: times, force, energy, the margin of the step, where it broke.
import type { FromWorker, LiveNumbers, Vector } from "./protocol";

export type Configured = Extract<FromWorker, { type: "configured" }>;

/** Three digits and a unit that fits. */
export function withUnit(value: number, unit: string): string {
  if (!Number.isFinite(value)) return "\u2013";
  if (Math.abs(value) < 1e-9) return value === 0 ? `0\u00a0${unit}` : `below 1\u00a0n${unit}`;
  const prefixes: [number, string][] = [[1, ""], [1e-3, "m"], [1e-6, "\u00b5"], [1e-9, "n"]];
  const [scale, prefix] = prefixes.find(([size]) => Math.abs(value) >= size) ?? [1e-9, "n"];
  const shown = value / scale;
  return `${Math.abs(shown) >= 1000 ? Math.round(shown) : Number(shown.toPrecision(3))}\u00a0${prefix}${unit}`;
}

const ROWS: Record<string, string> = {
  state: "Body",
  finger: "Finger moved",
  force: "Finger's force",
  difference: "Differs from finite elements",
  stepTime: "A step takes",
  realTime: "Real-time factor",
  margin: "Step of the stable bound",
  energy: "Energy, moving and strained",
  engine: "Engine",
};

/** A list of terms and figures; the state is told to screen readers as it changes. */
export class Readouts {
  readonly list = document.createElement("dl");
  readonly status = document.createElement("p");
  private readonly cells = new Map<string, HTMLElement>();

  constructor() {
    this.list.className = "live-readouts";
    this.status.className = "live-said";
    this.status.setAttribute("role", "status");
    for (const [key, title] of Object.entries(ROWS)) {
      const term = Object.assign(document.createElement("dt"), { textContent: title });
      const cell = Object.assign(document.createElement("dd"), { textContent: "\u2013" });
      cell.dataset["readout"] = key;
      this.cells.set(key, cell);
      const figure = document.createElement("div");
      figure.append(term, cell);
      this.list.append(figure);
    }
  }

  /** `value` is for programs that read the page. */
  private say(key: string, text: string, value?: number): void {
    const cell = this.cells.get(key)!;
    if (cell.textContent !== text) cell.textContent = text;
    if (value !== undefined) cell.dataset["value"] = String(value);
  }

  showConfigured(told: Configured): void {
    const { stepS, stableS } = told;
    const isBound = Number.isFinite(stableS);
    this.say("margin", isBound ? `${withUnit(stepS, "s")} of ${withUnit(stableS, "s")}: ${Math.round((100 * stepS) / stableS)}%` : `${withUnit(stepS, "s")}, without a bound`, isBound ? stepS / stableS : 0);
    this.cells.get("margin")!.classList.toggle("live-bad", isBound && stepS > stableS);
    const names: Record<string, string> = { springs: "springs, single precision", tets: "tetrahedra, single precision", table: "table, at rest under the finger" };
    this.say("engine", names[told.engine] ?? `general, double precision (has ${told.whyGeneral})`);
  }

  showNumbers(numbers: LiveNumbers): void {
    this.say("stepTime", `${withUnit(numbers.stepUs * 1e-6, "s")}; ${Math.round(numbers.stepsPerS).toLocaleString("en")} a second`, numbers.stepUs);
    this.cells.get("stepTime")!.dataset["rate"] = String(numbers.stepsPerS);
    this.say("realTime", numbers.stepsPerS > 0 ? numbers.realTime.toFixed(2) : "\u2013", numbers.realTime);
    this.say("energy", `${withUnit(numbers.kineticJ, "J")}, ${withUnit(numbers.elasticJ, "J")}`, numbers.kineticJ);
    this.cells.get("energy")!.dataset["elastic"] = String(numbers.elasticJ);
    const cell = this.cells.get("state")!;
    cell.classList.toggle("live-bad", numbers.isBroken || numbers.inverted > 0);
    if (numbers.isBroken) this.say("state", `broke at vertex ${numbers.vertex}, after ${withUnit(numbers.simulatedS, "s")}`, 1);
    else if (numbers.inverted > 0) this.say("state", `${numbers.inverted} tetrahedra inside out, first at vertex ${numbers.vertex}`, 0.5);
    else this.say("state", "whole", 0);
    const state = `Body: ${cell.textContent}`;
    if (this.status.textContent !== state) this.status.textContent = state;
    if (!numbers.isBroken && Number.isFinite(numbers.largestM)) cell.dataset["largest"] = String(numbers.largestM);
  }

  /** `outwards`: how much of its way is out of the body, in m; nothing without a finger. */
  showFinger(by: Vector, outwards: number | null, force: Vector, elementForce: Vector | null): void {
    const way = Math.hypot(...by);
    const side = outwards === null || Math.abs(outwards) < 1e-6 ? "" : outwards > 0 ? ", pulling" : ", pressing";
    this.say("finger", outwards === null && way === 0 ? "\u2013" : withUnit(way, "m") + side, way);
    this.cells.get("finger")!.dataset["out"] = String(outwards ?? 0);
    const own = Math.hypot(...force);
    this.say("force", withUnit(own, "N") + (elementForce ? `; finite elements ${withUnit(Math.hypot(...elementForce), "N")}` : ""), own);
  }

  showDifference(relative: number | null): void {
    this.say("difference", relative === null ? "\u2013" : `${(100 * relative).toFixed(1)}% of their displacement, over the skin`, relative ?? -1);
  }
}

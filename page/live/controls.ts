// The controls of the page: what moves the body, how it is pressed, and what is seen of it.
import type { BodyDescription, LiveConfig, ModelKind, Pace, StrainLaw } from "./protocol";

/** What a reader can change. */
export interface Wishes {
  config: LiveConfig;
  depthM: number;
  radiusM: number;
  /** Dragged, the finger slides over the skin; else it takes along what it holds. */
  slides: boolean;
  pace: Pace;
  isBeside: boolean;
  coloursError: boolean;
}

export interface ControlEvents {
  configured(wishes: Wishes): void;
  changed(wishes: Wishes): void;
  pressed(direction: 1 | -1): void;
  released(): void;
  reset(): void;
}

const SMOOTHED: Record<string, { title: string; theta: number; domain: string; rest: string }> = {
  edge_node: { title: "nodes and edges", theta: 0, domain: "node", rest: "edge" },
  blend: { title: "nodes and tets: blend", theta: 0.7, domain: "node", rest: "tet" },
  tets: { title: "nothing: linear tets", theta: 1, domain: "tet", rest: "tet" },
};
const VOLUMES: Record<string, string> = {
  none: "none",
  thesis: "the thesis's force",
  tet: "tets, each",
  node_average: "averaged at nodes",
  node_smoothed: "smoothed at nodes",
};
const INTEGRATORS: Record<string, string> = {
  symplectic_euler: "symplectic Euler",
  explicit_euler: "explicit Euler",
  velocity_verlet: "velocity Verlet",
  runge_kutta_4: "Runge-Kutta 4",
  implicit_euler: "implicit Euler",
  backward_euler: "backward Euler",
  bdf2: "BDF2",
  trapezoidal: "trapezoidal",
  prefactored: "projective",
  xpbd: "XPBD",
  vbd: "vertex block descent",
};
const PACES: Record<string, string> = { "1": "real time", "0.1": "a tenth of it", "0": "as fast as it goes" };

/** What is changed by another engine: the others act on the one that runs. */
const REBUILDING = ["model", "smoothing", "volume", "law", "level", "integrator", "step", "damping"];

function element<K extends keyof HTMLElementTagNameMap>(tag: K, properties: Partial<HTMLElementTagNameMap[K]> = {}, children: (Node | string)[] = []): HTMLElementTagNameMap[K] {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/** The panel; tells `events` what was changed. */
export class Controls {
  readonly panel = element("form", { className: "live-controls" });
  private readonly fields = new Map<string, HTMLInputElement | HTMLSelectElement>();
  private readonly rows = new Map<string, HTMLElement>();
  private readonly atFirst = new Map<string, string>();
  private readonly startButton: HTMLButtonElement;

  constructor(private readonly body: BodyDescription, private readonly events: ControlEvents) {
    const { start } = body;
    const models: Record<string, string> = { springs: "springs", smoothed: "smoothed elements", ...(body.table ? { reduced: "reduced: a table" } : {}) };
    this.panel.addEventListener("submit", (event) => event.preventDefault());
    this.group("Model");
    this.select("model", "Model", models, start.model in models ? start.model : "springs");
    const custom = start.model === "smoothed" && !this.namedSmoothing();
    this.select("smoothing", "Strain averaged over", { ...Object.fromEntries(Object.entries(SMOOTHED).map(([key, { title }]) => [key, title])), ...(custom ? { own: "as in the scene" } : {}) },
      start.model === "smoothed" ? (this.namedSmoothing() ?? "own") : "edge_node");
    this.select("volume", "Volume model", VOLUMES, start.volume ?? "none");
    this.select("law", "Strain", { corotated: "large, corotated", neo_hookean: "large, neo-Hookean", stable_neo_hookean: "large, stable neo-Hookean", linear: "small, linear" }, start.law);
    this.select("level", "Mesh", Object.fromEntries(body.levels.map((level, k) => [String(k), levelTitle(level.removed_ratio, level.points.count / 3)])), "0");
    this.startButton = this.button({ fit: "As palpate fit chose it", scene: "As in the scene", mesh: "As at first" }[body.kind] ?? "As at first", "Model, mesh, integrator, step and damping as the page began", () => this.startAgain());
    this.box.append(element("div", { className: "live-buttons" }, [this.startButton]));
    this.group("Time");
    this.select("integrator", "Integrator", INTEGRATORS, start.integrator);
    this.number("step", "Step, ms", start.step_s ? String(1000 * start.step_s) : "", "0.9 of the bound", 1e-4, 1000, "any");
    this.number("damping", "Damping, 1/s", String(body.damping_mass_per_s), "", 0, 1e4, "any");
    this.select("pace", "Pace", PACES, "1");
    this.group("Finger");
    this.number("depth", "Depth, mm", shortMm(0.4 * body.pad_radius_m), "", 0.01, 1000, "any");
    this.number("radius", "Radius, mm", shortMm(body.pad_radius_m), "", 0.01, 1000, "any");
    this.select("drag", "Dragged, it", { hold: "takes the skin along", slide: "slides over the skin" }, "hold");
    this.buttons();
    this.group("Beside it");
    this.check("beside", "Finite elements", body.table !== null, body.table === null);
    this.check("error", "Colour by the difference", body.table !== null, body.table === null);
    if (!body.table) this.panel.append(element("p", { className: "live-missing", textContent: `No finite elements beside it: ${body.no_table}.` }));
    for (const name of REBUILDING) this.atFirst.set(name, this.value(name));
    this.showFitting();
  }

  get wishes(): Wishes {
    const model = this.value("model") as ModelKind;
    const { start } = this.body;
    const own = this.value("smoothing") === "own" || model !== "smoothed";
    const smoothing = SMOOTHED[this.value("smoothing")];
    const theta = model === "springs" ? (start.model === "springs" && start.theta !== undefined ? start.theta : 0.6) : own ? (start.theta ?? 0) : smoothing!.theta;
    return {
      config: {
        level: Number(this.value("level")), model, volume: this.value("volume"), shear: start.shear ?? "node", theta,
        domain: own ? (start.domain ?? "node") : smoothing!.domain, rest: own ? (start.rest ?? "edge") : smoothing!.rest,
        stabilise: own && model === "smoothed" ? (start.stabilise ?? 0) : 0, law: this.value("law") as StrainLaw,
        integrator: this.value("integrator"), dampingPerS: this.positive("damping", 0), stepS: this.value("step") === "" ? null : this.positive("step", 0) / 1000,
      },
      depthM: this.positive("depth", 1) / 1000,
      radiusM: this.positive("radius", 1) / 1000,
      slides: this.value("drag") === "slide",
      pace: Number(this.value("pace")),
      isBeside: this.isChecked("beside"),
      coloursError: this.isChecked("error"),
    };
  }

  private namedSmoothing(): string | undefined {
    const { start } = this.body;
    return Object.keys(SMOOTHED).find((key) => {
      const { theta, domain, rest } = SMOOTHED[key]!;
      return theta === start.theta && domain === start.domain && rest === start.rest && (start.stabilise ?? 0) === 0;
    });
  }

  private value(name: string): string {
    return this.fields.get(name)?.value ?? "";
  }

  private isChecked(name: string): boolean {
    const field = this.fields.get(name);
    return field instanceof HTMLInputElement && field.checked;
  }

  private positive(name: string, otherwise: number): number {
    const value = Number(this.value(name));
    return Number.isFinite(value) && value >= 0 ? value : otherwise;
  }

  private box: HTMLElement = this.panel;
  private group(title: string): void {
    this.box = element("fieldset", {}, [element("legend", { textContent: title })]);
    this.panel.append(this.box);
  }

  private row(name: string, title: string, field: HTMLInputElement | HTMLSelectElement): void {
    field.id = `live-${name}`;
    this.fields.set(name, field);
    const label = element("label", { htmlFor: field.id, textContent: title });
    const row = element("div", { className: "live-row" }, [label, field]);
    this.rows.set(name, row);
    this.box.append(row);
    field.addEventListener("change", () => this.tell(name));
  }

  private select(name: string, title: string, options: Record<string, string>, chosen: string): void {
    const field = element("select", {}, Object.entries(options).map(([value, text]) => element("option", { value, textContent: text })));
    field.value = chosen in options ? chosen : Object.keys(options)[0]!;
    this.row(name, title, field);
  }

  private number(name: string, title: string, value: string, placeholder: string, min: number, max: number, step: string): void {
    this.row(name, title, element("input", { type: "number", value, placeholder, min: String(min), max: String(max), step }));
  }

  private check(name: string, title: string, checked: boolean, disabled: boolean): void {
    this.row(name, title, element("input", { type: "checkbox", checked, disabled }));
  }

  private button(textContent: string, title: string, act: () => void): HTMLButtonElement {
    const made = element("button", { type: "button", textContent, title });
    made.addEventListener("click", act);
    return made;
  }

  private buttons(): void {
    this.box.append(element("div", { className: "live-buttons" }, [
      this.button("Press", "Key P: press in the middle of the picture, or where it was pressed last", () => this.events.pressed(1)),
      this.button("Pull", "Key O: pull there", () => this.events.pressed(-1)),
      this.button("Let go", "Key R", () => this.events.released()),
      this.button("Reset", "Key X: back to rest", () => this.events.reset()),
    ]));
  }

  /** Back to the model and the time that the page began with: those of the fit or the scene. */
  private startAgain(): void {
    for (const [name, value] of this.atFirst) this.fields.get(name)!.value = value;
    this.tell("model");
  }

  private tell(name: string): void {
    this.showFitting();
    if (REBUILDING.includes(name)) this.events.configured(this.wishes);
    else this.events.changed(this.wishes);
  }

  /** Hides what the chosen model has not. */
  private showFitting(): void {
    const model = this.value("model");
    const isShown: Record<string, boolean> = {
      smoothing: model === "smoothed", volume: model === "springs", integrator: model !== "reduced", step: model !== "reduced", damping: model !== "reduced",
      law: model === "smoothed" || (model === "springs" && this.value("volume") !== "none"), level: model !== "reduced",
    };
    for (const [name, shown] of Object.entries(isShown)) this.rows.get(name)!.hidden = !shown;
    this.startButton.disabled = [...this.atFirst].every(([name, value]) => this.value(name) === value);
  }
}

function levelTitle(ratio: number, vertices: number): string {
  const count = vertices.toLocaleString("en");
  return ratio === 0 ? `${count} vertices: whole` : `${count} vertices: ${Math.round(100 * ratio)}% less`;
}

function shortMm(metres: number): string {
  return String(Number((1000 * metres).toPrecision(2)));
}

// What the page and the engine's worker say to each other.

/** Where an array of the body's bytes is. */
export interface ArrayPlace {
  type: "f64" | "f32" | "u32";
  at: number;
  count: number;
}

export interface LevelPlaces {
  removed_ratio: number;
  points: ArrayPlace;
  tets: ArrayPlace;
  spring_ends: ArrayPlace;
  spring_rest_m: ArrayPlace;
  spring_n_per_m: ArrayPlace;
  /** Each vertex's number in the mesh that the page was made of; empty where it is simplified. */
  given_number: ArrayPlace;
  supports: { faces: ArrayPlace; weights: ArrayPlace; stiffness_pa_per_m: number }[];
  held: { faces: ArrayPlace; axes: number }[];
}

export interface StartModel {
  model: ModelKind;
  method?: string;
  volume?: string;
  theta?: number;
  shear?: string;
  domain?: string;
  rest?: string;
  stabilise?: number;
  law: StrainLaw;
  integrator: string;
  step_s?: number;
}

/** Of strain energies; `linear` is that of small strain, with linear springs. */
export type StrainLaw = "linear" | "corotated" | "neo_hookean" | "stable_neo_hookean";

/** `palpate/live/1`: the body of a page. */
export interface BodyDescription {
  schema: string;
  title: string;
  kind: "mesh" | "scene" | "fit";
  young_modulus_pa: number;
  poisson_ratio: number;
  density_kg_m3: number;
  damping_stiffness_s: number;
  damping_mass_per_s: number;
  pad_radius_m: number;
  pad_pa_per_m: number;
  start: StartModel;
  spring_source: { method: string };
  notes: string[];
  levels: LevelPlaces[];
  table: { vertices: ArrayPlace; skin: ArrayPlace; field: ArrayPlace } | null;
  no_table: string;
}

export type ModelKind = "springs" | "smoothed" | "reduced";

/** What moves the body, and how. */
export interface LiveConfig {
  level: number;
  model: ModelKind;
  volume: string;
  shear: string;
  theta: number;
  domain: string;
  rest: string;
  stabilise: number;
  law: StrainLaw;
  integrator: string;
  dampingPerS: number;
  /** Nothing: `SAFETY` of the predicted bound. */
  stepS: number | null;
}

/** Of the bound at rest, as `simulate` takes it. */
export const SAFETY = 0.9;

/** Simulated seconds a second of the wall; 0: as many as it can. */
export type Pace = number;

export type ToWorker =
  | { type: "load"; description: BodyDescription; bytes: ArrayBuffer }
  | { type: "configure"; config: LiveConfig }
  | { type: "press"; vertex: number; radiusM: number; by: Vector; speedMS: number }
  | { type: "slide"; vertex: number; radiusM: number; by: Vector; speedMS: number }
  | { type: "aim"; by: Vector; speedMS: number }
  | { type: "release" }
  | { type: "reset" }
  | { type: "pace"; pace: Pace }
  | { type: "beside"; on: boolean }
  | { type: "frame"; displacement: Float32Array; answer: Float32Array };

export type Vector = [number, number, number];

/** The body in numbers, some ten times a second. */
export interface LiveNumbers {
  simulatedS: number;
  kineticJ: number;
  elasticJ: number;
  loadJ: number;
  forceN: Vector;
  largestM: number;
  inverted: number;
  isBroken: boolean;
  /** The vertex where it broke, or of the first inverted tetrahedron. */
  vertex: number | null;
  stepUs: number;
  stepsPerS: number;
  realTime: number;
}

export type FromWorker =
  | { type: "loaded" }
  | { type: "configured"; config: LiveConfig; engine: string; whyGeneral: string; stableS: number; limitingVertex: number | null; stepS: number }
  | { type: "pressed"; vertex: number | null; answerProblem: string }
  | { type: "frame"; displacement: Float32Array; answer: Float32Array; hasAnswer: boolean; answerForceN: Vector; padBy: Vector; numbers: LiveNumbers | null }
  | { type: "problem"; message: string };

// The engine behind its C interface (live/interface/live_interface.h), compiled to WebAssembly.
import { f32, f64, u32 } from "./body_data";
import type { ArrayPlace, BodyDescription, LiveConfig, Vector } from "./protocol";

/** What emscripten makes of the interface. */
export interface EngineModule {
  HEAPU8: Uint8Array;
  ccall(name: string, returns: "number" | "string", types: ("number" | "string")[], values: (number | string)[]): number | string;
  _malloc(bytes: number): number;
  _free(at: number): void;
}

const REPORT = 14;

/** One body and its answer. Every member throws an Error with the engine's message. */
export class LiveEngine {
  private readonly scratch: number;
  private fields = 0;
  private fieldBytes = 0;

  constructor(private readonly module: EngineModule) {
    this.scratch = module._malloc(8 * 32);
  }

  private call(name: string, ...values: (number | string)[]): void {
    const types = values.map((value) => (typeof value === "string" ? "string" : "number"));
    if (this.module.ccall(name, "number", types, values) !== 0) throw new Error(this.module.ccall("live_message", "string", [], []) as string);
  }

  private word(name: string): string {
    return this.module.ccall(name, "string", [], []) as string;
  }

  /** Calls `use` with the addresses of copies of the arrays. */
  private withArrays(arrays: (Float64Array | Float32Array | Uint32Array)[], use: (...at: number[]) => void): void {
    const places = arrays.map((array) => {
      const at = this.module._malloc(Math.max(8, array.byteLength));
      this.module.HEAPU8.set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength), at);
      return at;
    });
    try {
      use(...places);
    } finally {
      for (const at of places) this.module._free(at);
    }
  }

  private doubles(count: number): Float64Array {
    return new Float64Array(this.module.HEAPU8.buffer, this.scratch, count);
  }

  /** The mesh of a level with what holds it; the body is made by `build`. */
  setUp(body: BodyDescription, bytes: ArrayBuffer, levelNumber: number, dampingPerS: number): void {
    const level = body.levels[levelNumber];
    if (!level) throw new Error(`there is no level ${levelNumber}`);
    const tets = u32(bytes, level.tets);
    this.withArrays([f64(bytes, level.points), tets], (points, tetAt) =>
      this.call("live_setup", level.points.count / 3, points, tets.length / 4, tetAt, body.young_modulus_pa, body.poisson_ratio, body.density_kg_m3,
        body.damping_stiffness_s, dampingPerS));
    const rest = f64(bytes, level.spring_rest_m);
    this.withArrays([u32(bytes, level.spring_ends), rest, f64(bytes, level.spring_n_per_m)], (ends, restAt, k) =>
      this.call("live_springs", rest.length, ends, restAt, k));
    for (const support of level.supports)
      this.withFaces(support.faces, bytes, [f64(bytes, support.weights)], (count, faces, weights) =>
        this.call("live_support", count, faces, weights!, support.stiffness_pa_per_m));
    for (const held of level.held) this.withFaces(held.faces, bytes, [], (count, faces) => this.call("live_held", count, faces, held.axes));
  }

  private withFaces(place: ArrayPlace, bytes: ArrayBuffer, others: Float64Array[], use: (count: number, faces: number, other: number | undefined) => void): void {
    const faces = u32(bytes, place);
    this.withArrays([faces, ...others], (at, other) => use(faces.length / 3, at!, other));
  }

  /** The table of the level that was set up last. */
  takeTable(body: BodyDescription, bytes: ArrayBuffer): void {
    const table = body.table;
    if (!table) throw new Error(body.no_table);
    const vertices = u32(bytes, table.vertices);
    this.withArrays([vertices, f32(bytes, table.skin), f32(bytes, table.field)], (at, skin, field) =>
      this.call("live_table", vertices.length, at, skin!, field!, 2, 0));
  }

  build(config: LiveConfig): void {
    // Springs alone turn with the body whatever the strain is: the fast engine takes them so.
    const isLarge = config.law !== "linear" || (config.model === "springs" && config.volume === "none") ? 1 : 0;
    const law = config.law === "linear" ? "corotated" : config.law;
    if (config.model === "smoothed")
      this.call("live_build_smoothed", config.theta, config.domain, config.rest, isLarge ? 0 : config.stabilise, isLarge, law, config.integrator);
    else this.call("live_build_springs", config.volume, config.theta, config.shear, isLarge, law, config.integrator);
  }

  get engine(): string {
    return this.word("live_engine");
  }

  get whyGeneral(): string {
    return this.word("live_why_general");
  }

  /** The bound on the step at rest, with such a pad anywhere; the vertex that sets it. */
  predictStep(padPaPerM: number): { stepS: number; vertex: number | null } {
    this.call("live_predict_step", padPaPerM, this.scratch, this.scratch + 8);
    const vertex = new Uint32Array(this.module.HEAPU8.buffer, this.scratch + 8, 1)[0]!;
    return { stepS: this.doubles(1)[0]!, vertex: vertex === 0xffffffff ? null : vertex };
  }

  press(vertex: number, radiusM: number, stiffnessPaPerM: number): void {
    this.call("live_press", vertex, radiusM, stiffnessPaPerM);
  }

  slide(vertex: number, radiusM: number, stiffnessPaPerM: number): void {
    this.call("live_slide", vertex, radiusM, stiffnessPaPerM);
  }

  aim(by: Vector, speedMS: number): void {
    this.call("live_aim", ...by, speedMS);
  }

  release(): void {
    this.call("live_release");
  }

  reset(): void {
    this.call("live_reset");
  }

  /** Whether the body is whole after so many steps. */
  step(stepS: number, steps: number): boolean {
    this.call("live_step", stepS, steps, this.scratch);
    return new Int32Array(this.module.HEAPU8.buffer, this.scratch, 1)[0] === 1;
  }

  /** The numbers of live_report. */
  report(): number[] {
    this.call("live_report", this.scratch);
    return Array.from(this.doubles(REPORT));
  }

  /** How far the pad is moved now. */
  padBy(): Vector {
    this.call("live_pad", this.scratch);
    const [x, y, z] = this.doubles(3);
    return [x!, y!, z!];
  }

  private field(numbers: number): number {
    if (this.fieldBytes < 4 * numbers) {
      this.module._free(this.fields);
      this.fieldBytes = 4 * numbers;
      this.fields = this.module._malloc(this.fieldBytes);
    }
    return this.fields;
  }

  /** Displacements of all vertices, in m. */
  displacement(into: Float32Array): void {
    const at = this.field(into.length);
    this.call("live_displacement", at);
    into.set(new Float32Array(this.module.HEAPU8.buffer, at, into.length));
  }

  answerPress(stiffnessPaPerM: number): void {
    this.call("live_answer_press", stiffnessPaPerM);
  }

  answerRelease(): void {
    this.call("live_answer_release");
  }

  /** The finite elements' displacements of the table's vertices, in m; returns their force on the body. */
  answer(by: Vector, into: Float32Array): Vector {
    const at = this.field(into.length);
    this.call("live_answer", ...by, at, this.scratch);
    into.set(new Float32Array(this.module.HEAPU8.buffer, at, into.length));
    const [x, y, z] = this.doubles(3);
    return [x!, y!, z!];
  }
}

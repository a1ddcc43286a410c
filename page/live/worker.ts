// Steps the body by its own timer, beside the page, and hands out its state when the page asks for a picture.
import { checkBody } from "./body_data";
import { LiveEngine, type EngineModule } from "./engine";
import { SAFETY, type BodyDescription, type FromWorker, type LiveConfig, type LiveNumbers, type Pace, type ToWorker, type Vector } from "./protocol";

declare const createPalpateLive: () => Promise<EngineModule>;

interface Scope {
  onmessage: ((event: MessageEvent<ToWorker>) => void) | null;
  postMessage(message: FromWorker, transfer?: Transferable[]): void;
}
const scope = self as unknown as Scope;

const TURN_MS = 6; // of stepping, before messages are looked at
const MOST_BEHIND_S = 0.05; // what is later than this is given up: the motion then runs slower than real time
const REPORT_MS = 100; // at least; a report walks the whole body for its energy, and has a small share of the time
const MOST_REPORT_SHARE = 0.04;
const REDUCED_TICK_S = 1e-3;

/** The body as it runs. */
class LiveLoop {
  private engine: LiveEngine | null = null;
  private body: BodyDescription | null = null;
  private bytes = new ArrayBuffer(0);
  private config: LiveConfig | null = null;
  private stepS = 0;
  private isWhole = true;
  private pace: Pace = 1;
  private isBeside = true;
  private hasTable = false;
  private isPressed = false;
  private hasAnswer = false;
  private aim: Vector = [0, 0, 0];
  private by: Vector = [0, 0, 0];
  private speedMS = 0.1;
  private lastMs = 0;
  private owedS = 0;
  private isWaiting = false;
  private readonly channel = new MessageChannel();
  // Since the last report.
  private stepMs = 0;
  private steps = 0;
  private simulatedS = 0;
  private sinceMs = 0;
  private reportMs = 0; // what the last one took

  constructor() {
    this.channel.port1.onmessage = () => this.turn();
  }

  async take(message: ToWorker): Promise<void> {
    switch (message.type) {
      case "load":
        return this.load(message.description, message.bytes);
      case "configure":
        return this.configure(message.config);
      case "press":
        return this.press(message.vertex, message.radiusM, message.by, message.speedMS);
      case "slide":
        if (!this.isPressed) return;
        this.ready().engine.slide(message.vertex, message.radiusM, this.ready().body.pad_pa_per_m);
        return this.feel(message.vertex, message.by, message.speedMS);
      case "aim":
        return this.aimAt(message.by, message.speedMS);
      case "release":
        return this.release();
      case "reset":
        return this.reset();
      case "pace":
        this.pace = message.pace;
        return this.startClock();
      case "beside":
        this.isBeside = message.on;
        return;
      case "frame":
        return this.frame(message.displacement, message.answer);
    }
  }

  private async load(description: BodyDescription, bytes: ArrayBuffer): Promise<void> {
    this.body = checkBody(description, bytes);
    this.bytes = bytes;
    this.engine = new LiveEngine(await createPalpateLive());
    if (this.body.table) {
      this.engine.setUp(this.body, bytes, 0, this.body.damping_mass_per_s);
      this.engine.takeTable(this.body, bytes);
      this.hasTable = true;
    }
    scope.postMessage({ type: "loaded" });
  }

  private configure(config: LiveConfig): void {
    const { engine, body } = this.ready();
    this.config = null;
    engine.setUp(body, this.bytes, config.level, config.dampingPerS);
    engine.build(config);
    this.hasAnswer = this.isPressed = false;
    this.isWhole = true;
    const stable = engine.predictStep(body.pad_pa_per_m);
    const stepS = config.model === "reduced" ? REDUCED_TICK_S : (config.stepS ?? (Number.isFinite(stable.stepS) ? SAFETY * stable.stepS : 1e-3));
    this.stepS = stepS;
    this.config = config;
    const isReduced = config.model === "reduced";
    scope.postMessage({
      type: "configured", config, stepS,
      engine: isReduced ? "table" : engine.engine,
      whyGeneral: isReduced ? "" : engine.whyGeneral,
      stableS: isReduced ? Infinity : stable.stepS,
      limitingVertex: isReduced ? null : stable.vertex,
    });
    this.startClock();
  }

  private press(vertex: number, radiusM: number, by: Vector, speedMS: number): void {
    const { engine, body } = this.ready();
    engine.press(vertex, radiusM, body.pad_pa_per_m);
    this.isPressed = true;
    this.by = [0, 0, 0];
    this.feel(vertex, by, speedMS);
    this.startClock();
  }

  /** The pad is on another part of the skin: so is that of the finite elements. */
  private feel(vertex: number, by: Vector, speedMS: number): void {
    const { engine, body } = this.ready();
    let answerProblem = this.hasTable ? "" : body.no_table;
    this.hasAnswer = false;
    if (this.hasTable && (this.isBeside || this.config?.model === "reduced")) {
      try {
        engine.answerPress(body.pad_pa_per_m);
        this.hasAnswer = true;
      } catch (error) {
        answerProblem = messageOf(error);
      }
    }
    scope.postMessage({ type: "pressed", vertex, answerProblem });
    this.aimAt(by, speedMS);
  }

  private aimAt(by: Vector, speedMS: number): void {
    if (!this.isPressed) return;
    this.aim = by;
    this.speedMS = speedMS;
    this.ready().engine.aim(by, speedMS);
  }

  private release(): void {
    const { engine } = this.ready();
    engine.release();
    if (this.hasAnswer) engine.answerRelease();
    this.isPressed = this.hasAnswer = false;
    this.by = this.aim = [0, 0, 0];
    scope.postMessage({ type: "pressed", vertex: null, answerProblem: "" });
  }

  private reset(): void {
    this.release();
    this.ready().engine.reset();
    this.isWhole = true;
    this.startClock();
  }

  private ready(): { engine: LiveEngine; body: BodyDescription } {
    if (!this.engine || !this.body) throw new Error("the engine is not loaded yet");
    return { engine: this.engine, body: this.body };
  }

  private startClock(): void {
    this.lastMs = performance.now();
    this.owedS = 0;
    this.wake(0);
  }

  private wake(ms: number): void {
    if (this.isWaiting) return;
    this.isWaiting = true;
    if (ms > 0) setTimeout(() => this.turn(), ms);
    else this.channel.port2.postMessage(0);
  }

  /** One turn: the steps that are due, as far as they fit into it. */
  private turn(): void {
    this.isWaiting = false;
    if (!this.config || !this.isWhole) return;
    const now = performance.now();
    this.owedS = this.pace > 0 ? Math.min(MOST_BEHIND_S, this.owedS + ((now - this.lastMs) / 1000) * this.pace) : Infinity;
    this.lastMs = now;
    try {
      this.takeSteps();
    } catch (error) {
      this.config = null;
      scope.postMessage({ type: "problem", message: messageOf(error) });
      return;
    }
    this.wake(this.owedS >= this.stepS ? 0 : 1);
  }

  private takeSteps(): void {
    const end = performance.now() + TURN_MS;
    let batch = 1;
    for (let began = performance.now(); this.isWhole && this.owedS >= this.stepS && began < end; ) {
      const steps = Math.min(batch, Math.max(1, Math.floor(this.owedS / this.stepS)));
      if (this.config!.model === "reduced") this.tick(steps);
      else this.isWhole = this.ready().engine.step(this.stepS, steps);
      const now = performance.now();
      this.stepMs += now - began;
      this.steps += steps;
      this.simulatedS += steps * this.stepS;
      this.owedS -= steps * this.stepS;
      if (now - began < 1) batch *= 2;
      began = now;
    }
  }

  /** Ticks of the table: the pad moves on, and the body answers at rest. */
  private tick(ticks: number): void {
    for (let k = 0; k < ticks; k++) {
      const way = this.aim.map((x, i) => x - this.by[i]!) as Vector;
      const left = Math.hypot(...way);
      const reach = this.speedMS * this.stepS;
      this.by = left <= reach ? [...this.aim] : (this.by.map((x, i) => x + (way[i]! * reach) / left) as Vector);
      if (this.hasAnswer) this.ready().engine.answer(this.by, this.answerField());
    }
  }

  private ownField = new Float32Array();
  private answerField(): Float32Array {
    const numbers = 3 * (this.body?.table?.vertices.count ?? 0);
    if (this.ownField.length !== numbers) this.ownField = new Float32Array(numbers);
    return this.ownField;
  }

  private frame(displacement: Float32Array, answer: Float32Array): void {
    const { engine } = this.ready();
    if (!this.config) return; // asked again once there is a body
    const isReduced = this.config.model === "reduced";
    const began = performance.now();
    const report = !isReduced && this.reportIsDue() ? engine.report() : null;
    if (report) this.reportMs = performance.now() - began;
    if (!isReduced) engine.displacement(displacement);
    else displacement.fill(0);
    if (!isReduced) this.by = engine.padBy();
    let force: Vector = [0, 0, 0];
    if (this.hasAnswer && answer.length > 0) force = engine.answer(this.by, answer);
    else answer.fill(0);
    const numbers = isReduced ? this.reducedNumbers(force) : report && this.numbersOf(report);
    scope.postMessage({ type: "frame", displacement, answer, hasAnswer: this.hasAnswer, answerForceN: force, padBy: this.by, numbers }, [displacement.buffer as ArrayBuffer, answer.buffer as ArrayBuffer]);
  }

  private reportIsDue(): boolean {
    return performance.now() - this.sinceMs >= Math.max(REPORT_MS, this.reportMs / MOST_REPORT_SHARE);
  }

  private rates(): Pick<LiveNumbers, "stepUs" | "stepsPerS" | "realTime"> {
    const now = performance.now();
    const wallS = Math.max(1e-3, (now - this.sinceMs) / 1000);
    const rates = { stepUs: this.steps > 0 ? (1000 * this.stepMs) / this.steps : 0, stepsPerS: this.steps / wallS, realTime: this.simulatedS / wallS };
    this.sinceMs = now;
    this.stepMs = this.steps = this.simulatedS = 0;
    return rates;
  }

  private numbersOf(report: number[]): LiveNumbers {
    const [time, kinetic, elastic, load, x, y, z, largest, inverted, broken, vertex] = report as [number, number, number, number, number, number, number, number, number, number, number];
    return {
      simulatedS: time, kineticJ: kinetic, elasticJ: elastic, loadJ: load, forceN: [x, y, z], largestM: largest, inverted,
      isBroken: broken === 1, vertex: vertex < 0 ? null : vertex, ...this.rates(),
    };
  }

  private reducedNumbers(force: Vector): LiveNumbers | null {
    if (!this.reportIsDue()) return null;
    const nothing = { simulatedS: NaN, kineticJ: 0, elasticJ: NaN, loadJ: NaN, largestM: NaN, inverted: 0, isBroken: false, vertex: null };
    return { ...nothing, forceN: force, ...this.rates() };
  }
}

function messageOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

const loop = new LiveLoop();
let last = Promise.resolve();
scope.onmessage = (event) => {
  last = last.then(() => loop.take(event.data)).catch((error) => scope.postMessage({ type: "problem", message: messageOf(error) }));
};

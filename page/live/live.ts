// The page: an organ under the finger, and beside it what finite elements say to the same finger.
import { linkCameras } from "../view/linked_cameras";
import { OrganView } from "../view/organ_view";
import { isDrawnBySoftware } from "../view/renderer";
import { checkBody, decodeBase64, f64, tableVertices, u32 } from "./body_data";
import { Controls, type Wishes } from "./controls";
import { Finger } from "./finger";
import type { BodyDescription, FromWorker, LiveNumbers, ToWorker, Vector } from "./protocol";
import { Readouts } from "./readouts";
import { compareSkins, matchVertices, roundUp } from "./skin_difference";

const FINGER_M_S = 0.25; // of simulated time
const SOFTWARE_PICTURE_MS = 40; // where the processor draws, pictures come no faster: it has steps to take
const LEAST_CHANGE = 1e-5; // of the body's radius: what no picture shows
const ERROR_SHARE = 0.2; // of the largest displacement: the end of the scale

function byId(id: string): string {
  const found = document.getElementById(id);
  if (!found) throw new Error(`its part ${id} is missing`);
  return found.textContent ?? "";
}

function add<K extends keyof HTMLElementTagNameMap>(parent: HTMLElement, tag: K, className: string, text = ""): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  made.className = className;
  made.textContent = text;
  parent.append(made);
  return made;
}

/** The views of one level, and the buffers that travel between page and worker. */
class Stage {
  readonly own: OrganView;
  readonly other: OrganView | null;
  private readonly rest: Float32Array;
  private readonly positions: Float32Array;
  private readonly otherPositions: Float32Array;
  private readonly distance: Float32Array;
  private readonly unlink: () => void;
  private readonly touch: HTMLElement;
  private readonly breach: HTMLElement;
  private scaleEnd = 0;
  private touched: number | null = null;
  private broken: number | null = null;

  /** `givenNumber`: of each vertex in the reader's own mesh, or empty. */
  constructor(box: HTMLElement, readonly vertices: Uint32Array | null, points: Float64Array, tets: Uint32Array, readonly givenNumber: Uint32Array, wishes: Wishes, title: string) {
    this.rest = Float32Array.from(points);
    this.positions = this.rest.slice();
    this.otherPositions = this.rest.slice();
    this.distance = new Float32Array(this.rest.length / 3);
    const view = (name: string, label: string) => {
      const frame = add(box, "section", "live-view");
      add(frame, "h2", "", label);
      return new OrganView(add(frame, "div", `organ-view live-${name}`), { positions: this.rest.slice(), tets }, { label, texture: name === "own" });
    };
    this.own = view("own", title);
    this.other = wishes.isBeside && vertices && wishes.config.model !== "reduced" ? view("other", "Finite elements, same finger") : null;
    this.unlink = this.other ? linkCameras([this.own, this.other]) : () => {};
    this.touch = add(this.own.container, "div", "live-mark live-touch");
    this.breach = add(this.own.container, "div", "live-mark");
    this.own.renderListeners.add(() => this.placeMarks());
    this.placeMarks();
  }

  dispose(): void {
    this.unlink();
    for (const view of [this.own, this.other]) {
      view?.dispose();
      view?.container.parentElement?.remove();
    }
  }

  get numbers(): number {
    return this.rest.length;
  }

  /** How much of a way of the finger is out of the body, along the skin's normal where it is. */
  outwards(by: Vector): number | null {
    if (this.touched === null) return null;
    const normal = this.own.restNormal(this.touched);
    return by[0] * normal[0] + by[1] * normal[1] + by[2] * normal[2];
  }

  /** Where a vertex is now. */
  placeOf(vertex: number): Vector {
    return [0, 1, 2].map((i) => this.positions[3 * vertex + i]!) as Vector;
  }

  /** Marks the vertex under the finger, and the one where the body broke. */
  mark(vertices: { touched?: number | null; broken?: number | null }): void {
    Object.assign(this, vertices);
    this.placeMarks();
  }

  private placeMarks(): void {
    for (const [mark, vertex] of [[this.touch, this.touched], [this.breach, this.broken]] as const) {
      mark.hidden = vertex === null;
      mark.dataset["vertex"] = String(vertex ?? "");
      if (vertex === null) continue;
      const at = this.own.clientPoint(this.placeOf(vertex));
      const box = this.own.container.getBoundingClientRect();
      mark.style.left = `${at.x - box.left}px`;
      mark.style.top = `${at.y - box.top}px`;
    }
  }

  /** Shows displacements; the answer's are of the table's vertices. Returns what they differ by. */
  show(displacement: Float32Array, answer: Float32Array, hasAnswer: boolean, wishes: Wishes): number | null {
    const isReduced = wishes.config.model === "reduced";
    // Of a body that breaks, the last picture that shows something stays.
    const bound = 2 * this.own.frame.radius;
    const isShowable = displacement.every((u) => Math.abs(u) < bound);
    const isMoved = isShowable && !isReduced && this.take(this.positions, displacement, null);
    const isAnswerMoved = this.vertices !== null && (isReduced || this.other !== null) && this.take(isReduced ? this.positions : this.otherPositions, answer, this.vertices);
    if (isMoved || (isReduced && isAnswerMoved)) this.own.setPositions(this.positions);
    if (isAnswerMoved) this.other?.setPositions(this.otherPositions);
    if (!isShowable || isReduced || !this.other) return null;
    return this.colour(displacement, answer, hasAnswer, wishes, isMoved || isAnswerMoved);
  }

  /** Puts moved vertices into `positions`; false where none has moved by what a picture would show. */
  private take(positions: Float32Array, displacement: Float32Array, vertices: Uint32Array | null): boolean {
    const least = LEAST_CHANGE * this.own.frame.radius;
    const place = (k: number) => (vertices ? 3 * vertices[(k / 3) | 0]! + (k % 3) : k);
    const isMoved = displacement.some((u, k) => Math.abs(this.rest[place(k)]! + u - positions[place(k)]!) > least);
    if (isMoved) displacement.forEach((u, k) => (positions[place(k)] = this.rest[place(k)]! + u));
    return isMoved;
  }

  private colour(displacement: Float32Array, answer: Float32Array, hasAnswer: boolean, wishes: Wishes, isMoved: boolean): number | null {
    const { largest, relative } = compareSkins(displacement, answer, this.vertices!, this.distance);
    if (!wishes.coloursError || !hasAnswer) { // nobody presses: there is nothing to differ from
      if (this.scaleEnd > 0) this.own.setScalars(null);
      this.scaleEnd = 0;
      return hasAnswer ? relative : null;
    }
    if (!isMoved && this.scaleEnd > 0) return relative;
    const millimetres = this.distance.map((x) => 1000 * x);
    const end = largest > 0 ? Math.max(0.01, roundUp(1000 * ERROR_SHARE * largest)) : this.scaleEnd || 0.1;
    if (end !== this.scaleEnd) this.own.setScalars({ values: millimetres, on: "vertex", name: "difference", unit: "mm", range: [0, end] });
    else this.own.updateScalarValues(millimetres);
    this.scaleEnd = end;
    return relative;
  }
}

class LivePage {
  private readonly box: HTMLElement;
  private readonly problem: HTMLElement;
  private readonly readouts = new Readouts();
  private readonly controls: Controls;
  private readonly worker: Worker;
  private stage: Stage | null = null;
  private finger: Finger | null = null;
  private wishes: Wishes;
  private force: Vector = [0, 0, 0];
  private lastVertex: number | null = null;
  private isConfigured = false;
  private isWaiting = false;
  private askedAt = 0;

  constructor(root: HTMLElement, private readonly body: BodyDescription, private readonly bytes: ArrayBuffer) {
    const head = add(root, "header", "live-head");
    add(head, "h1", "", body.title);
    const what = { mesh: "A mesh on supports that were found for it.", scene: "A scene; its loads give way to the finger.", fit: "As palpate fit chose it." }[body.kind];
    add(head, "p", "", `${what ?? ""} Press with the mouse; Shift pulls; turn it beside the organ or with the arrow keys.`);
    this.problem = add(root, "p", "live-problem");
    this.problem.setAttribute("role", "alert");
    this.box = add(root, "div", "live-stage");
    const figures = add(root, "section", "live-figures");
    figures.setAttribute("aria-label", "Figures");
    figures.append(this.readouts.list, this.readouts.status);
    const side = add(root, "aside", "live-side");
    side.setAttribute("aria-label", "Controls");
    this.controls = new Controls(body, {
      configured: (wishes) => this.configure(wishes),
      changed: (wishes) => this.change(wishes),
      pressed: (direction) => this.pressByKey(direction),
      released: () => this.release(),
      reset: () => this.send({ type: "reset" }),
    });
    side.append(this.controls.panel);
    if (body.notes.length > 0) {
      const notes = add(side, "ul", "live-notes");
      for (const note of body.notes) add(notes, "li", "", note);
    }
    this.wishes = this.controls.wishes;
    this.buildStage();
    this.worker = new Worker(URL.createObjectURL(new Blob([byId("live-engine")], { type: "text/javascript" })));
    this.worker.onmessage = (event: MessageEvent<FromWorker>) => this.take(event.data);
    this.worker.onerror = (event) => this.say(`The engine does not run: ${event.message || "the browser refuses it"}`);
    this.send({ type: "load", description: body, bytes }, []);
    document.addEventListener("keydown", (event) => this.key(event));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.colour());
    const frame = () => {
      this.askForFrame();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  private send(message: ToWorker, transfer: Transferable[] = []): void {
    this.worker.postMessage(message, transfer);
  }

  private say(problem: string): void {
    this.problem.textContent = problem;
  }

  private buildStage(): void {
    this.stage?.dispose();
    this.finger?.dispose();
    const level = this.body.levels[this.wishes.config.level]!;
    const points = f64(this.bytes, level.points);
    const whole = f64(this.bytes, this.body.levels[0]!.points);
    const vertices = this.body.table ? matchVertices(points, whole, tableVertices(this.body, this.bytes)) : null;
    const model = { springs: "Springs", smoothed: "Smoothed elements", reduced: "Table of compliances: at rest, small strain" }[this.wishes.config.model];
    this.stage = new Stage(this.box, vertices, points, u32(this.bytes, level.tets), u32(this.bytes, level.given_number), this.wishes, `${model}, ${(points.length / 3).toLocaleString("en")} vertices`);
    this.finger = new Finger(this.stage.own, () => this.wishes, { 
      press: (vertex, by) => this.press(vertex, by),
      move: (by) => this.send({ type: "aim", by, speedMS: FINGER_M_S }),
      slide: (vertex, by) => this.slide(vertex, by),
      release: () => this.release(),
    });
    this.colour();
    this.displacement = new Float32Array(this.stage.numbers);
    this.answer = new Float32Array(3 * (vertices?.length ?? 0));
  }

  private displacement: Float32Array | null = null;
  private answer: Float32Array | null = null;

  private colour(): void {
    const style = getComputedStyle(document.documentElement);
    const of = (name: string) => style.getPropertyValue(name).trim();
    for (const view of [this.stage?.own, this.stage?.other]) view?.setColours({ background: of("--paper"), edges: of("--soft") });
  }

  private configure(wishes: Wishes): void {
    this.say("");
    this.wishes = wishes;
    this.isConfigured = false;
    this.send({ type: "beside", on: wishes.isBeside });
    this.send({ type: "configure", config: wishes.config });
  }

  private change(wishes: Wishes): void {
    const rebuilt = wishes.isBeside !== this.wishes.isBeside;
    this.wishes = wishes;
    this.send({ type: "pace", pace: wishes.pace });
    this.send({ type: "beside", on: wishes.isBeside });
    if (rebuilt) this.buildStage();
  }

  private take(message: FromWorker): void {
    switch (message.type) {
      case "loaded":
        return this.configure(this.controls.wishes);
      case "configured":
        this.isConfigured = true;
        this.readouts.showConfigured(message);
        this.buildStage();
        return;
      case "pressed":
        this.stage?.mark({ touched: message.vertex });
        this.say(message.vertex !== null && message.answerProblem && this.wishes.isBeside ? `No finite elements beside it: ${message.answerProblem}` : "");
        return;
      case "frame":
        return this.showFrame(message);
      case "problem":
        this.say(`This does not work: ${message.message}`);
    }
  }

  private askForFrame(): void {
    if (!this.isConfigured || this.isWaiting || !this.displacement || !this.answer) return;
    const now = performance.now();
    if (isDrawnBySoftware() && now - this.askedAt < SOFTWARE_PICTURE_MS) return;
    this.askedAt = now;
    this.isWaiting = true;
    const [displacement, answer] = [this.displacement, this.answer];
    this.send({ type: "frame", displacement, answer }, [displacement.buffer as ArrayBuffer, answer.buffer as ArrayBuffer]);
  }

  private showFrame(frame: Extract<FromWorker, { type: "frame" }>): void {
    this.isWaiting = false;
    const { stage } = this;
    if (!stage || frame.displacement.length !== stage.numbers || frame.answer.length !== 3 * (stage.vertices?.length ?? 0)) return; // of another level
    this.displacement = frame.displacement;
    this.answer = frame.answer;
    if (frame.numbers) this.showNumbers(frame.numbers, stage);
    const difference = stage.show(frame.displacement, frame.answer, frame.hasAnswer, this.wishes);
    if (!frame.numbers) return;
    this.readouts.showFinger(frame.padBy, stage.outwards(frame.padBy), this.force, frame.hasAnswer && this.wishes.config.model !== "reduced" ? frame.answerForceN : null);
    this.readouts.showDifference(difference);
  }

  private showNumbers(numbers: LiveNumbers, stage: Stage): void {
    this.force = numbers.forceN;
    stage.mark({ broken: numbers.isBroken || numbers.inverted > 0 ? numbers.vertex : null });
    this.readouts.showNumbers({ ...numbers, vertex: numbers.vertex === null ? null : (stage.givenNumber[numbers.vertex] ?? numbers.vertex) });
  }

  private press(vertex: number, by: Vector): void {
    this.lastVertex = vertex;
    this.send({ type: "press", vertex, radiusM: this.wishes.radiusM, by, speedMS: FINGER_M_S });
  }

  private slide(vertex: number, by: Vector): void {
    this.lastVertex = vertex;
    this.send({ type: "slide", vertex, radiusM: this.wishes.radiusM, by, speedMS: FINGER_M_S });
  }

  private release(): void {
    this.send({ type: "release" });
  }

  /** In the middle of the picture, or where it was pressed last: along the normal there, inwards or outwards. */
  private pressByKey(direction: 1 | -1): void {
    const { stage } = this;
    if (!stage) return;
    const box = stage.own.canvas.getBoundingClientRect();
    const hit = stage.own.pick(box.left + box.width / 2, box.top + box.height / 2);
    const vertex = hit?.vertex ?? this.lastVertex;
    if (vertex === null) return this.say("Nothing is in the middle of the picture: turn the organ there.");
    const normal = hit?.normal ?? stage.own.frame.toEye;
    this.press(vertex, normal.map((x) => -direction * this.wishes.depthM * x) as Vector);
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement) return;
    const act = { p: () => this.pressByKey(1), o: () => this.pressByKey(-1), r: () => this.release(), x: () => this.send({ type: "reset" }) }[event.key];
    if (!act) return;
    act();
    event.preventDefault();
  }
}

/** Starts the page; what is wrong with it is said in its place. */
export function start(root: HTMLElement): void {
  try {
    const bytes = decodeBase64(byId("live-arrays"));
    let description: unknown;
    try {
      description = JSON.parse(byId("live-body"));
    } catch {
      throw new Error("its description is no JSON");
    }
    new LivePage(root, checkBody(description, bytes.buffer), bytes.buffer);
  } catch (error) {
    root.replaceChildren();
    const problem = add(root, "p", "live-problem", `This page cannot show its body: ${error instanceof Error ? error.message : String(error)}.`);
    problem.setAttribute("role", "alert");
  }
}

start(document.getElementById("live") ?? document.body);

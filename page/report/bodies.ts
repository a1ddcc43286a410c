// Bodies side by side in 3D: which ones, how they are shown and coloured, cut, played, and saved as pictures.
import { linkCameras } from "../view/linked_cameras";
import { OrganView, type ViewMode } from "../view/organ_view";
import { frameOf } from "../view/framing";
import { Playback } from "../view/playback";
import { DISPLACEMENT, displacementRange, largestFrame, lengthsOf, moved, sharedRange, unpackBody, unpackMesh, type Body } from "./body_data";
import { download } from "./charts";
import type { OrganMesh } from "../view/skin";
import { readBlock, SHOW_CASE, showFault, type BodiesData, type BodyData } from "./page_data";
import { isDark, onTheme, pageColour } from "./theme";

const MOST_VIEWS = 8; // a browser gives a page some sixteen
const FIRST_VIEWS = 3;
const MODES: Record<ViewMode, string> = { surface: "surface", edges: "surface and edges", wireframe: "wireframe", cut: "cut open" };

interface Shown {
  body: Body;
  view: OrganView;
}

/** Builds the part of the page that shows bodies, once a reader comes near it. */
export function enlivenBodies(place: HTMLElement): void {
  let stage: BodyStage | null = null;
  let started = false;
  const start = () => {
    if (started) return;
    started = true;
    observer.disconnect();
    try {
      stage = new BodyStage(place, readBlock<BodiesData>(place.dataset["bodies"]!));
      stage.open();
      // For those who draw figures from a page (figures/draw_figures.mjs).
      (window as unknown as { palpateStage: BodyStage }).palpateStage = stage;
    } catch (error) {
      showFault(place, "The meshes could not be shown", error);
    }
  };
  const observer = new IntersectionObserver((entries) => entries.some((entry) => entry.isIntersecting) && start(), { rootMargin: "400px" });
  observer.observe(place);
  document.addEventListener(SHOW_CASE, (event) => {
    start();
    stage?.showCase((event as CustomEvent<string>).detail);
  });
}

/** What a figure shows: which bodies of a group, how, at which time of a motion. */
export interface Scene {
  group: string;
  titles: string[];
  mode: ViewMode;
  colour: string;
  time_s?: number;
  /** Where the eye stands, seen from the body, and what is up; as at first if it is not given. */
  from?: { toEye: [number, number, number]; up: [number, number, number] };
}

class BodyStage {
  private readonly groups: string[];
  private readonly bar = document.createElement("div");
  private readonly choices = document.createElement("div");
  private readonly views = document.createElement("div");
  private readonly below = document.createElement("div");
  private readonly group = document.createElement("select");
  private readonly mode = document.createElement("select");
  private readonly colour = document.createElement("select");
  private readonly cut = slider("Cut", -1, 1, 0.02, 0);
  private readonly scale = slider("Deformation times", 0, 20, 0.5, 1);
  private readonly texture = Object.assign(document.createElement("input"), { type: "checkbox", checked: true });
  private readonly unpacked = new Map<BodyData, Promise<Body>>();
  private readonly unpackedMeshes = new Map<number, Promise<OrganMesh>>();
  private shown: Shown[] = [];
  private unlink: (() => void) | null = null;
  private playback: Playback | null = null;
  private frame = 0;
  private turn = 0;
  private chosenColour: string | null = null;

  constructor(private readonly place: HTMLElement, private readonly data: BodiesData) {
    this.groups = [...new Set(data.bodies.map((body) => body.group))];
    for (const name of this.groups) this.group.append(new Option(name, name));
    for (const [mode, title] of Object.entries(MODES)) this.mode.append(new Option(title, mode));
    this.bar.className = this.choices.className = "body-bar";
    this.views.className = "body-views";
    const reset = button("Look as at first", () => this.shown[0]?.view.resetCamera());
    const save = button("Save picture", () => this.save());
    this.bar.append(labelled("Mesh", this.group), labelled("Shown as", this.mode), labelled("Coloured by", this.colour), this.cut.label, this.scale.label,
      labelled("Texture", this.texture), reset, save);
    this.group.addEventListener("change", () => this.openGroup());
    this.mode.addEventListener("change", () => this.restyle());
    this.colour.addEventListener("change", () => {
      this.chosenColour = this.colour.value;
      this.restyle();
    });
    this.texture.addEventListener("change", () => this.restyle());
    this.cut.input.addEventListener("input", () => this.restyle());
    this.scale.input.addEventListener("input", () => this.reshape());
    onTheme(() => this.restyle());
  }

  open(): void {
    this.place.replaceChildren(this.bar, this.choices, this.views, this.below);
    this.openGroup();
  }

  /** Shows a scene, and gives its bodies as pictures of `width` pixels: data URIs, in the order of the titles. */
  async draw(scene: Scene, width: number): Promise<string[]> {
    this.group.value = scene.group;
    this.chosenColour = scene.colour;
    this.mode.value = scene.mode;
    const bodies = await Promise.all(this.own().filter((body) => scene.titles.includes(body.title)).map((data) => this.unpack(data)));
    if (bodies.some((body, number) => this.shown[number]?.body !== body) || bodies.length !== this.shown.length) {
      this.turn++;
      this.build(bodies);
    }
    this.mode.value = scene.mode;
    this.colour.value = scene.colour;
    const times = bodies.find((body) => body.frames.length > 1)?.data.motion?.times_s ?? [];
    if (scene.time_s !== undefined && times.length) {
      const distances = times.map((time) => Math.abs(time - scene.time_s!));
      this.playback?.goTo(distances.indexOf(Math.min(...distances)));
    }
    this.restyle();
    this.reshape();
    for (const { view } of this.shown) {
      view.resetCamera();
      if (scene.from) view.lookFrom(scene.from.toEye, scene.from.up);
    }
    return this.shown.map(({ view }) => view.picture(width).toDataURL("image/png"));
  }

  private own(): BodyData[] {
    return this.data.bodies.filter((body) => body.group === this.group.value);
  }

  /** Shows the body of a case beside what its group begins with, the input or the reference, and brings the reader there. */
  showCase(name: string): void {
    const body = this.data.bodies.find((each) => each.case === name);
    if (!body) return;
    this.group.value = body.group;
    const own = this.own();
    this.openGroup(new Set([own[0]!, body]));
    this.place.scrollIntoView({ block: "start" });
    this.group.focus({ preventScroll: true });
  }

  private openGroup(chosen?: Set<BodyData>): void {
    const own = this.own();
    this.choices.replaceChildren();
    own.forEach((body, number) => {
      const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: chosen ? chosen.has(body) : number < FIRST_VIEWS });
      box.addEventListener("change", () => void this.openViews());
      this.choices.append(labelled(body.title, box, true));
    });
    this.choices.hidden = own.length < 2;
    void this.openViews();
  }

  private async openViews(): Promise<void> {
    const turn = ++this.turn;
    const boxes = [...this.choices.querySelectorAll("input")];
    const wanted = this.own().filter((_, number) => boxes[number]?.checked).slice(0, MOST_VIEWS);
    try {
      const bodies = await Promise.all(wanted.map((data) => this.unpack(data)));
      if (turn === this.turn) this.build(bodies);
    } catch (error) {
      if (turn === this.turn) showFault(this.views, "The meshes could not be shown", error);
    }
  }

  private unpack(data: BodyData): Promise<Body> {
    let found = this.unpacked.get(data);
    if (!found) this.unpacked.set(data, (found = this.unpackMesh(data.mesh).then((mesh) => unpackBody(data, mesh))));
    return found;
  }

  private unpackMesh(place: number): Promise<OrganMesh> {
    const data = this.data.meshes[place];
    if (!data) return Promise.reject(new Error(`the page has no mesh ${place}`));
    let found = this.unpackedMeshes.get(place);
    if (!found) this.unpackedMeshes.set(place, (found = unpackMesh(data)));
    return found;
  }

  private build(bodies: Body[]): void {
    this.close();
    const frame = bodies[0] ? frameOf(bodies[0].mesh.positions) : undefined;
    for (const body of bodies) {
      const figure = document.createElement("figure");
      const caption = document.createElement("figcaption");
      caption.append(Object.assign(document.createElement("strong"), { textContent: body.data.title }),
        ` ${(body.mesh.positions.length / 3).toLocaleString("en")} vertices, ${(body.mesh.tets.length / 4).toLocaleString("en")} tetrahedra${body.data.note ? `; ${body.data.note}` : ""}`);
      const container = Object.assign(document.createElement("div"), { className: "organ-view" });
      figure.append(caption, container);
      this.views.append(figure);
      try {
        this.shown.push({ body, view: new OrganView(container, body.mesh, { label: body.data.title, frame }) });
      } catch (error) {
        showFault(container, "Not shown in 3D", error);
      }
    }
    this.unlink = linkCameras(this.shown.map(({ view }) => view));
    this.offerColours();
    this.offerPlayback();
    this.scale.label.hidden = !this.shown.some(({ body }) => body.displacement);
    this.restyle();
    this.reshape();
  }

  private close(): void {
    this.playback?.pause();
    this.playback = null;
    this.unlink?.();
    this.unlink = null;
    for (const { view } of this.shown) view.dispose();
    this.shown = [];
    this.views.replaceChildren();
    this.below.replaceChildren();
  }

  private offerColours(): void {
    const before = this.chosenColour;
    const titles = new Set(this.shown.flatMap(({ body }) => [...body.fields.keys()]));
    if (this.shown.some(({ body }) => body.frames.length || body.displacement)) titles.add(DISPLACEMENT);
    this.colour.replaceChildren(new Option("nothing", ""), ...[...titles].map((title) => new Option(title, title)));
    // At first a loaded or moving body shows where it goes, any other one its first figure on a cut.
    const first = titles.has(DISPLACEMENT) ? DISPLACEMENT : ([...titles][0] ?? "");
    if (before === null) this.mode.value = titles.has(DISPLACEMENT) || !first ? "surface" : "cut";
    this.colour.value = before !== null && (titles.has(before) || before === "") ? before : first;
  }

  private offerPlayback(): void {
    const moving = this.shown.find(({ body }) => body.frames.length > 1);
    if (!moving) return;
    this.playback = new Playback({ times_s: moving.body.data.motion!.times_s }, (frame) => {
      this.frame = frame;
      this.reshape();
    });
    this.below.append(this.playback.element);
    this.playback.goTo(largestFrame(moving.body)); // a still picture of a body at rest says little
  }

  // Mode, cut, colours and texture, as the controls say.
  private restyle(): void {
    const mode = this.mode.value as ViewMode;
    const bodies = this.shown.map(({ body }) => body);
    this.cut.label.hidden = mode !== "cut";
    for (const { body, view } of this.shown) {
      view.setColours({ background: pageColour("--paper"), edges: isDark() ? "#c9d3da" : "#26323c" });
      view.setTexture(this.texture.checked);
      view.setCut({ normal: view.frame.toEye, offset: Number(this.cut.input.value) });
      view.setMode(mode);
      const field = body.fields.get(this.colour.value);
      const displacement = this.displacementOf(body);
      if (field) view.setScalars({ ...field, range: sharedRange(bodies, field.name) });
      else if (this.colour.value === DISPLACEMENT && displacement)
        view.setScalars({ values: lengthsOf(displacement, body.factor), on: "vertex", name: DISPLACEMENT, unit: body.unit, range: displacementRange(bodies) });
      else view.setScalars(null);
    }
  }

  private displacementOf(body: Body): Float32Array | null {
    return body.frames[Math.min(this.frame, body.frames.length - 1)] ?? body.displacement;
  }

  // The shapes of this moment.
  private reshape(): void {
    for (const { body, view } of this.shown) {
      const displacement = this.displacementOf(body);
      if (!displacement) continue;
      view.setPositions(moved(body, displacement, body.frames.length ? 1 : Number(this.scale.input.value)));
      if (this.colour.value === DISPLACEMENT) view.updateScalarValues(lengthsOf(displacement, body.factor));
    }
  }

  /** All views side by side as one PNG. */
  private save(): void {
    const pictures = this.shown.map(({ view }) => view.picture(1000));
    if (!pictures.length) return;
    const height = Math.max(...pictures.map((picture) => picture.height));
    const joined = Object.assign(document.createElement("canvas"), { width: 1000 * pictures.length, height });
    const context = joined.getContext("2d")!;
    context.fillStyle = pageColour("--paper");
    context.fillRect(0, 0, joined.width, height);
    pictures.forEach((picture, place) => {
      context.drawImage(picture, 1000 * place, 0);
      context.fillStyle = pageColour("--ink");
      context.font = "24px sans-serif";
      context.fillText(this.shown[place]!.body.data.title, 1000 * place + 20, 36);
    });
    joined.toBlob((blob) => blob && download(URL.createObjectURL(blob), `${this.group.value}.png`));
  }
}

function labelled(text: string, input: HTMLElement, isBefore = false): HTMLLabelElement {
  const label = document.createElement("label");
  label.append(...(isBefore ? [input, text] : [text, input]));
  return label;
}

function button(text: string, act: () => void): HTMLButtonElement {
  const found = Object.assign(document.createElement("button"), { type: "button", textContent: text });
  found.addEventListener("click", act);
  return found;
}

function slider(text: string, low: number, high: number, step: number, value: number): { label: HTMLLabelElement; input: HTMLInputElement } {
  const input = Object.assign(document.createElement("input"), { type: "range", min: String(low), max: String(high), step: String(step), value: String(value) });
  return { label: labelled(text, input), input };
}

// A tetrahedral organ in 3D: skin, wireframe or cut open, coloured by a figure, turned by the mouse or the arrow keys. Knows nothing of
// reports or engines: it is given positions and figures.
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { rangeOf, type Scalars } from "./colour_scale";
import { frameOf, type CutPlane, type Frame } from "./framing";
import { drawLegend, showLegend } from "./legend";
import { organMaterial, scaleTexture } from "./organ_material";
import { pickTriangle, type Hit } from "./pick";
import { openRenderer, stopIdle, whenIdle } from "./renderer";
import { TriangleSoup } from "./triangle_soup";
import type { OrganMesh } from "./skin";

THREE.ColorManagement.enabled = false; // colours are shown as they are written

/**
 * `surface`: shaded skin; `edges`: the same with its edges; `wireframe`: the edges of all tetrahedra, or of the skin where they are too many,
 * seen through; `cut`: tetrahedra behind a plane.
 */
export type ViewMode = "surface" | "edges" | "wireframe" | "cut";

export interface OrganViewOptions {
  /** What the view is called, for those who cannot see it. */
  label?: string;
  /** Where the eye stands at first; the same for views side by side. Found from the mesh if it is not given. */
  frame?: Frame;
  mode?: ViewMode;
  /** The speckled skin of section 4.2.8 of the thesis. */
  texture?: boolean;
  /** Of the organ where no figure colours it. */
  tint?: string;
}

export interface ViewColours {
  background: string;
  edges: string;
}

const TINT = "#c4766a";
const FIELD_DEG = 28;
const ACROSS = 1.15; // how much broader than the field of view is high
const KEY_TURN = Math.PI / 24;
// Where pictures take longer than this one after the other, a body that is turned is drawn more coarsely until it stands still.
// A screen of 60 pictures a second has one after 33 or 50 ms.
const SLOW_MS = 40;
const STILL_MS = 250;
const SLICE_MS = 6; // of the time between two pictures, for what pictures need later

/**
 * One view in a container, whose size it takes; the page's style sheet has to give it one (view.css). It draws only when something
 * has changed. Several views of one body turn together by `linkCameras`.
 */
export class OrganView {
  readonly canvas: HTMLCanvasElement;
  readonly camera: THREE.PerspectiveCamera;
  /** Turning and zooming by the mouse; `enabled = false` while something else is dragged. */
  readonly controls: OrbitControls;
  readonly frame: Frame;
  /** Called after the camera has moved by hand. */
  readonly cameraListeners = new Set<() => void>();
  /** Called after each picture. */
  readonly renderListeners = new Set<() => void>();

  private readonly renderer: THREE.WebGLRenderer;
  private readonly isSmoothed: boolean;
  private readonly scene = new THREE.Scene();
  private readonly soup: TriangleSoup;
  private readonly material: THREE.ShaderMaterial;
  private readonly skin: THREE.Mesh;
  private readonly lines: THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial>;
  private readonly legend: HTMLElement;
  private readonly resizing: ResizeObserver;
  private scalars: Scalars | null = null;
  private mode: ViewMode;
  private plane: CutPlane;
  private colours: ViewColours = { background: "#ffffff", edges: "#26323c" };
  private waiting = 0;
  private isTurning = false;
  private isCoarse = false;
  private turnedAt = 0; // of the last picture in a row of them; 0: none
  private stillTimer = 0;
  private idle = 0;

  /** Throws: Error, in words for a reader, where the mesh is broken or the browser has no WebGL. */
  constructor(readonly container: HTMLElement, mesh: OrganMesh, options: OrganViewOptions = {}) {
    this.soup = new TriangleSoup(mesh);
    this.frame = options.frame ?? frameOf(mesh.positions);
    this.mode = options.mode ?? "surface";
    this.plane = { normal: this.frame.toEye, offset: 0 };
    this.canvas = document.createElement("canvas");
    this.canvas.className = "organ-canvas";
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "application");
    this.canvas.setAttribute("aria-roledescription", "3D view");
    this.canvas.setAttribute("aria-label", `${options.label ?? "Organ"}, in 3D. Arrow keys turn it, plus and minus come nearer and go away, 0 looks as at first.`);
    this.renderer = openRenderer(this.canvas);
    this.isSmoothed = this.renderer.getContextAttributes()?.antialias === true;
    this.legend = Object.assign(document.createElement("div"), { className: "organ-legend", hidden: true });
    container.append(this.canvas, this.legend);

    this.material = organMaterial(options.tint ?? TINT);
    this.material.uniforms["textured"]!.value = options.texture === false ? 0 : 1;
    this.skin = new THREE.Mesh(this.soup.geometry, this.material);
    this.lines = new THREE.LineSegments(this.soup.edgeGeometry, new THREE.LineBasicMaterial({ color: this.colours.edges, transparent: true }));
    this.skin.frustumCulled = this.lines.frustumCulled = false;
    this.scene.add(this.skin, this.lines);

    this.camera = new THREE.PerspectiveCamera(FIELD_DEG, 1, 0.01, 100);
    this.camera.up.set(...this.frame.up);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => {
      this.isTurning = true;
      this.requestRender();
      for (const listener of this.cameraListeners) listener();
    });
    this.canvas.addEventListener("keydown", (event) => this.turnByKey(event));
    this.resizing = new ResizeObserver(() => this.resize());
    this.resizing.observe(container);
    this.resetCamera();
    this.setMode(this.mode);
    this.resize();
  }

  /** How many triangles the last picture had: fewer than the skin while it is turned and pictures are slow. */
  get drawnTriangles(): number {
    return this.soup.drawnTriangles;
  }

  get vertexCount(): number {
    return this.soup.positions.length / 3;
  }

  /** The triangles of the boundary: what `pick` counts. */
  get boundary(): Uint32Array {
    return this.soup.boundary;
  }

  /** Where the vertices are now. */
  get positions(): Float32Array {
    return this.soup.positions;
  }

  /** At a vertex of the skin, of the shape that it had at first: outwards, of length 1. */
  restNormal(vertex: number): [number, number, number] {
    return this.soup.restNormal(vertex);
  }

  /** Moves the vertices; the texture sticks to the rest shape. Throws: Error if their number differs. */
  setPositions(positions: Float32Array): void {
    this.soup.setPositions(positions);
    this.requestRender();
  }

  /** Colours the organ by a figure, or by none. Throws: Error if there are more or fewer figures than vertices or tetrahedra. */
  setScalars(scalars: Scalars | null): void {
    this.soup.setScalars(scalars);
    this.scalars = scalars;
    const [low, high] = scalars ? (scalars.range ?? rangeOf(scalars.values)) : [0, 1];
    const { uniforms } = this.material;
    uniforms["hasScalar"]!.value = scalars ? 1 : 0;
    uniforms["low"]!.value = low;
    uniforms["high"]!.value = high > low ? high : low + 1;
    const table = uniforms["scaleMap"]!.value as THREE.DataTexture;
    const name = scalars?.scale ?? "viridis";
    if (table.name !== name) {
      table.dispose();
      uniforms["scaleMap"]!.value = Object.assign(scaleTexture(name), { name });
    }
    showLegend(this.legend, scalars);
    this.requestRender();
  }

  /** A new set of the same figures, such as each frame of a motion has: neither legend nor range change. */
  updateScalarValues(values: Float32Array): void {
    if (!this.scalars) return;
    this.scalars = { ...this.scalars, values };
    this.soup.setScalars(this.scalars);
    this.requestRender();
  }

  setMode(mode: ViewMode): void {
    this.mode = mode;
    this.soup.show(mode === "cut" ? this.plane : null, mode === "surface" ? "none" : mode === "wireframe" ? "all" : "drawn", this.frame);
    this.skin.visible = mode !== "wireframe";
    this.lines.visible = this.hasLines;
    this.lines.material.opacity = mode === "wireframe" ? 0.75 : 0.4;
    this.requestRender();
  }

  /** Where `cut` cuts. */
  setCut(plane: CutPlane): void {
    this.plane = plane;
    if (this.mode === "cut") this.setMode("cut");
  }

  setTexture(on: boolean): void {
    this.material.uniforms["textured"]!.value = on ? 1 : 0;
    this.requestRender();
  }

  setColours(colours: ViewColours): void {
    this.colours = colours;
    this.lines.material.color.set(colours.edges);
    this.requestRender();
  }

  /** What is under a point of the window: the nearest triangle of the boundary that faces the eye, as it is now. */
  pick(clientX: number, clientY: number): Hit | null {
    const { origin, direction } = this.rayAt(clientX, clientY);
    return pickTriangle(this.soup.positions, this.soup.boundary, origin.toArray(), direction.toArray());
  }

  /** The ray from the eye through a point of the window. */
  rayAt(clientX: number, clientY: number): THREE.Ray {
    const box = this.canvas.getBoundingClientRect();
    const x = (2 * (clientX - box.left)) / box.width - 1;
    const y = 1 - (2 * (clientY - box.top)) / box.height;
    this.camera.updateMatrixWorld();
    const origin = new THREE.Vector3().setFromMatrixPosition(this.camera.matrixWorld);
    return new THREE.Ray(origin, new THREE.Vector3(x, y, 0.5).unproject(this.camera).sub(origin).normalize());
  }

  /** Where a point of the body is in the window, in pixels of the client area. */
  clientPoint(point: readonly [number, number, number]): { x: number; y: number } {
    this.camera.updateMatrixWorld();
    const flat = new THREE.Vector3(...point).project(this.camera);
    const box = this.canvas.getBoundingClientRect();
    return { x: box.left + ((flat.x + 1) / 2) * box.width, y: box.top + ((1 - flat.y) / 2) * box.height };
  }

  resetCamera(): void {
    const { centre, radius, toEye, up } = this.frame;
    const distance = (0.94 * radius) / Math.sin((FIELD_DEG * Math.PI) / 360);
    this.camera.up.set(...up);
    this.camera.position.set(...toEye).multiplyScalar(distance).add(new THREE.Vector3(...centre));
    this.camera.near = distance / 200;
    this.camera.far = distance * 20;
    this.controls.target.set(...centre);
    this.controls.minDistance = distance / 30;
    this.controls.maxDistance = distance * 6;
    this.fitToShape();
    this.controls.update();
  }

  /** Looks from a side, as near as now: for a picture. */
  lookFrom(toEye: readonly [number, number, number], up: readonly [number, number, number]): void {
    const { target } = this.controls;
    const distance = this.camera.position.distanceTo(target);
    this.camera.up.set(...up);
    this.camera.position.set(...toEye).setLength(distance).add(target);
    this.camera.lookAt(target);
    this.requestRender();
  }

  /** Looks as another view does, each relative to its own frame. */
  copyCamera(other: OrganView): void {
    const scale = this.frame.radius / other.frame.radius;
    const from = new THREE.Vector3(...other.frame.centre);
    const to = new THREE.Vector3(...this.frame.centre);
    this.camera.position.copy(other.camera.position).sub(from).multiplyScalar(scale).add(to);
    this.controls.target.copy(other.controls.target).sub(from).multiplyScalar(scale).add(to);
    this.camera.up.copy(other.camera.up);
    this.camera.lookAt(this.controls.target);
    this.isTurning = true;
    this.requestRender();
  }

  requestRender(): void {
    if (this.waiting) return;
    this.waiting = requestAnimationFrame(() => this.render());
  }

  /** Draws now. */
  render(): void {
    if (this.waiting) cancelAnimationFrame(this.waiting);
    this.waiting = 0;
    this.choosePrecision();
    this.soup.upload();
    this.soup.draw(this.isCoarse ? "stand-in" : "everything");
    if (this.isCoarse) this.workOnStandIn();
    this.renderer.setClearColor(this.colours.background, 1);
    this.renderer.render(this.scene, this.camera);
    for (const listener of this.renderListeners) listener();
  }

  // Only a row of pictures tells how long one takes: drawing goes on when its commands have been given.
  private choosePrecision(): void {
    const now = performance.now();
    if (this.isTurning) {
      if (this.turnedAt > 0 && now - this.turnedAt > SLOW_MS) this.drawCoarsely(true);
      this.turnedAt = now;
      this.waitForStill();
    }
    this.isTurning = false;
  }

  // The browser has time for a picture once the last one is drawn; by then it may have been turned further.
  private waitForStill(): void {
    clearTimeout(this.stillTimer);
    this.stillTimer = window.setTimeout(() => requestAnimationFrame(() => (this.isTurning ? this.waitForStill() : this.drawFinely())), STILL_MS);
  }

  private drawFinely(): void {
    this.turnedAt = 0;
    clearTimeout(this.stillTimer);
    if (!this.isCoarse) return;
    this.drawCoarsely(false);
    this.render();
  }

  // In small pieces, so that no picture has to wait for it.
  private workOnStandIn(): void {
    if (this.idle) return;
    this.idle = whenIdle(() => {
      this.idle = 0;
      if (this.soup.workOnStandIn(performance.now() + SLICE_MS)) this.workOnStandIn();
    });
  }

  // Half the points in each direction, no edges on a surface, only what looks to the eye, and of a large skin its stand-in.
  private drawCoarsely(on: boolean): void {
    if (this.isCoarse === on) return;
    this.isCoarse = on;
    this.canvas.toggleAttribute("data-coarse", on);
    this.material.side = on ? THREE.FrontSide : THREE.DoubleSide;
    this.lines.visible = this.hasLines;
    this.renderer.setPixelRatio(this.pixelRatio);
  }

  private get pixelRatio(): number {
    return Math.min(2, window.devicePixelRatio || 1) * (this.isCoarse ? 0.5 : 1);
  }

  private get hasLines(): boolean {
    return this.mode === "wireframe" || (this.mode !== "surface" && !this.isCoarse);
  }

  /** The view as a picture of `width` pixels, with its legend. */
  picture(width = 1600): HTMLCanvasElement {
    this.drawFinely();
    const shown = this.renderer.getSize(new THREE.Vector2());
    const ratio = this.renderer.getPixelRatio();
    const height = Math.round((width * shown.y) / Math.max(1, shown.x));
    this.renderer.setPixelRatio(this.isSmoothed ? 1 : 2);
    this.renderer.setSize(width, height, false);
    this.render();
    const picture = Object.assign(document.createElement("canvas"), { width, height });
    const context = picture.getContext("2d")!;
    context.imageSmoothingQuality = "high";
    context.drawImage(this.canvas, 0, 0, width, height);
    if (this.scalars) drawLegend(context, this.scalars, this.colours.edges, Math.round(width / 50));
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(shown.x, shown.y, false);
    this.render();
    return picture;
  }

  /** Takes the view away and gives its memory back. */
  dispose(): void {
    if (this.waiting) cancelAnimationFrame(this.waiting);
    clearTimeout(this.stillTimer);
    stopIdle(this.idle);
    this.resizing.disconnect();
    this.controls.dispose();
    this.soup.dispose();
    this.material.dispose();
    this.lines.material.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.canvas.remove();
    this.legend.remove();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas.parentElement === this.container ? this.container : this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setPixelRatio(this.pixelRatio);
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.fitToShape();
    this.requestRender();
  }

  // In a window that is not much broader than high, the field of view is that across: a body lies with its longest axis there.
  private fitToShape(): void {
    const half = Math.tan((FIELD_DEG * Math.PI) / 360);
    this.camera.fov = (360 / Math.PI) * Math.atan(half * Math.max(1, ACROSS / this.camera.aspect));
    this.camera.updateProjectionMatrix();
  }

  private turnByKey(event: KeyboardEvent): void {
    const turns: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const zooms: Record<string, number> = { "+": 0.9, "=": 0.9, "-": 1 / 0.9 };
    const turn = turns[event.key];
    const zoom = zooms[event.key];
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (turn) this.turn(turn[0] * KEY_TURN, turn[1] * KEY_TURN);
    else if (zoom) this.zoom(zoom);
    else if (event.key === "0") this.resetCamera();
    else return;
    event.preventDefault();
  }

  /** Turns the eye around the body: to the right and upwards, in radians. */
  turn(right: number, up: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const sideways = new THREE.Vector3().crossVectors(this.camera.up, offset).normalize();
    const tilt = offset.angleTo(this.camera.up);
    offset.applyAxisAngle(sideways, Math.max(0.05, Math.min(Math.PI - 0.05, tilt + up)) - tilt);
    offset.applyAxisAngle(this.camera.up.clone().normalize(), right);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
  }

  zoom(factor: number): void {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
  }
}

// The mouse as a finger: what it takes hold of, and how far it moves it.
import * as THREE from "three";
import type { OrganView } from "../view/organ_view";
import type { Vector } from "./protocol";

export interface FingerEvents {
  /** `normal` looks outwards; the finger starts there without having moved. */
  press(vertex: number, by: Vector): void;
  move(by: Vector): void;
  /** It has come to another vertex. */
  slide(vertex: number, by: Vector): void;
  release(): void;
}

export interface FingerReach {
  /** How far the first touch presses in, in m. */
  depthM: number;
  /** Dragged, it slides over the skin. */
  slides: boolean;
}

/**
 * Presses where the organ is under the pointer, and lets it turn elsewhere. Shift pulls; the wheel goes deeper. Dragged, it takes along what
 * it holds, or slides over the skin, always as deep; what is pulled is held.
 */
export class Finger {
  private pointer: number | null = null;
  private plane = new THREE.Plane();
  private start = new THREE.Vector3();
  private normal = new THREE.Vector3();
  private depthM = 0;
  private along = new THREE.Vector3();
  private vertex = 0;
  private slides = false;
  private readonly undo = new AbortController();

  constructor(private readonly view: OrganView, private readonly reach: () => FingerReach, private readonly events: FingerEvents) {
    const { container } = view;
    const options = { capture: true, signal: this.undo.signal };
    container.addEventListener("pointerdown", (event) => this.down(event), options);
    container.addEventListener("pointermove", (event) => this.moved(event), options);
    for (const name of ["pointerup", "pointercancel"] as const) container.addEventListener(name, (event) => this.up(event), options);
    container.addEventListener("wheel", (event) => this.wheel(event), { ...options, passive: false });
  }

  dispose(): void {
    this.undo.abort();
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0 || this.pointer !== null || !event.isPrimary) return;
    const hit = this.view.pick(event.clientX, event.clientY);
    if (!hit) return; // the background: the view turns
    event.stopPropagation();
    this.pointer = event.pointerId;
    this.view.controls.enabled = false;
    this.view.canvas.setPointerCapture(event.pointerId);
    this.start.set(...hit.point);
    this.normal.set(...hit.normal);
    const eye = this.view.camera.getWorldDirection(new THREE.Vector3());
    this.plane.setFromNormalAndCoplanarPoint(eye, this.start);
    this.along.set(0, 0, 0);
    this.depthM = event.shiftKey ? -this.reach().depthM : this.reach().depthM;
    this.vertex = hit.vertex;
    this.slides = this.reach().slides && !event.shiftKey;
    this.events.press(hit.vertex, this.by());
  }

  private moved(event: PointerEvent): void {
    if (event.pointerId !== this.pointer) return;
    event.stopPropagation();
    if (this.slides) return this.slideTo(event);
    const at = this.view.rayAt(event.clientX, event.clientY).intersectPlane(this.plane, new THREE.Vector3());
    if (!at) return;
    this.along.copy(at).sub(this.start);
    this.events.move(this.by());
  }

  private slideTo(event: PointerEvent): void {
    const hit = this.view.pick(event.clientX, event.clientY);
    if (!hit || hit.vertex === this.vertex) return; // beside the organ it stays where it was last
    this.vertex = hit.vertex;
    this.normal.set(...this.view.restNormal(hit.vertex)); // not of the dent's wall
    this.events.slide(hit.vertex, this.by());
  }

  private up(event: PointerEvent): void {
    if (event.pointerId !== this.pointer) return;
    event.stopPropagation();
    this.pointer = null;
    this.view.controls.enabled = true;
    this.events.release();
  }

  private wheel(event: WheelEvent): void {
    if (this.pointer === null) return;
    event.preventDefault();
    event.stopPropagation();
    this.depthM += (event.deltaY < 0 ? 1 : -1) * 0.1 * this.reach().depthM;
    this.events.move(this.by());
  }

  /** Into the body along the normal, and as far along the picture as the pointer; at most as far as the body is broad. */
  private by(): Vector {
    const by = this.normal.clone().multiplyScalar(-this.depthM).add(this.along);
    return by.clampLength(0, this.view.frame.radius).toArray() as Vector;
  }
}

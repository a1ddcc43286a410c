// What draws: WebGL by graphics card or by processor, and the time that pictures leave.
import * as THREE from "three";

/** A renderer on this canvas. Throws: Error where the browser draws nothing in 3D. */
export function openRenderer(canvas: HTMLCanvasElement): THREE.WebGLRenderer {
  const antialias = !isDrawnBySoftware();
  if (!canvas.getContext("webgl2", { antialias })) throw new Error("this browser has no WebGL 2, so nothing is drawn in 3D");
  return new THREE.WebGLRenderer({ canvas, antialias });
}

// Safari has no idle time of its own.
const hasIdle = typeof requestIdleCallback === "function";
/** Does something when there is time between two pictures, within 0.1 s. Returns what stopIdle takes. */
export function whenIdle(act: () => void): number {
  return hasIdle ? requestIdleCallback(act, { timeout: 100 }) : window.setTimeout(act, 20);
}

export function stopIdle(idle: number): void {
  if (hasIdle) cancelIdleCallback(idle);
  else clearTimeout(idle);
}

let software: boolean | null = null;
/** Whether the processor draws: smooth edges double the time of each picture then, and pictures take what else runs its time. */
export function isDrawnBySoftware(): boolean {
  if (software !== null) return software;
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = gl ? String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return (software = /swiftshader|llvmpipe|softpipe|software/i.test(name));
}

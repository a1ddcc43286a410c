// How long the 3D view takes to draw a body in headless Chromium, way by way: turned, deformed, cut, touched. No test: it times.
//
//     node view_bench.mjs ROOT ORGAN.mesh [PICTURES] [paced]
//
// `paced`: only turned as the browser paces it, which is the quickest to repeat. A mesh without tetrahedra is not cut.
// A time ends when a pixel of the picture has been read back, so it holds the drawing, which SwiftShader does on the processors. Prints a
// table of medians, with what 95% of the pictures stayed below, and the mean of the processor time that all of the browser took: what
// other programs on the machine change least.
import { existsSync, readdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { availableParallelism, cpus, loadavg } from "node:os";
import { join } from "node:path";
import { startReader } from "./reader.mjs";

const WINDOW = { width: 740, height: 540 }; // as the report shows one body

const [root, mesh, pictures = "40", only = ""] = process.argv.slice(2);
if (!root || !mesh || !existsSync(mesh)) {
  console.error("usage: node view_bench.mjs ROOT ORGAN.mesh [PICTURES]");
  process.exit(2);
}

/** Vertices, triangles and tetrahedra of a MEDIT file. */
function readMesh(file) {
  const words = readFileSync(file, "utf8").split(/\s+/);
  const block = (name, width) => {
    const at = words.indexOf(name);
    const count = at < 0 ? 0 : Number(words[at + 1]);
    return Array.from({ length: count }, (_, i) => words.slice(at + 2 + (width + 1) * i, at + 2 + (width + 1) * i + width).map(Number)).flat();
  };
  const tets = block("Tetrahedra", 4).map((vertex) => vertex - 1);
  return { positions: block("Vertices", 3), tets, triangles: tets.length ? null : block("Triangles", 3).map((vertex) => vertex - 1) };
}

/** Processor time of all that this program has started, in ms. */
function browserMs() {
  const processes = readdirSync("/proc").filter((name) => /^\d+$/.test(name)).flatMap((pid) => {
    try {
      const fields = readFileSync(`/proc/${pid}/stat`, "latin1").replace(/^.*\) /s, "").split(" ");
      return [{ pid: Number(pid), parent: Number(fields[1]), ticks: Number(fields[11]) + Number(fields[12]) }];
    } catch {
      return []; // it has just ended
    }
  });
  const own = new Set([process.pid]);
  for (let before = 0; before < own.size; ) {
    before = own.size;
    for (const { pid, parent } of processes) if (own.has(parent)) own.add(pid);
  }
  const TICK_MS = 10; // Linux counts in hundredths of a second
  return TICK_MS * processes.reduce((sum, { pid, ticks }) => sum + (own.has(pid) && pid !== process.pid ? ticks : 0), 0);
}

/** In the page: the view on the mesh, and what is timed of it. */
const ENTRY = `
import { OrganView } from "./view/organ_view";
window.bench = async (mesh, count, only) => {
  const container = document.getElementById("view");
  const positions = new Float32Array(mesh.positions), tets = new Uint32Array(mesh.tets);
  const began = performance.now();
  const view = new OrganView(container, { positions, tets, ...(mesh.triangles ? { triangles: new Uint32Array(mesh.triangles) } : {}) });
  const gl = view.canvas.getContext("webgl2");
  const pixel = new Uint8Array(4);
  const drawn = () => { view.render(); gl.readPixels(1, 1, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); };
  drawn();
  const rows = [["opened, and drawn first", [performance.now() - began]]];
  const time = async (name, act) => {
    const times = [];
    let before = 0;
    for (let k = -3; k < count; k++) { // the first are not counted
      if (k === 0) before = await window.browserMs();
      const start = performance.now();
      act(k);
      if (k >= 0) times.push(performance.now() - start);
      await new Promise((done) => setTimeout(done));
    }
    rows.push([name, times, ((await window.browserMs()) - before) / count]);
  };
  const paced = async () => {
    view.drawFinely();
    let start = 0;
    const frames = await new Promise((done) => { // as the browser paces them
      const stamps = [];
      const frame = async (now) => {
        stamps.push(now);
        if (stamps.length === 30) start = await window.browserMs(); // the first are not counted
        view.turn(0.05, 0);
        stamps.length > 30 + count ? done(stamps) : requestAnimationFrame(frame);
      };
      requestAnimationFrame(frame);
    });
    const took = (await window.browserMs()) - start;
    rows.push(["shaded: turned, from picture to picture as the browser paces them", frames.slice(31).map((at, k) => at - frames[30 + k]), took / count, view.drawnTriangles]);
    view.drawFinely();
  };
  const result = () => ({ rows, triangles: view.boundary.length / 3, vertices: positions.length / 3, tets: tets.length / 4 });
  if (only === "paced") {
    await paced();
    return result();
  }
  // Of one picture alone, which nobody waits for: as it is drawn when it stands still.
  const turned = () => { view.turn(0.05, 0); view.drawFinely(); drawn(); };
  const quickly = () => { view.turn(0.05, 0); view.drawCoarsely(true); while (view.soup.workOnStandIn?.(performance.now() + 1000)); drawn(); };
  const modes = { surface: "shaded and textured", edges: "with its edges", wireframe: "as wireframe", ...(tets.length ? { cut: "cut open" } : {}) };
  for (const [mode, name] of Object.entries(modes)) {
    const start = performance.now();
    view.setMode(mode);
    drawn();
    rows.push([name + ": first picture", [performance.now() - start]]);
    await time(name + ": turned", turned);
    await time(name + ": turned, as where that is slow", quickly);
  }
  if (tets.length) await time("cut open: the cut moved", (k) => { view.setCut({ normal: view.frame.toEye, offset: 0.3 * Math.sin(k) }); drawn(); });
  view.setMode("surface");
  const values = new Float32Array(positions.length / 3);
  const field = (k) => values.map((_, i) => Math.abs(Math.sin(0.001 * i + k)));
  view.setScalars({ values: field(0), on: "vertex", name: "displacement", unit: "mm", range: [0, 1] });
  await time("coloured: turned", turned);
  const size = view.frame.radius;
  await time("shaded and coloured: deformed", (k) => {
    view.setPositions(positions.map((x, i) => x + 0.01 * size * Math.sin(k + 3 * positions[i - (i % 3)] / size)));
    view.updateScalarValues(field(k));
    drawn();
  });
  const box = view.canvas.getBoundingClientRect();
  await time("what lies under the pointer", (k) => view.pick(box.left + box.width * (0.4 + 0.005 * (k % 40)), box.top + box.height / 2));
  view.setScalars(null);
  await paced();
  return result();
};`;

const { build } = createRequire(join(root, "page/package.json"))("esbuild");
const made = await build({ stdin: { contents: ENTRY, resolveDir: join(root, "page"), loader: "ts" }, bundle: true, write: false, format: "iife", minify: true, target: ["es2022"] });
const { browser } = await startReader(root);
const page = await browser.newPage({ viewport: { width: 800, height: 600 } });
page.on("pageerror", (error) => console.error(String(error)));
await page.setContent(`<!doctype html><style>#view { position: relative; width: ${WINDOW.width}px; height: ${WINDOW.height}px; } canvas { width: 100%; height: 100%; }</style><div id="view"></div>`);
await page.addScriptTag({ content: made.outputFiles[0].text });
await page.exposeFunction("browserMs", browserMs);
const { rows, triangles, vertices, tets } = await page.evaluate(([body, count, what]) => window.bench(body, count, what), [readMesh(mesh), Number(pictures), only]);
console.log(`${triangles.toLocaleString("en")} triangles of the skin, ${vertices.toLocaleString("en")} vertices, ${tets.toLocaleString("en")} tetrahedra; ${WINDOW.width} x ${WINDOW.height} pixels`);
console.log(`${cpus()[0].model}, ${availableParallelism()} processors, load ${loadavg()[0].toFixed(1)}; Chromium ${browser.version()}, drawn by SwiftShader on the same processors\n`);
console.log("| what | median, ms | 95% below, ms | pictures a second | processor time, ms | triangles |\n|---|---|---|---|---|---|");
for (const [name, times, processorMs, drawn] of rows) {
  const sorted = [...times].sort((a, b) => a - b);
  const [median, high] = [sorted[sorted.length >> 1], sorted[Math.ceil(0.95 * sorted.length) - 1]];
  console.log(`| ${name} | ${median.toFixed(1)} | ${times.length > 1 ? high.toFixed(1) : ""} | ${times.length > 1 ? (1000 / median).toFixed(0) : ""} | ${processorMs?.toFixed(0) ?? ""} | ${drawn ?? ""} |`);
}
await browser.close();

// A large body that is turned where pictures are slow (page/view/stand_in.ts), in Debian's Chromium: it is drawn by fewer triangles, which look
// the same, and by all of them again when it stands still, when it is saved, and where pictures are quick.
//
//     node turning_test.mjs ROOT
//
// Nothing here depends on how fast the machine is: the page's clock is the test's.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { join } from "node:path";
import { test } from "node:test";
import { startReader } from "./reader.mjs";

const root = process.argv[2];
const { build } = createRequire(join(root, "page/package.json"))("esbuild");

/** In the page. Bodies are slabs of 2 x 2 x 0.3, bent a little, of cubes of six tetrahedra. */
const ENTRY = `
import { OrganView } from "./view/organ_view";
const TETS_OF_CUBE = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];
let clock = 0;
performance.now = () => (clock += 0.1); // so that work in slices has more than one

function slab(n) {
  const layers = 3;
  const number = (i, j, k) => (i * (n + 1) + j) * (layers + 1) + k;
  const positions = [], tets = [];
  for (let i = 0; i <= n; i++) for (let j = 0; j <= n; j++) for (let k = 0; k <= layers; k++) {
    const [x, y] = [2 * i / n - 1, 2 * j / n - 1];
    positions.push(x, y, 0.1 * k + 0.15 * Math.sin(2 * x) * Math.cos(3 * y));
  }
  for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) for (let k = 0; k < layers; k++)
    for (const tet of TETS_OF_CUBE) tets.push(...tet.map((c) => number(i + (c & 1), j + ((c >> 1) & 1), k + ((c >> 2) & 1))));
  return { positions: Float32Array.from(positions), tets: Uint32Array.from(tets) };
}

const container = document.getElementById("view");
let mesh, view;
const field = (k) => new Float32Array(mesh.positions.length / 3).map((_, i) => Math.sin(2 * mesh.positions[3 * i] + k));

Object.assign(window, {
  open(n) {
    view?.dispose();
    mesh = slab(n);
    view = new OrganView(container, mesh, { frame: { centre: [0, 0, 0.15], radius: 1.5, toEye: [0.3, -0.5, 0.8], up: [0, 1, 0] } });
    view.render();
    return view.boundary.length / 3;
  },
  turn(pictures, between_ms) {
    for (let k = 0; k < pictures; k++) { clock += between_ms; view.turn(0.02, 0.01); view.render(); }
    return { triangles: view.drawnTriangles, coarse: view.canvas.hasAttribute("data-coarse") };
  },
  // However long the work on it is left waiting: what is said is said of the last of slow pictures.
  async turnUntil(isEnough, most) {
    let said = window.turn(3, 60);
    for (let k = 0; k < most && !isEnough(said); k++) {
      await new Promise((done) => requestIdleCallback(done, { timeout: 50 }));
      said = window.turn(3, 60);
    }
    return said;
  },
  fewer: (n, most = 400) => window.turnUntil(({ triangles, coarse }) => coarse && triangles <= n, most),
  displace() { view.setPositions(mesh.positions.map((x, i) => i % 3 === 2 ? x + 0.2 * Math.sin(2 * mesh.positions[i - 2]) : x)); },
  colour(on) { view.setScalars(on === null ? null : { values: on === "tet" ? new Float32Array(mesh.tets.length / 4).map((_, i) => i % 7) : field(0), on, name: "x", unit: "", range: [-1, 1] }); },
  cut(offset) { view.setMode(offset === null ? "surface" : "cut"); if (offset !== null) view.setCut({ normal: [1, 0, 0], offset }); view.render(); return view.drawnTriangles; },
  picture: () => view.picture(300).toDataURL(),
  stand() { view.drawFinely(); return view.drawnTriangles; },
  state: () => ({ triangles: view.drawnTriangles, coarse: view.canvas.hasAttribute("data-coarse") }),
  // The same picture by the stand-in and by everything, both of half the points.
  compare(toEye) {
    view.lookFrom(toEye, [0, 1, 0]);
    const gl = view.canvas.getContext("webgl2");
    const read = (what) => {
      view.drawCoarsely(true);
      const { soup } = view, count = soup.standInTriangles;
      if (what === "everything") soup.standInTriangles = 0;
      view.render();
      soup.standInTriangles = count;
      const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
      const pixels = new Uint8Array(4 * width * height);
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      return { width, height, pixels, triangles: view.drawnTriangles };
    };
    const [few, all] = [read("stand-in"), read("everything")];
    const { width, height } = all;
    const isDrawn = ({ pixels }, i) => pixels[4 * i] + pixels[4 * i + 1] + pixels[4 * i + 2] < 3 * 250;
    let drawn = 0, astray = 0, difference = 0;
    for (let y = 1; y < height - 1; y++) for (let x = 1; x < width - 1; x++) {
      const i = y * width + x;
      const [inFew, inAll] = [isDrawn(few, i), isDrawn(all, i)];
      const around = [-1, 0, 1].flatMap((dy) => [-1, 0, 1].map((dx) => isDrawn(all, i + dy * width + dx)));
      if (inFew !== inAll && around.every((each) => each === inAll)) astray++; // a hole, or a spur, not beside the silhouette
      if (!inFew || !inAll) continue;
      drawn++;
      for (let c = 0; c < 3; c++) difference += Math.abs(few.pixels[4 * i + c] - all.pixels[4 * i + c]) / 3;
    }
    return { drawn, astray, difference: difference / drawn, few: few.triangles, all: all.triangles };
  },
});`;

const made = await build({ stdin: { contents: ENTRY, resolveDir: join(root, "page"), loader: "ts" }, bundle: true, write: false, format: "iife", target: ["es2022"] });
const { browser } = await startReader(root);
const page = await browser.newPage({ viewport: { width: 500, height: 400 } });
page.setDefaultTimeout(120_000);
const trouble = [];
page.on("pageerror", (error) => trouble.push(String(error)));
await page.setContent(`<!doctype html><style>#view { position: relative; width: 440px; height: 340px; } canvas { width: 100%; height: 100%; }</style><div id="view"></div>`);
await page.addScriptTag({ content: made.outputFiles[0].text });
const call = (name, ...words) => page.evaluate(([what, given]) => window[what](...given), [name, words]);
const LARGE = 80; // 27,520 triangles
const SMALL = 60; // 15,840
const skin = await call("open", LARGE);

/** Both ways look alike: same outline but for a point, no holes, and colours that differ by less than a grey in forty on the mean. */
async function lookAlike(what, toEye = [0.3, -0.5, 0.8]) {
  const { drawn, astray, difference, few, all } = await call("compare", toEye);
  assert.ok(few < all && drawn > 3000, `${what}: ${few} of ${all} triangles, ${drawn} points`);
  assert.ok(astray === 0, `${what}: ${astray} points are drawn by one alone`);
  assert.ok(difference < 6, `${what}: colours differ by ${difference}`);
}

test("where pictures are quick, a turned body keeps all of its triangles", async () => {
  assert.deepEqual(await call("turn", 20, 17), { triangles: skin, coarse: false });
});

test("where pictures are slow, a large body is turned by fewer triangles, and gets all of them back", async () => {
  const said = await call("fewer", skin / 2);
  assert.ok(said.coarse && said.triangles <= skin / 2 && said.triangles > skin / 10, JSON.stringify(said));
  await page.waitForFunction(() => !window.state().coarse);
  assert.deepEqual(await call("state"), { triangles: skin, coarse: false });
});

test("the fewer triangles look as all of them do: shaded, coloured, displaced", async () => {
  await call("fewer", skin / 2);
  await lookAlike("shaded");
  await call("colour", "vertex");
  await lookAlike("coloured");
  await call("displace");
  await lookAlike("displaced");
  await call("colour", null);
  await call("stand");
});

test("a picture that is saved while the body is turned has all triangles", async () => {
  await call("fewer", skin / 2);
  const turned = await call("picture");
  assert.equal(await call("stand"), skin);
  assert.equal(await call("picture"), turned);
});

test("of a body cut open the skin is replaced, without a gap beside the cut", async () => {
  const shown = await call("cut", 0.5);
  const said = await call("fewer", 0.6 * shown);
  assert.ok(said.coarse && said.triangles < 0.6 * shown, JSON.stringify(said));
  for (const toEye of [[0.8, -0.4, 0.45], [0.8, 0.4, -0.45], [0.95, 0.1, 0.2]]) await lookAlike("cut open", toEye);
  assert.equal(await call("stand"), shown);
  await call("cut", null);
});

test("figures of tetrahedra keep all triangles, and so does a small body, however slow it is", async () => {
  await call("colour", "tet");
  assert.deepEqual(await call("fewer", skin - 1, 20), { triangles: skin, coarse: true });
  const few = await call("open", SMALL);
  assert.deepEqual(await call("fewer", few - 1, 20), { triangles: few, coarse: true });
});

test("nothing went wrong in the page", async () => {
  assert.deepEqual(trouble, []);
  await browser.close();
});

// The live page in a real browser: a press moves what is under the cursor, letting go brings it back, the answer of the finite elements
// stands beside it, nothing is fetched, and what is broken is said.
//
//     node live_page_test.mjs SOURCE_DIR PALPATE [SCREENSHOT_DIR]
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import http from "node:http";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { findBarriers } from "../page/reader.mjs";

const [source, palpate, shots] = process.argv.slice(2);
const { chromium } = createRequire(join(source, "page/package.json"))("playwright-core");
const folder = mkdtempSync(join(tmpdir(), "palpate-live-"));
const NAME = "<script>alert(1)<!--"; // stays text
const mesh = join(folder, `${NAME}.mesh`);
const file = join(folder, "live.html");
const bare = join(folder, "bare.html"); // without a table
const PATIENCE_MS = 240_000;

const run = (...words) => execFileSync(palpate, words, { stdio: ["ignore", "pipe", "pipe"], encoding: "utf8" });

/** A page whose console, errors and requests are kept; blobs and data are its own parts. */
async function open(browser, url, options = {}) {
  const page = await browser.newPage({ viewport: { width: 1200, height: 800 }, ...options });
  const complaints = [];
  const requests = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("request", (request) => /^(blob|data):/.test(request.url()) || requests.push(request.url()));
  page.setDefaultTimeout(PATIENCE_MS);
  await page.goto(url, { timeout: PATIENCE_MS });
  return { page, complaints, requests };
}

const value = (page, readout, key = "value") => page.locator(`[data-readout=${readout}]`).evaluate((cell, name) => Number(cell.dataset[name]), key);
/** Waits until a figure of the page is above or below a bound, or equal to it. */
const until = (page, readout, comparison, bound, key = "value") =>
  page.waitForFunction(([name, sign, limit, which]) => {
    const x = Number(document.querySelector(`[data-readout=${name}]`)?.dataset[which] ?? NaN);
    return sign === ">" ? x > limit : sign === "<" ? x < limit : x === limit;
  }, [readout, comparison, bound, key], { timeout: PATIENCE_MS });
/** Waits until all these figures are within their bounds at once: a moving body's pass through them one by one. */
async function settles(page, bounds) {
  const within = (asked) => Object.entries(asked).every(([name, [least, most]]) => {
    const x = Number(document.querySelector(`[data-readout=${name}]`)?.dataset.value ?? NaN);
    return x >= least && x <= most;
  });
  try {
    await page.waitForFunction(within, bounds, { timeout: PATIENCE_MS });
  } catch (error) {
    const figures = await Promise.all(Object.keys(bounds).map(async (name) => `${name} ${await value(page, name)}`));
    throw new Error(`it does not settle: ${figures.join(", ")}`, { cause: error });
  }
}
const isWhole = (page) => page.waitForFunction(() => document.querySelector("[data-readout=state]")?.textContent === "whole", null, { timeout: PATIENCE_MS });

async function shoot(page, name) {
  if (!shots) return;
  mkdirSync(shots, { recursive: true });
  await page.screenshot({ path: join(shots, `${name}.png`) });
}

async function middleOf(page) {
  const box = await page.locator(".live-own canvas").boundingBox();
  return [box.x + box.width / 2, box.y + box.height / 2];
}

/** Share of the points of the first view's picture that are not as the one in its corner. */
async function shareDrawn(page) {
  const png = await page.locator(".live-own").screenshot();
  return page.evaluate(async (bytes) => {
    const picture = await createImageBitmap(new Blob([new Uint8Array(bytes)]));
    const canvas = new OffscreenCanvas(picture.width, picture.height);
    const context = canvas.getContext("2d");
    context.drawImage(picture, 0, 0);
    const { data } = context.getImageData(0, 0, picture.width, picture.height);
    let other = 0;
    for (let i = 0; i < data.length; i += 4) if (Math.abs(data[i] - data[0]) + Math.abs(data[i + 1] - data[1]) + Math.abs(data[i + 2] - data[2]) > 12) other++;
    return (4 * other) / data.length;
  }, [...png]);
}

async function testPressAndRelease(browser) {
  const { page, complaints, requests } = await open(browser, `file://${file}`);
  await isWhole(page);
  assert.ok((await shareDrawn(page)) > 0.05, "the organ is drawn");
  assert.ok((await value(page, "state", "largest")) < 1e-6, "it is at rest");
  assert.equal(await page.locator("h1").textContent(), NAME);
  assert.ok((await page.title()).startsWith(NAME));
  assert.deepEqual(await findBarriers(source, page), []);
  const [x, y] = await middleOf(page);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await until(page, "finger", ">", 0.001);
  await until(page, "state", ">", 0.0005, "largest");
  await until(page, "force", ">", 0.01);
  await settles(page, { energy: [0, 1e-7], force: [0.01, 1e9], difference: [1e-9, 0.3] }); // at rest under the finger
  const mark = await page.locator(".live-touch").boundingBox();
  const away = Math.hypot(mark.x + mark.width / 2 - x, mark.y + mark.height / 2 - y);
  assert.ok(away < 60, `the touched vertex is under the cursor, ${away} pixels away`);
  await shoot(page, "live_pressed");
  const before = await value(page, "finger");
  await page.mouse.move(x + 40, y + 10, { steps: 4 });
  await until(page, "finger", ">", 1.05 * before);
  await page.mouse.up();
  await until(page, "force", "===", 0);
  await until(page, "state", "<", 1e-6, "largest");
  await shoot(page, "live_released");
  assert.deepEqual(complaints, []);
  assert.deepEqual(requests, [`file://${file}`]);
  await page.close();
}

async function testPull(browser) {
  const { page, complaints } = await open(browser, `file://${file}`);
  await isWhole(page);
  const [x, y] = await middleOf(page);
  await page.mouse.move(x, y);
  for (const [shift, sign] of [[false, "<"], [true, ">"]]) {
    if (shift) await page.keyboard.down("Shift");
    await page.mouse.down();
    await until(page, "force", ">", 0.01);
    await until(page, "finger", sign, sign === ">" ? 0.001 : -0.001, "out");
    assert.match(await page.locator("[data-readout=finger]").textContent(), shift ? /pulling$/ : /pressing$/);
    await page.mouse.up();
    if (shift) await page.keyboard.up("Shift");
    await until(page, "force", "===", 0);
    await until(page, "state", "<", 1e-6, "largest");
  }
  assert.deepEqual(complaints, []);
  await page.close();
}

/** Dragged, the finger slides over the skin, as deep as it was, and the finite elements' with it. */
async function testSlide(browser) {
  const { page, complaints } = await open(browser, `file://${file}`);
  await isWhole(page);
  await page.selectOption("#live-drag", "slide");
  const [x, y] = await middleOf(page);
  const touched = () => page.locator(".live-touch").getAttribute("data-vertex");
  await page.mouse.move(x, y);
  await page.mouse.down();
  await until(page, "force", ">", 0.01);
  await until(page, "energy", "<", 1e-7);
  const [first, depth] = [await touched(), await value(page, "finger")];
  await page.mouse.move(x + 70, y + 10, { steps: 7 });
  await page.waitForFunction((before) => document.querySelector(".live-touch").dataset.vertex !== before, first);
  await settles(page, { energy: [0, 1e-7], force: [0.01, 1e9], finger: [0.98 * depth, 1.02 * depth], difference: [1e-9, 0.3] });
  const mark = await page.locator(".live-touch").boundingBox();
  const away = Math.hypot(mark.x + mark.width / 2 - (x + 70), mark.y + mark.height / 2 - (y + 10));
  assert.ok(away < 60, `it is under the cursor, ${away} pixels away`);
  await shoot(page, "live_slid");
  await page.mouse.up();
  await until(page, "force", "===", 0);
  await until(page, "state", "<", 1e-6, "largest");
  assert.deepEqual(complaints, []);
  await page.close();
}

/** From a scene to a fit to the page of what was fitted. */
async function testFit(browser) {
  const scene = join(folder, "bar.yaml");
  const candidates = join(folder, "candidates.yaml");
  const fitted = join(folder, "fitted");
  const out = join(folder, "fitted.html");
  writeFileSync(scene, `schema: palpate/scene/1
mesh: {make: bar, vertices: 200, length_m: 0.1}
material: {young_modulus_pa: 10000, poisson_ratio: 0.45, density_kg_m3: 1000}
clamp: [{half_space: {normal: [1, 0, 0], share: 0.1}, elastic_pa_per_m: 1.0e+6}]
load: [{gravity_m_s2: [0, 0, -9.81]}]
analysis: static
require: {error: {measure: deformation_l2, at_most: 0.3}, time_per_second_s: 1000}
`);
  writeFileSync(candidates, `schema: palpate/candidates/1
simplifiers: [{label: refined, method: palpate.refined, ratios: [0.3]}]
models:
  - {label: edge_node, method: smoothed.edge_node, works: {first: [], second: []}}
`);
  run("fit", scene, "-o", fitted, "--candidates", candidates);
  run("live", fitted, "-o", out);
  const { page, complaints } = await open(browser, `file://${out}`);
  await isWhole(page);
  assert.match(await page.locator(".live-head p").textContent(), /^As palpate fit chose it\./);
  assert.equal(await page.locator("#live-model").inputValue(), "smoothed");
  assert.equal(await page.locator("#live-smoothing").inputValue(), "edge_node");
  const again = page.locator("button", { hasText: "As palpate fit chose it" });
  const engine = () => page.locator("[data-readout=engine]").textContent();
  const [chosen, isAsChosen] = [await engine(), await again.isDisabled()];
  assert.ok(isAsChosen, "it is as it was chosen");
  await page.selectOption("#live-model", "springs");
  await page.waitForFunction((before) => document.querySelector("[data-readout=engine]").textContent !== before, chosen);
  await again.click();
  await page.waitForFunction((before) => document.querySelector("[data-readout=engine]").textContent === before, chosen);
  assert.equal(await page.locator("#live-model").inputValue(), "smoothed");
  assert.ok(await again.isDisabled());
  await isWhole(page);
  const [x, y] = await middleOf(page);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await until(page, "force", ">", 0.001);
  await until(page, "state", ">", 0.0005, "largest");
  await shoot(page, "live_fitted");
  await page.mouse.up();
  await until(page, "force", "===", 0);
  await until(page, "state", "<", 1e-5, "largest");
  assert.deepEqual(complaints, []);
  await page.close();
}

async function testKeyboardAndModels(browser) {
  const { page, complaints } = await open(browser, `file://${file}`, { colorScheme: "dark" });
  await isWhole(page);
  for (const model of ["springs", "smoothed", "reduced"]) {
    await page.selectOption("#live-model", model);
    assert.deepEqual(await findBarriers(source, page), []);
    await page.locator(".live-own canvas").focus();
    await page.waitForTimeout(300); // the views are made anew
    await page.keyboard.press("p");
    await until(page, "force", ">", 0.01);
    await shoot(page, `live_${model}_dark`);
    await page.keyboard.press("r");
    await until(page, "force", "===", 0);
  }
  await page.selectOption("#live-model", "springs");
  const levels = await page.locator("#live-level option").count();
  assert.ok(levels > 1, "there is a simplified mesh");
  const title = page.locator(".live-own").locator("xpath=../h2");
  const before = await title.textContent();
  await page.selectOption("#live-level", String(levels - 1));
  await page.waitForFunction((text) => document.querySelector(".live-view h2")?.textContent !== text, before);
  await isWhole(page);
  await page.locator("button", { hasText: "Press" }).click();
  await until(page, "difference", ">", 0); // the table is that of the whole mesh, whose skin it has
  await page.selectOption("#live-model", "reduced");
  await page.waitForFunction(() => !document.querySelector(".live-other"));
  assert.equal(await page.locator(".live-other").count(), 0, "the table needs no table beside it");
  assert.deepEqual(complaints, []);
  await page.close();
}

async function testBreaking(browser) {
  const { page, complaints } = await open(browser, `file://${file}`);
  await isWhole(page);
  await page.selectOption("#live-model", "springs");
  await page.fill("#live-step", "20");
  await page.locator("#live-step").blur();
  await until(page, "margin", ">", 2);
  await page.locator("button", { hasText: "Press" }).click();
  await until(page, "state", "===", 1);
  assert.match(await page.locator("[data-readout=state]").textContent(), /^broke at vertex \d+/);
  assert.ok(await page.locator(".live-mark:not(.live-touch)").isVisible(), "the vertex is marked");
  await shoot(page, "live_broken");
  await page.fill("#live-step", "");
  await page.locator("#live-step").blur();
  await isWhole(page);
  assert.deepEqual(complaints, []);
  await page.close();
}

async function testBadData(browser) {
  const whole = readFileSync(bare, "utf8");
  const description = (change) => whole.replace(/(<script type="application\/json" id="live-body">)([^<]*)/, (_, tag, text) => {
    const body = JSON.parse(text.replaceAll("\\u003c", "<"));
    return tag + change(body, text);
  });
  const cases = {
    "no JSON": [description(() => "{"), /no JSON/],
    "another schema": [description((body) => JSON.stringify({ ...body, schema: "palpate/live/9" })), /palpate\/live\/1/],
    "no mesh": [description((body) => JSON.stringify({ ...body, levels: [] })), /no mesh/],
    "a short array": [description((body) => (body.levels[0].tets.count = 1e9, JSON.stringify(body))), /tets ends behind/],
    "a wrong vertex": [description((body) => (body.levels[0].tets.at = body.levels[0].points.at, JSON.stringify(body))), /names vertex/],
    "no base64": [whole.replace(/(id="live-arrays">)..../, "$1****"), /base64/],
  };
  for (const [name, [text, message]] of Object.entries(cases)) {
    assert.notEqual(text, whole, name);
    const broken = join(folder, "broken.html");
    writeFileSync(broken, text);
    const { page } = await open(browser, `file://${broken}`);
    const problem = page.locator(".live-problem");
    await problem.waitFor({ state: "visible" });
    assert.match(await problem.textContent(), message, name);
    await page.close();
  }
}

/** Status and text of a request with these headers. */
function ask(port, path, headers) {
  return new Promise((resolve, reject) => {
    http.get({ host: "127.0.0.1", port, path, headers }, (answer) => {
      let text = "";
      answer.on("data", (part) => (text += part)).on("end", () => resolve({ status: answer.statusCode, text }));
    }).on("error", reject);
  });
}

async function testServer(browser) {
  const server = spawn(palpate, ["live", mesh, "--unit-m", "0.06", "--no-table"], { stdio: ["ignore", "pipe", "ignore"] });
  const ended = new Promise((resolve) => server.on("exit", (code) => resolve(code)));
  try {
    const url = await new Promise((resolve, reject) => {
      server.stdout.on("data", (text) => resolve(String(text).trim()));
      server.on("exit", () => reject(new Error("the server ended")));
    });
    assert.match(url, /^http:\/\/127\.0\.0\.1:\d+\/$/);
    const port = Number(new URL(url).port);
    assert.equal((await ask(port, "/", {})).status, 200);
    assert.equal((await ask(port, "/", { Host: `evil.example:${port}` })).status, 403);
    assert.equal((await ask(port, "/", { Origin: "http://evil.example" })).status, 403);
    assert.equal((await ask(port, "/", { Origin: `http://127.0.0.1:${port}` })).status, 200);
    for (const path of ["/etc/passwd", "/../../etc/passwd", "/live.js"]) assert.equal((await ask(port, path, {})).status, 404, path);
    const { page, complaints, requests } = await open(browser, url);
    await isWhole(page);
    assert.match(await page.locator(".live-missing").textContent(), /not asked for/);
    assert.deepEqual(complaints, []);
    assert.deepEqual(requests, [url]);
    await page.close();
  } finally {
    server.kill("SIGINT");
  }
  assert.equal(await ended, 0, "Ctrl-C ends it in order");
}

let code = 0;
const browser = await chromium.launch({ executablePath: process.env.PALPATE_CHROMIUM ?? "/usr/bin/chromium", args: ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"] });
try {
  run("make", "cube", "--vertices", "512", "-o", mesh);
  run("live", mesh, "--unit-m", "0.06", "-o", file);
  run("live", mesh, "--unit-m", "0.06", "--no-table", "-o", bare);
  for (const test of [testPressAndRelease, testPull, testSlide, testFit, testKeyboardAndModels, testBreaking, testBadData, testServer]) {
    await test(browser);
    console.log(`${test.name}: ok`);
  }
} catch (error) {
  console.error(error);
  code = 1;
} finally {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
process.exit(code);

// Opens the pages as a reader would, in Debian's Chromium, and uses them.
//
//     node browser_test.mjs ROOT BUILD [PART_OF_A_NAME]
//
// Pages come from make_pages.py; those of real runs below $PALPATE_PAGES/*/report.html are opened too. Pictures are left in
// BUILD/page/screenshots. Prints a line a test; exit code 1 if any fails.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { findBarriers, startReader } from "./reader.mjs";

const [root, build, wanted = ""] = process.argv.slice(2);
const python = "/usr/bin/python3";
const scripts = join(build, "page");
const { browser, chromium, drawCharts, flags, look, open, PATIENCE, seeBodies, settle } = await startReader(root);
const EVIL_MESH = "<script>alert(1)</script>";
const EVIL_LABEL = "</script><img src=x onerror=alert(2)>";

const pages = mkdtempSync(join(tmpdir(), "palpate-pages-"));
const pictures = join(scripts, "screenshots");
mkdirSync(pictures, { recursive: true });
const made = spawnSync(python, ["-B", join(root, "tests", "page", "make_pages.py"), pages, scripts], { encoding: "utf8" });
assert.equal(made.status, 0, made.stderr);

const tests = [];
const test = (name, run) => tests.push([name, run]);
const at = (name) => join(pages, name, "report.html");

// --- Every page ---------------------------------------------------------------------------------------------------------

const real = process.env.PALPATE_PAGES;
const realPages = real && existsSync(real) ? readdirSync(real).map((name) => join(real, name, "report.html")).filter(existsSync) : [];
const named = ["simplify", "contest", "deform", "frontier", "motion", "engine", "stability", "verify"].map(at);
for (const file of [...named, ...realPages]) {
  const name = file.split("/").at(-2);
  test(`${name}: opens without an error, a request or a barrier, and every chart is drawn`, async () => {
    const { page, trouble, close } = await open(file);
    assert.ok((await page.locator("h1").innerText()).length > 5);
    assert.deepEqual(await page.locator("main > section > h2").allInnerTexts(), ["Verdict", "What was not accepted", "Charts", "Tables", "In 3D", "Provenance"]);
    assert.ok((await page.locator(".verdict p").first().innerText()).endsWith("."));
    await drawCharts(page);
    if (await page.locator("[data-bodies]").count()) {
      await seeBodies(page);
      const { drawn, of } = await look(page);
      assert.ok(drawn > 0.02 * of, `${drawn} of ${of} pixels are drawn`);
    }
    await page.evaluate(() => scrollTo(0, 0));
    await settle(page);
    assert.deepEqual(await page.locator(".fault").allInnerTexts(), []);
    assert.deepEqual(await findBarriers(root, page), []);
    assert.deepEqual(trouble, []);
    assert.ok(readFileSync(file).length < 5e6, "under 5 MB");
    await page.screenshot({ path: join(pictures, `${name}.png`) });
    await close();
  });
}

test("a narrow window has no sideways scrolling, and the dark page is dark", async () => {
  const { page, trouble, close } = await open(at("simplify"), { viewport: { width: 390, height: 800 }, colorScheme: "dark" });
  await page.locator("[data-chart]").first().scrollIntoViewIfNeeded();
  await page.locator("[data-chart] svg").first().waitFor();
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor.match(/\d+/g).map(Number));
  assert.ok((await ground()).every((channel) => channel < 60), "dark ground");
  assert.deepEqual(await findBarriers(root, page), []);
  await page.screenshot({ path: join(pictures, "narrow_dark.png") });
  await page.locator(".theme select").selectOption("light");
  assert.ok((await ground()).every((channel) => channel > 240), "light ground when a reader chooses it");
  await page.locator(".theme select").selectOption("system");
  assert.ok((await ground()).every((channel) => channel < 60));
  assert.deepEqual(trouble, []);
  await close();
});

// --- Tables -------------------------------------------------------------------------------------------------------------

test("a table sorts by numbers and by words, by mouse and by keyboard, and empty cells come last", async () => {
  const { page, trouble, close } = await open(at("simplify"));
  const table = page.locator("div.table", { hasText: "Time of accepted answers" });
  const column = async (number) => (await table.locator(`tbody tr > :nth-child(${number})`).evaluateAll((cells) => cells.map((cell) => cell.dataset.value ?? cell.textContent)));
  const head = table.locator("thead th").nth(3);
  assert.equal(await head.getAttribute("aria-sort"), null);
  await head.locator("button").click();
  assert.equal(await head.getAttribute("aria-sort"), "ascending");
  const rising = (await column(4)).map(Number);
  assert.ok(rising.length >= 6 && new Set(rising).size > 1);
  assert.deepEqual(rising, [...rising].sort((a, b) => a - b));
  await head.locator("button").focus();
  await page.keyboard.press("Enter");
  assert.equal(await head.getAttribute("aria-sort"), "descending");
  assert.deepEqual((await column(4)).map(Number), [...rising].reverse());
  await table.locator("thead th").nth(1).locator("button").click();
  assert.equal(await head.getAttribute("aria-sort"), null);
  const words = await column(2);
  assert.deepEqual(words, [...words].sort());
  const quality = page.locator("div.table", { hasText: "Quality of accepted answers" });
  for (const direction of ["ascending", "descending"]) {
    await quality.locator("thead th").nth(2).locator("button").click();
    assert.equal(await quality.locator("thead th").nth(2).getAttribute("aria-sort"), direction);
    assert.equal(await quality.locator("tbody tr").last().locator("td").nth(1).innerText(), "");  // the input has no cases
  }
  assert.deepEqual(trouble, []);
  await close();
});

test("a table filters by words, says how many rows are left, and copies those as CSV", async () => {
  const { page, trouble, close } = await open(at("simplify"));
  const table = page.locator("div.table", { hasText: "Quality of accepted answers" });
  const visible = () => table.locator("tbody tr:visible").count();
  const all = await visible();
  await table.locator("input[type=search]").fill("kidney hierarchical");
  assert.equal(await visible(), 1);
  assert.equal(await table.locator("output").innerText(), `1 of ${all} rows`);
  await table.locator("button", { hasText: "Copy as CSV" }).click();
  await table.locator("button", { hasText: "Copied" }).waitFor();
  const [header, row, ...rest] = (await page.evaluate(() => navigator.clipboard.readText())).trim().split(/\r?\n/);
  assert.match(header, /^mesh,label,cases,/);
  assert.match(row, /^kidney,hierarchical,1,6300,75,/);
  assert.deepEqual(rest, []);
  await table.locator("input[type=search]").fill("");
  assert.equal(await visible(), all);
  assert.deepEqual(trouble, []);
  await close();
});

test("markup in a record stays text, in tables, charts, data and the plan", async () => {
  const { page, trouble, close } = await open(at("simplify"));
  assert.ok((await page.locator("h1").innerText()).includes(EVIL_MESH));
  assert.ok((await page.locator("#not-accepted tbody tr").first().innerText()).includes(EVIL_LABEL));
  assert.ok((await page.locator("#tables").innerText()).includes(EVIL_MESH));
  await drawCharts(page);
  assert.ok((await page.locator(".panel-title").allInnerTexts()).includes(EVIL_MESH));
  await page.locator("details", { hasText: "The plan" }).locator("summary").click();
  assert.ok((await page.locator("details pre").innerText()).includes(EVIL_LABEL));
  await seeBodies(page);
  assert.ok((await page.locator("#organs select").first().locator("option").allInnerTexts()).includes(EVIL_MESH));
  assert.equal(await page.locator("img[src=x]").count(), 0);
  assert.deepEqual(trouble, []);
  await close();
});

// --- Charts -------------------------------------------------------------------------------------------------------------

test("hovering a point shows its record; a click opens it with the command that repeats it", async () => {
  const { page, trouble, close } = await open(at("frontier"));
  await drawCharts(page); // a chart that is drawn later moves those below it away from the mouse
  const chart = page.locator("figure", { hasText: "What accuracy costs: first answer" });
  await chart.scrollIntoViewIfNeeded();
  const dot = chart.locator(".panels g[aria-label=dot] path").first();
  await dot.waitFor();
  const box = await dot.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  const tip = chart.locator("g[aria-label=tip]");
  await tip.locator("text").first().waitFor();
  const said = await tip.textContent();
  assert.match(said, /error of the deformation: [\d.]+ %/);
  assert.match(said, /time of a first answer: [\d.]+ ms \[[\d.]+, [\d.]+\]/);
  await page.screenshot({ path: join(pictures, "hover.png") });
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  const dialog = page.locator("dialog.details");
  await dialog.waitFor();
  assert.match(await dialog.locator("pre").innerText(), /^\.\/palpate run plan\.yaml --case '?bar\//);
  assert.match(await dialog.innerText(), /model\s+(fast|good|beaten)/);
  await page.keyboard.press("Escape");
  await dialog.waitFor({ state: "detached" });
  assert.deepEqual(trouble, []);
  await close();
});

test("a chart is saved as SVG and as PNG", async () => {
  const { page, trouble, close } = await open(at("deform"));
  const chart = page.locator("figure", { hasText: "Error of each model" });
  await chart.scrollIntoViewIfNeeded();
  for (const [kind, start] of [["SVG", "<svg"], ["PNG", "\x89PNG"]]) {
    const [file] = await Promise.all([page.waitForEvent("download"), chart.locator("button", { hasText: kind }).click()]);
    const content = readFileSync(await file.path(), "latin1");
    assert.ok(content.startsWith(start), `${kind} starts with ${start}`);
    assert.ok(content.length > 2000);
  }
  assert.deepEqual(trouble, []);
  await close();
});

// --- 3D -----------------------------------------------------------------------------------------------------------------

test("a body is drawn, turns under a drag and under the keys with its neighbour, and comes back", async () => {
  const { page, trouble, close } = await open(at("simplify"));
  await seeBodies(page);
  const [first, second] = [await look(page, 0), await look(page, 1)];
  assert.ok(first.drawn > 0.05 * first.of && first.drawn < 0.9 * first.of, `${first.drawn} of ${first.of}`);
  const box = await page.locator("canvas.organ-canvas").first().boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 70, box.y + box.height / 2 + 30, { steps: 5 });
  await page.mouse.up();
  await settle(page);
  const [dragged, neighbour] = [await look(page, 0), await look(page, 1)];
  assert.notEqual(dragged.pixels, first.pixels);
  assert.notEqual(neighbour.pixels, second.pixels);
  await page.locator("canvas.organ-canvas").first().focus();
  await page.keyboard.press("ArrowLeft");
  await settle(page);
  assert.notEqual((await look(page)).pixels, dragged.pixels);
  await page.locator("button", { hasText: "Look as at first" }).click();
  await page.mouse.move(5, 5);
  await page.evaluate(() => document.activeElement.blur());
  await settle(page);
  const back = await look(page);
  assert.ok(Math.abs(back.drawn - first.drawn) <= 0.01 * first.drawn, `${back.drawn} and ${first.drawn} pixels`);
  assert.deepEqual(trouble, []);
  await close();
});

test("surface, wireframe and cut differ; the cut takes tetrahedra away; colours have a legend", async () => {
  const { page, trouble, close } = await open(at("simplify"));
  await seeBodies(page);
  const seen = new Map();
  for (const mode of ["surface", "edges", "wireframe", "cut"]) {
    await page.locator("label", { hasText: "Shown as" }).locator("select").selectOption(mode);
    await settle(page);
    seen.set(mode, await look(page));
    await page.locator(".body-views").screenshot({ path: join(pictures, `mode_${mode}.png`) });
  }
  assert.equal(new Set([...seen.values()].map(({ pixels }) => pixels)).size, 4);
  const cut = page.locator("label", { hasText: "Cut" }).locator("input");
  await cut.fill("1");
  await settle(page);
  const whole = await look(page);
  await cut.fill("-0.6");
  await settle(page);
  const little = await look(page);
  assert.ok(little.drawn < 0.9 * whole.drawn, `${little.drawn} of ${whole.drawn}`);
  const legend = page.locator(".organ-legend").first();
  assert.match(await legend.innerText(), /quality\s+0\s+0\.5\s+1/);
  await page.locator("label", { hasText: "Coloured by" }).locator("select").selectOption("");
  assert.ok(await legend.isHidden());
  assert.deepEqual(trouble, []);
  await close();
});

test("the error against the reference has its greatest value in the legend, and a larger deformation moves the body", async () => {
  const { page, trouble, close } = await open(at("deform"));
  await seeBodies(page);
  await page.locator("label", { hasText: "isotropy" }).locator("input").waitFor();
  await page.locator("label", { hasText: "Coloured by" }).locator("select").selectOption("error against the reference");
  // isotropy is bent by 1.05 x x in the place of x x, x up to 0.1 m: 0.5 mm at the end
  assert.match(await page.locator(".organ-legend").nth(1).innerText(), /error against the reference, mm\s+0\s+0\.25\s+0\.5/);
  const before = await look(page, 1);
  await page.locator("label", { hasText: "Deformation times" }).locator("input").fill("10");
  await settle(page);
  assert.notEqual((await look(page, 1)).pixels, before.pixels);
  assert.deepEqual(trouble, []);
  await close();
});

test("a motion plays, stops, and its slider shows its frames", async () => {
  const { page, trouble, close } = await open(at("engine"));
  await seeBodies(page);
  const bar = page.locator(".playback");
  const slider = bar.locator("input");
  assert.equal(await slider.inputValue(), "10");  // the frame farthest from rest
  const farthest = await look(page);
  await slider.fill("0");
  await settle(page);
  const rest = await look(page);
  assert.notEqual(rest.pixels, farthest.pixels);
  assert.equal(await bar.locator("output").innerText(), "0.000 s");
  await bar.locator("button", { hasText: "Play" }).click();
  await page.waitForFunction(() => Number(document.querySelector(".playback input").value) >= 2);
  await bar.locator("button", { hasText: "Pause" }).click();
  const frame = Number(await slider.inputValue());
  assert.ok(frame >= 2 && frame < 20, `paused at ${frame}`);
  await settle(page);
  assert.notEqual((await look(page)).pixels, rest.pixels);
  assert.equal(Number(await slider.inputValue()), frame);
  await page.screenshot({ path: join(pictures, "motion.png") });
  assert.deepEqual(trouble, []);
  await close();
});

test("answers of the contest motion move side by side with one slider", async () => {
  const { page, trouble, close } = await open(at("motion"));
  await seeBodies(page);
  assert.deepEqual((await page.locator(".body-views figcaption").allInnerTexts()).map((text) => text.split(" ")[0]), ["a", "b"]);
  const seen = [];
  for (const frame of ["0", "10"]) {
    await page.locator(".playback input").fill(frame);
    await settle(page);
    seen.push(await look(page, 0), await look(page, 1));
  }
  assert.equal(await page.locator(".playback output").innerText(), "1.000 s");
  assert.notEqual(seen[0].pixels, seen[2].pixels);
  assert.notEqual(seen[1].pixels, seen[3].pixels);
  assert.deepEqual(trouble, []);
  await close();
});

test("the bodies are saved as a picture", async () => {
  const { page, trouble, close } = await open(at("engine"));
  await seeBodies(page);
  const [file] = await Promise.all([page.waitForEvent("download"), page.locator("button", { hasText: "Save picture" }).click()]);
  const content = readFileSync(await file.path());
  assert.equal(content.subarray(1, 4).toString("latin1"), "PNG");
  assert.equal(content.readUInt32BE(16) % 1000, 0, "1000 pixels a body");
  assert.deepEqual(trouble, []);
  await close();
});

// --- What is broken -----------------------------------------------------------------------------------------------------

/** A copy of a page with its text changed. */
function damaged(name, from, to) {
  const text = readFileSync(at(name), "utf8");
  const changed = text.replace(from, to);
  assert.notEqual(changed, text);
  const file = join(pages, `damaged-${Math.random().toString(36).slice(2)}.html`);
  writeFileSync(file, changed);
  return file;
}

for (const [what, from, to, place] of [
  ["meshes that are no JSON", /(id="bodies-data">)\{/, "$1[", "#bodies"],
  ["meshes whose bytes are broken", /("positions":\{"type":"f32","data":")[^"]{20}/, "$1????????????????????", "#bodies"],
  ["a mesh with too few vertices", /"vertices":\d+/, '"vertices":7', "#bodies"],
  ["a mesh that names a vertex that is not there", /"indices":\{"type":"u16","data":"[^"]*"/, '"indices":{"type":"u32","data":"eJwDAAAAAAE="', "#bodies"],
  ["a chart without its data", /id="(chart-\d+-data)"/, 'id="lost"', "[data-chart]"],
]) {
  test(`bad data shows a message, not a blank page: ${what}`, async () => {
    const { page, close } = await open(damaged("engine", from, to));
    await page.locator(place).first().scrollIntoViewIfNeeded();
    const fault = page.locator(".fault").first();
    await fault.waitFor();
    assert.match(await fault.innerText(), /(could not be shown|could not be drawn|Not shown in 3D): .+\./);
    assert.ok((await page.locator(".verdict p").first().innerText()).length > 20);
    assert.ok((await page.locator("table").count()) > 2);
    await close();
  });
}

test("without WebGL the rest of the page stands, and it says why there is no 3D", async () => {
  const plain = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--disable-gpu", "--disable-3d-apis", ...flags.filter((flag) => flag === "--no-sandbox")] });
  const page = await plain.newPage();
  page.setDefaultTimeout(PATIENCE);
  await page.goto(pathToFileURL(at("engine")).href);
  await page.locator("#organs").scrollIntoViewIfNeeded();
  const fault = page.locator("#organs .fault").first();
  await fault.waitFor({ timeout: PATIENCE });
  assert.match(await fault.innerText(), /no WebGL 2/);
  await plain.close();
});

test("without JavaScript the page reads: verdict, tables, and the charts as pictures", async () => {
  const { page, trouble, close } = await open(at("simplify"), { javaScriptEnabled: false });
  assert.ok(await page.locator(".verdict p").first().isVisible());
  assert.ok((await page.locator("img.drawn").count()) >= 2);
  assert.ok((await page.locator("tbody tr").count()) > 10);
  assert.match(await page.locator("#organs").innerText(), /take JavaScript and WebGL/);
  await page.screenshot({ path: join(pictures, "without_javascript.png") });
  assert.deepEqual(trouble, []);
  await close();
});

test("a page written without its scripts says so, and has its pictures and tables", async () => {
  const { page, trouble, close } = await open(at("bare"));
  assert.match(await page.locator(".warning").first().innerText(), /has no scripts/);
  assert.ok((await page.locator("img.drawn:visible").count()) >= 2);
  assert.equal(await page.locator("script").count(), 0);
  assert.match(await page.locator("#organs").innerText(), /without its scripts/);
  assert.deepEqual(trouble, []);
  await close();
});

test("the watcher of these tests sees a request, an error and a dialog", async () => {
  const file = join(pages, "watched.html");
  writeFileSync(file, "<!doctype html><img src='beside.png'><script>alert(3); throw new Error('on purpose')</script>");
  const { page, trouble, close } = await open(file);
  await settle(page);
  assert.ok(trouble.some((line) => line.startsWith("request: ")) && trouble.includes("dialog: 3") && trouble.includes("error: on purpose"), trouble.join("; "));
  await close();
});

// --- All of them --------------------------------------------------------------------------------------------------------

let failed = 0;
const chosen = tests.filter(([name]) => name.includes(wanted));
for (const [name, run] of chosen) {
  const began = performance.now();
  try {
    await run();
    console.log(`ok      ${name} (${((performance.now() - began) / 1000).toFixed(1)} s)`);
  } catch (error) {
    failed++;
    console.log(`FAILED  ${name}\n        ${String(error.stack ?? error).split("\n").slice(0, 12).join("\n        ")}`);
  }
}
await browser.close();
rmSync(pages, { recursive: true, force: true });
console.log(`${chosen.length - failed} of ${chosen.length} passed; pictures: ${pictures}`);
process.exit(failed || !chosen.length ? 1 : 0);

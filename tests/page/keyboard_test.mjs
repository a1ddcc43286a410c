// Reads pages by the keyboard alone: tables, charts, records, bodies in 3D; and follows a point of a chart to its body.
//
//     node keyboard_test.mjs ROOT BUILD
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";
import { findBarriers, startReader } from "./reader.mjs";

const [root, build] = process.argv.slice(2);
const pages = mkdtempSync(join(tmpdir(), "palpate-keyboard-"));
const pictures = join(build, "page", "screenshots");
mkdirSync(pictures, { recursive: true });
const made = spawnSync("/usr/bin/python3", ["-B", join(root, "tests", "page", "make_pages.py"), pages, join(build, "page"), "deform", "engine"], { encoding: "utf8" });
assert.equal(made.status, 0, made.stderr);
const { browser, look, open, seeBodies, settle } = await startReader(root);
after(async () => {
  await browser.close();
  rmSync(pages, { recursive: true, force: true });
});
const at = (name) => join(pages, name, "report.html");
/** What has the focus: its tag, role and name. */
const focused = (page) => page.evaluate(() => {
  const { activeElement: own } = document;
  return { tag: own.tagName.toLowerCase(), role: own.getAttribute("role"), name: own.getAttribute("aria-label") ?? own.labels?.[0]?.textContent ?? own.textContent.trim(), isSeen: own.matches(":focus-visible") };
});

test("Tab goes through a page from its top to its end, and each stop has a name and can be seen to have the focus", async () => {
  const { page, trouble, close } = await open(at("deform"));
  await seeBodies(page);
  await page.evaluate(() => scrollTo(0, 0));
  const stops = [];
  for (let k = 0; k < 200; k++) {
    await page.keyboard.press("Tab");
    const stop = await focused(page);
    if (stop.tag === "body") break;
    assert.ok(stop.name && stop.isSeen, `stop ${k}: ${JSON.stringify(stop)}`);
    stops.push(stop);
  }
  const first = (found) => stops.findIndex(found);
  const order = [
    first(({ name }) => name === "To the verdict"), first(({ name }) => name === "Charts"), first(({ role }) => role === "application"),
    first(({ name }) => name.startsWith("Filter rows of: Targets")), first(({ name }) => name.startsWith("Shown as")), first(({ tag }) => tag === "canvas"),
  ];
  order.forEach((place, k) => assert.ok(place >= 0 && (k === 0 || place > order[k - 1]), order.join(" ")));
  assert.deepEqual(trouble, []);
  await close();
});

test("arrow keys go through the points of a chart, which are said; Enter opens a record, Escape returns to the point", async () => {
  const { page, trouble, close } = await open(at("deform"));
  const chart = page.locator("figure", { hasText: "Error of each model" });
  await chart.scrollIntoViewIfNeeded();
  const panel = chart.locator("[role=application]").first();
  await panel.waitFor();
  assert.match(await panel.getAttribute("aria-label"), /^Error of each model, bar_tension.*, 3 points\. Arrow keys/);
  await panel.focus();
  const said = panel.locator("[role=status]");
  const heard = [];
  for (const key of ["ArrowRight", "ArrowRight", "ArrowRight", "ArrowRight", "ArrowLeft", "Home", "End"]) {
    await page.keyboard.press(key);
    heard.push((await said.textContent()).match(/isotropy|p1|third/)[0]);
  }
  assert.deepEqual(heard, ["isotropy", "p1", "third", "third", "p1", "isotropy", "third"]);
  await page.keyboard.press("Home");
  assert.match(await said.textContent(), /relative L2 error: 5 %/);
  assert.match(await chart.locator("g[aria-label=tip]").first().textContent(), /isotropy/, "the tip is shown beside the point");
  await page.screenshot({ path: join(pictures, "chart_by_keyboard.png") });
  await page.keyboard.press("Enter");
  const dialog = page.locator("dialog.details");
  await dialog.waitFor();
  assert.match(await dialog.innerText(), /--case bar_tension\/isotropy/);
  assert.deepEqual(await findBarriers(root, page), []);
  await page.keyboard.press("Escape");
  await dialog.waitFor({ state: "detached" });
  assert.equal((await focused(page)).role, "application");
  await page.keyboard.press("Tab");
  assert.equal(await said.textContent(), "");
  assert.deepEqual(trouble, []);
  await close();
});

test("a point's record opens its body in 3D, beside the reference", async () => {
  const { page, trouble, close } = await open(at("deform"));
  const chart = page.locator("figure", { hasText: "Error of each model" });
  await chart.scrollIntoViewIfNeeded();
  const panel = chart.locator("[role=application]").nth(1); // of kidney_gravity: not what is shown at first
  await panel.waitFor();
  await panel.focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Enter");
  await page.locator("dialog button", { hasText: "Show in 3D" }).click();
  await page.locator("dialog").waitFor({ state: "detached" });
  await page.waitForFunction(() => document.querySelectorAll(".body-views canvas").length === 2);
  await settle(page);
  assert.deepEqual(await page.locator(".body-views figcaption strong").allInnerTexts(), ["reference", "p1"]);
  assert.equal(await page.locator("#organs select").first().inputValue(), "kidney_gravity");
  const { drawn, of } = await look(page, 1);
  assert.ok(drawn > 0.02 * of, `${drawn} of ${of} pixels are drawn`);
  const top = await page.locator("#bodies").evaluate((place) => place.getBoundingClientRect().top);
  assert.ok(top >= 0 && top < 850, `the reader is brought there, ${top}`);
  assert.deepEqual(trouble, []);
  await close();
});

test("a view turns by its keys, a motion is played by them, and both say what they are", async () => {
  const { page, trouble, close } = await open(at("engine"));
  await seeBodies(page);
  const canvas = page.locator("canvas.organ-canvas").first();
  assert.match(await canvas.getAttribute("aria-label"), /in 3D\. Arrow keys turn it/);
  const before = await look(page);
  await canvas.focus();
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("+");
  await settle(page);
  assert.notEqual((await look(page)).pixels, before.pixels);
  await page.locator(".playback input").focus();
  await page.keyboard.press("Home");
  assert.equal(await page.locator(".playback output").innerText(), "0.000 s");
  await page.keyboard.press("ArrowRight");
  assert.equal(await page.locator(".playback output").innerText(), "1.000 s");
  assert.deepEqual(trouble, []);
  await close();
});

test("the watcher for barriers sees a picture without words, a field without a name and text that is too faint", async () => {
  const file = join(pages, "barred.html");
  writeFileSync(file, `<!doctype html><html lang="en"><title>t</title><main><h1>A page</h1><img src="data:image/gif;base64,R0lGODlhAQABAAAAACw=">
    <input><p style="color: #bbbbbb; background: #ffffff">faint words</p><ul><li>a</ul><a href="#b">on</a><p id="b">b</p></main>`);
  const { page, close } = await open(file);
  const found = await findBarriers(root, page);
  for (const rule of ["image-alt", "label", "color-contrast"]) assert.ok(found.some((line) => line.startsWith(`${rule}:`)), `${rule}: ${found.join("\n")}`);
  await close();
});

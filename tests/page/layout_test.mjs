// Where things lie on the page: on paper, in a narrow window, and names beside the points of charts.
//
//     node layout_test.mjs ROOT BUILD
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";
import { startReader } from "./reader.mjs";

const [root, build] = process.argv.slice(2);
const pages = mkdtempSync(join(tmpdir(), "palpate-layout-"));
const made = spawnSync("/usr/bin/python3", ["-B", join(root, "tests", "page", "make_pages.py"), pages, join(build, "page"), "long_names", "engine", "stability", "deform"], { encoding: "utf8" });
assert.equal(made.status, 0, made.stderr);
const { browser, drawCharts, open, seeBodies } = await startReader(root);
after(async () => {
  await browser.close();
  rmSync(pages, { recursive: true, force: true });
});
const at = (name) => join(pages, name, "report.html");

test("on paper tables have their heads, no arrows to sort by, and are no wider than the sheet", async () => {
  const sheet = 1000; // A4 across, without its margins
  for (const name of ["long_names", "engine"]) {
    const { page, close } = await open(at(name), { viewport: { width: sheet, height: 700 } });
    await page.emulateMedia({ media: "print" });
    const tables = await page.locator("table").evaluateAll((all) => all.map((table) => ({
      width: table.getBoundingClientRect().width,
      heads: [...table.tHead.rows[0].cells].filter((head) => head.textContent).map((head) => [head.innerText.trim(), getComputedStyle(head.querySelector("button"), "::after").content]),
    })));
    assert.ok(tables.length >= 2);
    for (const { width, heads } of tables) {
      assert.ok(width <= sheet, `${width} pixels wide`);
      for (const [text, arrow] of heads) assert.ok(text && ["none", "normal"].includes(arrow), `${text} ${arrow}`);
    }
    await close();
  }
});

for (const width of [1200, 400]) {
  test(`in ${width} pixels the page does not scroll sideways and no name of a row is cut off or lies over another panel`, async () => {
    const { page, trouble, close } = await open(at("long_names"), { viewport: { width, height: 800 } });
    await drawCharts(page);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
    const found = await page.locator("#charts .panels svg").evaluateAll((all) => all.map((svg) => {
      const box = svg.getBoundingClientRect();
      const texts = [...svg.querySelectorAll("[aria-label='y-axis tick label'] text")].map((text) => [text.textContent, text.getBoundingClientRect()]);
      return { names: texts.length, out: texts.filter(([, own]) => own.left < box.left - 1 || own.right > box.right + 1).map(([text]) => text) };
    }));
    assert.ok(found.some(({ names }) => names > 0));
    assert.deepEqual(found.flatMap(({ out }) => out), []);
    assert.deepEqual(trouble, []);
    await close();
  });
}

test("in a narrow window the legend of a body is a strip along its lower edge", async () => {
  const { page, close } = await open(at("deform"), { viewport: { width: 400, height: 800 } });
  await seeBodies(page);
  const [legend, view] = await Promise.all([".organ-legend", ".organ-view"].map((name) => page.locator(name).first().boundingBox()));
  assert.ok(legend.height > 0 && legend.height < 36, `${legend.height} pixels high`);
  assert.ok(Math.abs(legend.y + legend.height - view.y - view.height) < 2 && Math.abs(legend.width - view.width) < 3);
  await close();
});

test("what a colour stands for is said where the rows of a chart do not, and nowhere else", async () => {
  const { page, close } = await open(at("stability"));
  await drawCharts(page);
  const legend = (title) => page.locator("figure.chart", { has: page.locator("strong", { hasText: title }) }).locator(".legend li").allInnerTexts();
  assert.deepEqual(await legend("Measured stable step over the predicted one"), ["cube", "kidney"]);
  assert.deepEqual(await legend("How runs ended"), []);
  await close();
  const { page: other, close: end } = await open(at("long_names"));
  await drawCharts(other);
  assert.equal(await other.locator("figure.chart", { has: other.locator("strong", { hasText: "Time of the methods" }) }).locator(".legend").count(), 0);
  await end();
});

test("a label looks alike on all charts of a page", async () => {
  const { page, close } = await open(at("long_names"));
  await drawCharts(page);
  const coloursOf = (title, rows) => page.locator("figure.chart", { has: page.locator("strong", { hasText: title }) }).evaluateAll(
    (all, which) => [...new Set(all.flatMap((figure) => [...figure.querySelectorAll(which)].map((mark) => mark.getAttribute("stroke") ?? mark.getAttribute("fill"))))], rows);
  const times = await coloursOf("Time of the methods", "[aria-label='dot'] path");
  assert.equal(times.length, 3);
  assert.deepEqual(await coloursOf("Quality of the tetrahedra: kidney, 22% removed", "[aria-label='rect'] rect"), times.slice(1), "where the first label is not there");
  await close();
});

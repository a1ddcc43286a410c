// The thesis's figures from a page (page/figures/draw_figures.mjs): the same run gives the same bytes, no still is blank, and they differ
// where the body does.
//
//     node figures_test.mjs ROOT BUILD
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { readPixels, startReader } from "./reader.mjs";

const [root, build] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "palpate-figures-"));
const draw = (...words) => spawnSync(process.execPath, [join(root, "page", "figures", "draw_figures.mjs"), ...words], { encoding: "utf8" });
const WIDTH = "240";

/** What of a picture is not as its corner: a share of its points. */
async function shareDrawn(page, file) {
  const { drawn, of } = await readPixels(page, readFileSync(file));
  return drawn / of;
}

function testSamePixels(run) {
  const outs = ["first", "second"].map((name) => join(folder, name));
  for (const out of outs) {
    const done = draw(out, run, "--width", WIDTH);
    assert.equal(done.status, 0, done.stderr);
  }
  const names = outs.map((out) => readdirSync(out, { recursive: true }).filter((name) => name.includes(".")).sort());
  assert.deepEqual(names[0], names[1]);
  assert.equal(names[0].filter((name) => name.endsWith(".png")).length, 27, "nine moments in three ways");
  for (const name of names[0]) assert.ok(readFileSync(join(outs[0], name)).equals(readFileSync(join(outs[1], name))), `${name} is the same twice`);
  return names[0].filter((name) => name.endsWith(".png")).map((name) => join(outs[0], name));
}

async function testStills(files) {
  const { browser } = await startReader(root);
  try {
    const page = await browser.newPage();
    for (const file of files) {
      const share = await shareDrawn(page, file);
      assert.ok(share > 0.02 && share < 0.9, `${file}: ${share} of it is drawn`);
      assert.equal(readFileSync(file).readUInt32BE(16), Number(WIDTH), "as wide as asked for");
    }
  } finally {
    await browser.close();
  }
  const still = (how, moment) => readFileSync(files.find((file) => file.includes(`${how}_4.${moment}_`)));
  for (const how of ["shaded", "wireframe", "displacement"]) {
    const different = ["06", "07", "08", "09", "10", "11", "12", "13"].map((moment) => still(how, moment).toString("base64"));
    assert.equal(new Set(different).size, different.length, `${how}: each moment is a picture of its own`);
    assert.ok(still(how, "14").equals(still(how, "06")), `${how}: back is as at first`);
  }
}

function testRefusals() {
  for (const words of [[], ["out"], ["out", "run", "--width", "none"], ["out", "run", "--size", "3"]]) {
    const done = draw(...words);
    assert.equal(done.status, 2, words.join(" "));
    assert.match(done.stderr, /usage:/);
  }
  const bare = join(folder, "bare");
  mkdirSync(bare);
  writeFileSync(join(bare, "report.html"), "<!doctype html><title>nothing</title>");
  const done = draw(join(folder, "none"), bare);
  assert.equal(done.status, 1);
  assert.match(done.stderr, /shows no bodies/);
}

let code = 0;
try {
  const made = spawnSync("/usr/bin/python3", ["-B", join(root, "tests", "page", "make_pages.py"), join(folder, "pages"), join(build, "page"), "figures"], { encoding: "utf8" });
  assert.equal(made.status, 0, made.stderr);
  testRefusals();
  await testStills(testSamePixels(join(folder, "pages", "figures")));
} catch (error) {
  console.error(error);
  code = 1;
} finally {
  rmSync(folder, { recursive: true, force: true });
}
process.exit(code);

// The thesis's figures from pages (page/figures/draw_figures.mjs): the same run gives the same bytes, no still is blank, and they differ
// where the body does. One command for all of them (thesis_figures.mjs) runs what it says, and each figure is there under its number.
//
//     node figures_test.mjs ROOT BUILD
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { chmodSync, existsSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
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
  assert.equal(names[0].filter((name) => name.endsWith(".png")).length, 30, "nine moments in three ways, and three stills");
  for (const name of names[0]) assert.ok(readFileSync(join(outs[0], name)).equals(readFileSync(join(outs[1], name))), `${name} is the same twice`);
  return names[0].filter((name) => name.endsWith(".png")).map((name) => join(outs[0], name));
}

async function testNotBlank(files) {
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
}

async function testStills(files) {
  await testNotBlank(files);
  const still = (how, moment) => readFileSync(files.find((file) => file.includes(`${how}_4.${moment}_`)));
  for (const how of ["shaded", "wireframe", "displacement"]) {
    const different = ["06", "07", "08", "09", "10", "11", "12", "13"].map((moment) => still(how, moment).toString("base64"));
    assert.equal(new Set(different).size, different.length, `${how}: each moment is a picture of its own`);
    assert.ok(still(how, "14").equals(still(how, "06")), `${how}: back is as at first`);
  }
}

const all = (words, cwd = folder) => spawnSync(process.execPath, [join(root, "page", "figures", "thesis_figures.mjs"), ...words], { encoding: "utf8", cwd });

/** All figures by one command; a ./palpate of the test's own copies runs that are made already. */
function testAllByOneCommand(runs) {
  const top = join(folder, "top");
  mkdirSync(top);
  const asked = join(top, "asked.txt");
  writeFileSync(join(top, "palpate"), `#!/bin/sh
echo "$@" >> "${asked}"
for last in "$@"; do :; done
mkdir -p "$last" && cp -r "${runs}/$(basename "$last")/." "$last"
`);
  chmodSync(join(top, "palpate"), 0o755);
  const done = all(["out", "--width", WIDTH], top);
  assert.equal(done.status, 0, done.stderr);
  assert.deepEqual(readFileSync(asked, "utf8").trim().split("\n"),
    ["run thesis_histograms --only kidney --out out/runs/histograms", "run thesis_figures --out out/runs/palpation"]);
  const out = join(top, "out");
  const names = readdirSync(out).filter((name) => name.startsWith("figure_")).sort();
  assert.deepEqual(names.flatMap((name) => name.match(/^figure_4\.(\d\d)(?:-4\.(\d\d))?_/).slice(1).filter(Boolean)).map(Number), Array.from({ length: 16 }, (_, i) => i + 2));
  const page = readFileSync(join(out, "index.html"), "utf8");
  const shown = [...page.matchAll(/src="([^"]+)"/g)].map((match) => match[1]);
  for (const name of [...names, ...shown]) assert.ok(shown.includes(name) && existsSync(join(out, name)), name);
  const taken = all(["again", "--runs", "out/runs", "--width", WIDTH], top);
  assert.equal(taken.status, 0, taken.stderr);
  for (const name of [...shown, "index.html"]) assert.ok(readFileSync(join(out, name)).equals(readFileSync(join(top, "again", name))), `${name} is the same twice`);
  const pictures = new Set(names.map((name) => readFileSync(join(out, name)).toString("base64")));
  assert.equal(pictures.size, names.length - 1, "all differ but back, which is as undeformed");
  return names.map((name) => join(out, name));
}

function testRefusalsOfAll() {
  for (const words of [[], ["out", "more"], ["out", "--width", "wide"], ["out", "--size", "3"]]) {
    const done = all(words);
    assert.equal(done.status, 2, words.join(" "));
    assert.match(done.stderr, /usage:/);
  }
  const nowhere = all(["nowhere"]);
  assert.equal(nowhere.status, 1);
  assert.match(nowhere.stderr, /there is no \.\/palpate/);
  const top = join(folder, "failing");
  mkdirSync(top);
  writeFileSync(join(top, "palpate"), "#!/bin/sh\nexit 4\n");
  chmodSync(join(top, "palpate"), 0o755);
  const failing = all(["out"], top);
  assert.equal(failing.status, 1);
  assert.match(failing.stderr, /the run of thesis_histograms: ended with exit code 4/);
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
  const made = spawnSync("/usr/bin/python3", ["-B", join(root, "tests", "page", "make_pages.py"), join(folder, "pages"), join(build, "page"), "thesis/histograms", "thesis/palpation"], { encoding: "utf8" });
  assert.equal(made.status, 0, made.stderr);
  testRefusals();
  testRefusalsOfAll();
  const runs = join(folder, "pages", "thesis");
  await testStills(testSamePixels(join(runs, "palpation")));
  await testNotBlank(testAllByOneCommand(runs).slice(1));
} catch (error) {
  console.error(error);
  code = 1;
} finally {
  rmSync(folder, { recursive: true, force: true });
}
process.exit(code);

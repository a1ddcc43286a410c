// The thesis's figures 4.2-4.17 anew, by one command, at the top of the repository:
//
//     node page/figures/thesis_figures.mjs OUT [--width PIXELS] [--runs FOLDER]
//
// Runs the plans thesis_histograms (of the kidney) and thesis_figures to OUT/runs/histograms and OUT/runs/palpation, or takes those that are
// in FOLDER; draws all that their pages show to OUT/drawn (draw_figures.mjs); and writes OUT/figure_NUMBER_WHAT.png, OUT/palpation.mp4 where
// ffmpeg is there, and OUT/index.html, which shows them. The same runs give the same pixels on one machine. Exit code 1: something could not be
// run or drawn; 2: wrong usage.
import { spawnSync } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

const here = dirname(fileURLToPath(import.meta.url));
const PLANS = { histograms: ["thesis_histograms", "--only", "kidney"], palpation: ["thesis_figures"] };
const SCENE = "better_palpation_springs";
const VIDEO = "palpation.mp4";
// What a figure is called, where it comes from, and what is said below it.
const FIGURES = [
  ["4.02-4.03_histograms", "runs/histograms/charts/histogram_kidney.png", "Tetrahedra by quality: after the hierarchical simplification (4.2) and after the sequential one (4.3)"],
  ["4.04_original", "drawn/kidney/wireframe_input.png", "The kidney: all edges of its tetrahedra"],
  ["4.05_simplified", "drawn/kidney/wireframe_hierarchical_87.png", "The kidney simplified by 87 fusions"],
  ["4.06_undeformed", "shaded", "Undeformed"],
  ["4.07_pressed", "shaded", "Pressed, 0.3 s"],
  ["4.08_responding", "shaded", "Responding, 0.32 s"],
  ["4.09_regaining", "shaded", "Regaining its state, 0.36 s"],
  ["4.10_pressed_elsewhere", "shaded", "Pressed elsewhere, 1.8 s"],
  ["4.11_responding", "shaded", "Responding, 1.82 s"],
  ["4.12_responding_further", "shaded", "Responding further, 1.86 s"],
  ["4.13_coming_back", "shaded", "Coming back, 1.94 s"],
  ["4.14_back", "shaded", "Back, 3 s"],
  ["4.15_still", "shaded", "Still of the video, 0.16 s: being pressed"],
  ["4.16_still", "shaded", "Still of the video, 0.34 s: let go"],
  ["4.17_still", "shaded", "Still of the video, 1.66 s: being pressed elsewhere"],
];

function start(command, words, what) {
  const done = spawnSync(command, words, { stdio: "inherit" });
  if (done.error) throw new Error(`${what}: ${command} could not be started (${done.error.code})`);
  if (done.status !== 0) throw new Error(`${what}: ended with exit code ${done.status}`);
}

/** What opens pages is only needed here and by tests. */
function bringBrowserDriver() {
  const isThere = () => {
    try {
      return Boolean(createRequire(import.meta.url).resolve("playwright-core"));
    } catch {
      return false;
    }
  };
  if (isThere()) return;
  const folder = mkdtempSync(join(tmpdir(), "palpate-page-"));
  try {
    start(process.execPath, [join(here, "..", "build_page.mjs"), folder, "--tests"], "the packages that open pages");
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
  if (!isThere()) throw new Error("the packages that open pages could not be had");
}

function run(name, folder) {
  if (!existsSync("palpate")) throw new Error("there is no ./palpate: start this at the top of the repository, or give the folder of runs with --runs");
  start("./palpate", ["run", ...PLANS[name], "--out", folder], `the run of ${PLANS[name][0]}`);
}

/** Writes the figures by their numbers, and the page that shows them. */
function number(out, runs) {
  const drawn = join(out, "drawn");
  const scene = readdirSync(drawn).find((name) => name.startsWith(`${SCENE}_`)); // its label and vertices stand behind its name
  if (!scene) throw new Error(`expected pictures of the scene ${SCENE} in ${drawn}, found ${readdirSync(drawn).join(", ") || "none"}`);
  const shown = FIGURES.map(([name, from, text]) => {
    const source = from === "shaded" ? join(drawn, scene, `shaded_${name}.png`) : from.startsWith("runs/") ? join(runs, from.slice("runs/".length)) : join(out, from);
    if (!existsSync(source)) throw new Error(`figure ${name}: expected ${source}, found nothing`);
    const file = `figure_${name}.png`;
    copyFileSync(source, join(out, file));
    const numbers = name.split("_")[0].replaceAll(".0", ".");
    return `<figure${name.startsWith("4.02") ? ' class="wide"' : ""}><img src="${file}" alt="${text}"><figcaption><b>${numbers}</b> ${text}</figcaption></figure>`;
  });
  const video = join(drawn, scene, VIDEO);
  if (existsSync(video)) {
    copyFileSync(video, join(out, VIDEO));
    shown.push(`<figure><video src="${VIDEO}" controls></video><figcaption>The video</figcaption></figure>`);
  }
  writeFileSync(join(out, "index.html"), `<!doctype html>
<html lang="en"><meta charset="utf-8"><title>The thesis's figures 4.2-4.17 anew</title>
<style>body { font: 16px sans-serif; margin: 2em; } main { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: 1.5em; } figure { margin: 0; } .wide { grid-column: 1 / -1; max-width: 60em; } img, video { width: 100%; }</style>
<h1>The thesis's figures 4.2-4.17 anew</h1>
<main>
${shown.join("\n")}
</main>
`);
}

const { values, positionals } = (() => {
  try {
    return parseArgs({ allowPositionals: true, options: { width: { type: "string", default: "1200" }, runs: { type: "string" } } });
  } catch (error) {
    console.error(error.message);
    return { values: {}, positionals: [] };
  }
})();
const [out, ...others] = positionals;
if (!out || others.length || !/^\d+$/.test(values.width)) {
  console.error("usage: node thesis_figures.mjs OUT [--width PIXELS] [--runs FOLDER]");
  process.exit(2);
}
try {
  bringBrowserDriver();
  const runs = values.runs ?? join(out, "runs");
  mkdirSync(out, { recursive: true });
  if (values.runs === undefined) for (const name of Object.keys(PLANS)) run(name, join(runs, name));
  start(process.execPath, [join(here, "draw_figures.mjs"), join(out, "drawn"), ...Object.keys(PLANS).map((name) => join(runs, name)), "--width", values.width], "the pictures");
  number(out, runs);
  console.log(join(out, "index.html"));
} catch (error) {
  console.error(error.message);
  process.exitCode = 1;
}

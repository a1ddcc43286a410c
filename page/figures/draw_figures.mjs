// The thesis's figures 4.4-4.17 anew, from the pages of runs, by the view that the pages have.
//
//     node draw_figures.mjs OUT RUN... [--width PIXELS]
//
// Of a run of simplifiers: wireframes of each input and its answers (figures 4.4, 4.5). Of a run of the engine: each motion undeformed,
// pressed, responding, regaining, pressed elsewhere and back (4.6-4.14), three stills (4.15-4.17) and the motion as MP4 where ffmpeg is there.
// thesis_figures.mjs makes the runs and numbers what is drawn. A folder below OUT for each body. The same run gives the same pixels on one machine. Exit code 1: a page could not be drawn; 2: wrong
// usage.
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { parseArgs } from "node:util";
import { chromium } from "playwright-core";

const MOST_WIDTH = 4000;
const VIDEO_WIDTH = 640;
// When the scenes thesis_palpation and better_palpation_springs press (0 to 0.3 s, and 1.5 to 1.8 s elsewhere) and let go; the thesis's figures.
const PHASES = [
  ["4.06_undeformed", 0],
  ["4.07_pressed", 0.3],
  ["4.08_responding", 0.32],
  ["4.09_regaining", 0.36],
  ["4.10_pressed_elsewhere", 1.8],
  ["4.11_responding", 1.82],
  ["4.12_responding_further", 1.86],
  ["4.13_coming_back", 1.94],
  ["4.14_back", 3],
];
const STILLS = [
  ["4.15_still", 0.16],
  ["4.16_still", 0.34],
  ["4.17_still", 1.66],
];
const FROM = { toEye: [-0.65, 0.2, -0.4], up: [0, 1, 0] }; // both dents are seen from aside
const FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...(process.getuid?.() === 0 ? ["--no-sandbox"] : [])];

const { values, positionals } = (() => {
  try {
    return parseArgs({ allowPositionals: true, options: { width: { type: "string", default: "1200" } } });
  } catch (error) {
    console.error(error.message);
    return { values: {}, positionals: [] };
  }
})();
const [out, ...runs] = positionals;
const width = Number(values.width);
if (!out || !runs.length || !(Number.isInteger(width) && width >= 16 && width <= MOST_WIDTH)) {
  console.error(`usage: node draw_figures.mjs OUT RUN... [--width PIXELS], from 16 to ${MOST_WIDTH} pixels`);
  process.exit(2);
}
mkdirSync(out, { recursive: true });
const browser = await chromium.launch({ executablePath: ["/usr/bin/chromium", "/usr/bin/chromium-browser"].find(existsSync), args: FLAGS });
try {
  for (const run of runs) await drawRun(run);
} catch (error) {
  console.error(String(error));
  process.exitCode = 1;
} finally {
  await browser.close();
}

async function drawRun(run) {
  const page = await browser.newPage({ viewport: { width: 800, height: 900 }, colorScheme: "light" });
  page.setDefaultTimeout(600_000); // software draws, perhaps beside much else
  await page.goto(pathToFileURL(join(run, "report.html")).href);
  const groups = await page.evaluate(() => {
    const block = document.getElementById("bodies-data");
    document.getElementById("organs")?.scrollIntoView();
    const groups = new Map();
    for (const { group, title, motion } of block ? JSON.parse(block.textContent).bodies : []) {
      if (!groups.has(group)) groups.set(group, []);
      groups.get(group).push({ title, times_s: motion?.times_s ?? [] });
    }
    return [...groups];
  });
  if (!groups.length) throw new Error(`${run}: its page shows no bodies`);
  await page.waitForFunction(() => window.palpateStage);
  for (const [group, bodies] of groups) {
    if (bodies.some(({ times_s }) => times_s.length > 1)) await drawMotion(page, group, bodies);
    else if (bodies.some(({ title }) => title === "input")) await drawWireframes(page, group, bodies);
  }
  await page.close();
}

/** A name that every file system takes. */
function plain(text) {
  return text.replace(/(\d),(?=\d)/g, "$1").replace(/[^\w.-]+/g, "_");
}

/** The picture of the one body that a scene shows, as bytes. */
async function pictureOf(page, scene, pixels) {
  const [picture] = await page.evaluate(([what, size]) => window.palpateStage.draw(what, size), [scene, pixels]);
  return Buffer.from(picture.slice(picture.indexOf(",") + 1), "base64");
}

function save(group, name, content) {
  const file = join(plain(group), name);
  mkdirSync(join(out, plain(group)), { recursive: true });
  writeFileSync(join(out, file), content);
  console.log(file);
}

async function drawWireframes(page, group, bodies) {
  for (const { title } of bodies) save(group, `wireframe_${plain(title)}.png`, await pictureOf(page, { group, titles: [title], mode: "wireframe", colour: "" }, width));
}

async function drawMotion(page, group, bodies) {
  for (const { title, times_s } of bodies.filter((body) => body.times_s.length > 1)) {
    for (const [phase, time_s] of PHASES.filter((each) => each[1] <= times_s.at(-1) + 1e-6)) {
      for (const [mode, how, colour] of [["surface", "shaded", ""], ["wireframe", "wireframe", ""], ["surface", "displacement", "displacement"]])
        save(group, `${how}_${phase}.png`, await pictureOf(page, { group, titles: [title], mode, colour, time_s, from: FROM }, width));
    }
    for (const [still, time_s] of STILLS.filter((each) => each[1] <= times_s.at(-1)))
      save(group, `shaded_${still}.png`, await pictureOf(page, { group, titles: [title], mode: "surface", colour: "", time_s, from: FROM }, width));
    await drawVideo(page, group, title, times_s);
  }
}

async function drawVideo(page, group, title, times) {
  const frames = mkdtempSync(join(tmpdir(), "palpate-frames-"));
  try {
    for (const [number, time_s] of times.entries()) {
      const picture = await pictureOf(page, { group, titles: [title], mode: "surface", colour: "", time_s, from: FROM }, VIDEO_WIDTH);
      writeFileSync(join(frames, `${String(number).padStart(4, "0")}.png`), picture);
    }
    const rate = (times.length - 1) / (times.at(-1) - times[0]);
    const name = join(plain(group), "palpation.mp4");
    const words = ["-y", "-loglevel", "error", "-framerate", String(rate), "-i", join(frames, "%04d.png"), "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-threads", "1",
      "-pix_fmt", "yuv420p", "-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1", join(out, name)];
    const done = spawnSync("ffmpeg", words, { encoding: "utf8" });
    if (done.error?.code === "ENOENT") console.error("no ffmpeg: no video (packages.txt)");
    else if (done.status !== 0) throw new Error(`ffmpeg: ${done.stderr.trim()}`);
    else console.log(name);
  } finally {
    rmSync(frames, { recursive: true, force: true });
  }
}

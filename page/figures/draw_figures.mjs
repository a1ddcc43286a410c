// The thesis's figures 4.4-4.17 anew, from the pages of runs, by the view that the pages have.
//
//     node draw_figures.mjs OUT RUN...
//
// Of a run of simplifiers: wireframes of each input and its answers (figures 4.4, 4.5). Of a run of the engine: each motion undeformed,
// pressed, responding, regaining, pressed elsewhere and back (4.6-4.17), and the motion as MP4 where ffmpeg is there. The same run gives the same
// pixels on one machine. Exit code 1: a page could not be drawn; 2: wrong usage.
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const WIDTH = 1200;
const VIDEO_WIDTH = 800;
// When the scenes thesis_palpation and better_palpation_springs press (0 to 0.3 s, and 1.5 to 1.8 s elsewhere) and let go.
const PHASES = [["undeformed", 0], ["pressed", 0.3], ["responding", 0.4], ["regaining", 0.6], ["pressed_elsewhere", 1.8], ["back", 3]];
const FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...(process.getuid?.() === 0 ? ["--no-sandbox"] : [])];

const [out, ...runs] = process.argv.slice(2);
if (!out || !runs.length) {
  console.error("usage: node draw_figures.mjs OUT RUN...");
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
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 }, colorScheme: "light" });
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

function fileName(...parts) {
  return `${parts.join("_").replace(/(\d),(?=\d)/g, "$1").replace(/[^\w.-]+/g, "_")}.png`;
}

/** One picture of each body that a scene shows, as bytes. */
async function picturesOf(page, scene, width) {
  const pictures = await page.evaluate(([what, size]) => window.palpateStage.draw(what, size), [scene, width]);
  return pictures.map((picture) => Buffer.from(picture.slice(picture.indexOf(",") + 1), "base64"));
}

function save(name, content) {
  writeFileSync(join(out, name), content);
  console.log(name);
}

async function drawWireframes(page, group, bodies) {
  for (const { title } of bodies) {
    const [picture] = await picturesOf(page, { group, titles: [title], mode: "wireframe", colour: "" }, WIDTH);
    save(fileName("wireframe", group, title), picture);
  }
}

async function drawMotion(page, group, bodies) {
  for (const { title, times_s } of bodies.filter((body) => body.times_s.length > 1)) {
    for (const [phase, time_s] of PHASES.filter((each) => each[1] <= times_s.at(-1) + 1e-6)) {
      for (const [mode, how, colour] of [["surface", "shaded", ""], ["wireframe", "wireframe", ""], ["surface", "displacement", "displacement"]]) {
        const [picture] = await picturesOf(page, { group, titles: [title], mode, colour, time_s }, WIDTH);
        save(fileName(group, how, phase), picture);
      }
    }
    await drawVideo(page, group, title, times_s);
  }
}

async function drawVideo(page, group, title, times) {
  const frames = mkdtempSync(join(tmpdir(), "palpate-frames-"));
  try {
    for (const [number, time_s] of times.entries()) {
      const [picture] = await picturesOf(page, { group, titles: [title], mode: "surface", colour: "", time_s }, VIDEO_WIDTH);
      writeFileSync(join(frames, `${String(number).padStart(4, "0")}.png`), picture);
    }
    const rate = (times.length - 1) / (times.at(-1) - times[0]);
    const name = fileName(group).replace(/png$/, "mp4");
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

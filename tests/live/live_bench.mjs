// How fast the live page steps in headless Chromium, model by model, with how busy the machine is. No test: it times.
//
//     node live_bench.mjs SOURCE_DIR PAGE.html [SECONDS]
import { createRequire } from "node:module";
import { availableParallelism, cpus, loadavg } from "node:os";
import { resolve } from "node:path";

const [source, file, seconds = "5"] = process.argv.slice(2);
const { chromium } = createRequire(resolve(source, "page/package.json"))("playwright-core");
const browser = await chromium.launch({ executablePath: process.env.PALPATE_CHROMIUM ?? "/usr/bin/chromium", args: ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"] });
const page = await browser.newPage({ viewport: { width: 1200, height: 800 } });
await page.goto(`file://${resolve(file)}`);
const isWhole = () => page.waitForFunction(() => document.querySelector("[data-readout=state]")?.textContent === "whole", null, { timeout: 120_000 });
await isWhole();

/** Medians of what the page shows, while a finger presses. */
async function measure(label, pace, settings) {
  for (const [name, value] of Object.entries(settings)) {
    await page.selectOption(`#live-${name}`, value);
    await page.waitForTimeout(1500);
  }
  await isWhole();
  await page.selectOption("#live-pace", pace);
  await page.locator(".live-own canvas").focus();
  await page.keyboard.press("p");
  await page.waitForTimeout(1500);
  const samples = [];
  for (let k = 0; k < 10 * Number(seconds); k++) {
    samples.push(await page.evaluate(() => {
      const of = (name, key = "value") => Number(document.querySelector(`[data-readout=${name}]`).dataset[key]);
      return { stepUs: of("stepTime"), rate: of("stepTime", "rate"), realTime: of("realTime") };
    }));
    await page.waitForTimeout(100);
  }
  await page.keyboard.press("r");
  const middle = (key) => samples.map((sample) => sample[key]).sort((a, b) => a - b)[samples.length >> 1];
  const low = (key) => samples.map((sample) => sample[key]).sort((a, b) => a - b)[Math.floor(samples.length / 20)];
  const margin = await page.locator("[data-readout=margin]").textContent();
  console.log(`| ${label} | ${pace === "0" ? "as it goes" : "real time"} | ${middle("stepUs").toFixed(0)} | ${middle("rate").toFixed(0)} | ${low("rate").toFixed(0)} | ${middle("realTime").toFixed(2)} | ${margin} | ${loadavg()[0].toFixed(1)} |`);
}

console.log(`${cpus()[0].model}, ${availableParallelism()} processors; Chromium ${browser.version()}, pictures by SwiftShader on the same processors`);
console.log("| model | pace | a step, us | steps a second, median | 5% below | real-time factor | step | load |\n|---|---|---|---|---|---|---|---|");
for (const pace of ["0", "1"]) {
  await measure("springs", pace, { model: "springs", volume: "none" });
  await measure("springs, node_average", pace, { volume: "node_average" });
  await measure("edge_node, large strain", pace, { model: "smoothed", smoothing: "edge_node", law: "corotated" });
  await measure("edge_node, small strain", pace, { law: "linear" });
  await measure("linear tets, large strain", pace, { smoothing: "tets", law: "corotated" });
}
if (await page.locator("#live-model option[value=reduced]").count()) await measure("table", "1", { model: "reduced" });
await browser.close();

// A picture of a live page with a finger on the organ (docs/gallery.md), at the top of the repository:
//
//     node page/figures/live_picture.mjs PAGE.html OUT.png
//
// Opens the page in headless Chromium, presses in the middle of the organ, waits until it is at rest under the finger and takes the window. Figures
// of time differ from one picture to the next. Exit code 1: the page did not answer; 2: wrong usage.
import { existsSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const [file, out, ...others] = process.argv.slice(2);
if (!file || !out || others.length) {
  console.error("usage: node live_picture.mjs PAGE.html OUT.png");
  process.exit(2);
}
const flags = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...(process.getuid?.() === 0 ? ["--no-sandbox"] : [])];
const browser = await chromium.launch({ executablePath: ["/usr/bin/chromium", "/usr/bin/chromium-browser"].find(existsSync), args: flags });
try {
  const page = await browser.newPage({ viewport: { width: 1200, height: 800 }, colorScheme: "light" });
  page.setDefaultTimeout(240_000);
  await page.goto(pathToFileURL(resolve(file)).href);
  await page.waitForFunction(() => document.querySelector("[data-readout=state]")?.textContent === "whole");
  await page.locator(".live-own canvas").focus();
  await page.keyboard.press("p");
  await page.waitForFunction(() => {
    const value = (name) => Number(document.querySelector(`[data-readout=${name}]`).dataset.value);
    return value("force") > 0.001 && value("energy") < 1e-7;
  });
  await page.evaluate(() => document.activeElement.blur());
  await page.waitForTimeout(1000); // figures of time are means over a tenth of a second
  await page.screenshot({ path: out });
  console.log(out);
} catch (error) {
  console.error(String(error));
  process.exitCode = 1;
} finally {
  await browser.close();
}

// A reader of pages: Debian's Chromium, watched for what a page asks the network and what its console and its dialogs say.
import { existsSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const PATIENCE = 120_000; // on a machine that does much else

/** How many pixels of a PNG differ from its corner, of how many; and all of them as text, to compare. The page draws it. */
export async function readPixels(page, png) {
  return page.evaluate(async (data) => {
    const image = new Image();
    image.src = data;
    await image.decode();
    const canvas = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { data: pixels } = context.getImageData(0, 0, image.width, image.height);
    let drawn = 0;
    for (let i = 0; i < pixels.length; i += 4)
      if (Math.abs(pixels[i] - pixels[0]) + Math.abs(pixels[i + 1] - pixels[1]) + Math.abs(pixels[i + 2] - pixels[2]) > 30) drawn++;
    return { drawn, of: pixels.length / 4, pixels: Array.from(pixels).join() };
  }, `data:image/png;base64,${png.toString("base64")}`);
}

/**
 * What axe-core finds wrong with a page for those who read it by keyboard or by ear (WCAG 2.2 A and AA, and its own best practices): roles,
 * names, labels, order of headings, contrast of text. A list of lines; nothing is left out.
 */
export async function findBarriers(root, page) {
  const source = readFileSync(createRequire(join(root, "page", "package.json")).resolve("axe-core/axe.min.js"), "utf8");
  await page.evaluate(source);
  return page.evaluate(async () => {
    const tags = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];
    const { violations, passes } = await axe.run(document, { runOnly: tags });
    if (passes.length < 10) return [`only ${passes.length} rules had anything to look at`];
    return violations.flatMap(({ id, nodes }) => nodes.map(({ html, any }) => `${id}: ${html.slice(0, 160)}: ${any.map(({ message }) => message).join("; ")}`));
  });
}

/** A browser, and what reads pages with it. */
export async function startReader(root) {
  const { chromium } = createRequire(join(root, "page", "package.json"))("playwright-core");
  const flags = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...(process.getuid?.() === 0 ? ["--no-sandbox"] : [])];
  const browser = await chromium.launch({ executablePath: ["/usr/bin/chromium", "/usr/bin/chromium-browser"].find(existsSync), args: flags });

  /** A page that is watched: what it asked the network for, what its console and its dialogs said. */
  async function open(file, options = {}) {
    const context = await browser.newContext({ viewport: { width: 1200, height: 850 }, ...options });
    await context.grantPermissions(["clipboard-read", "clipboard-write"]).catch(() => {});
    const page = await context.newPage();
    page.setDefaultTimeout(PATIENCE);
    const trouble = [];
    page.on("console", (message) => ["error", "warning"].includes(message.type()) && !isOfSoftwareDrawing(message.text()) && trouble.push(`console: ${message.text()}`));
    page.on("pageerror", (error) => trouble.push(`error: ${error.message}`));
    page.on("dialog", (dialog) => (trouble.push(`dialog: ${dialog.message()}`), dialog.dismiss()));
    const address = pathToFileURL(file).href;
    page.on("request", (request) => {
      const url = request.url();
      if (url.split("#")[0] !== address && !url.startsWith("data:") && !url.startsWith("blob:")) trouble.push(`request: ${url}`);
    });
    await page.goto(address);
    return { page, trouble, close: () => context.close() };
  }

  // What Chromium's own software renderer says of itself when pixels are read back.
  function isOfSoftwareDrawing(text) {
    return /GPU stall due to ReadPixels|software WebGL/i.test(text);
  }

  async function settle(page) {
    await page.waitForFunction(() => !document.querySelector("canvas[data-coarse]"));
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  }

  /** Scrolls to each chart and waits until it is drawn: they are, each by itself, once a reader comes near. Returns how many there are. */
  async function drawCharts(page) {
    const charts = page.locator("[data-chart]");
    const count = await charts.count();
    for (let i = 0; i < count; i++) {
      await charts.nth(i).scrollIntoViewIfNeeded();
      await charts.nth(i).locator("svg").first().waitFor();
    }
    return count;
  }

  /** Scrolls to the bodies and waits until they are drawn. */
  async function seeBodies(page) {
    await page.locator("#organs").scrollIntoViewIfNeeded();
    await page.locator("canvas.organ-canvas").first().waitFor();
    await page.locator("canvas.organ-canvas").first().scrollIntoViewIfNeeded();
    await settle(page);
  }

  /** readPixels of a view. */
  async function look(page, number = 0) {
    const shot = await page.locator("canvas.organ-canvas").nth(number).screenshot();
    return readPixels(page, shot);
  }

  return { browser, chromium, drawCharts, flags, look, open, PATIENCE, seeBodies, settle };
}

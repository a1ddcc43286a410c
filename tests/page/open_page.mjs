// Opens pages of runs as a reader would, from their top to their end, and says what became of each: for tests that make pages, and by hand.
//
//     node open_page.mjs ROOT PAGE.html...
//
// Prints a line of JSON a page: seconds until the verdict stood, charts that are drawn, bodies, what the console or the network said, what was not
// shown, and barriers to keyboards and screen readers (reader.mjs). Exit code 1 if anything is wrong with any of them.
import { performance } from "node:perf_hooks";
import { findBarriers, startReader } from "./reader.mjs";

const [root, ...files] = process.argv.slice(2);
if (!root || !files.length) {
  console.error("usage: node open_page.mjs ROOT PAGE.html...");
  process.exit(2);
}
const { browser, drawCharts, look, open, seeBodies } = await startReader(root);
let failed = 0;
for (const file of files) {
  const began = performance.now();
  const { page, trouble, close } = await open(file);
  const verdict = await page.locator(".verdict p").first().innerText();
  const opened_s = Number(((performance.now() - began) / 1000).toFixed(2));
  const charts = await drawCharts(page);
  let bodies = 0;
  if (await page.locator("[data-bodies]").count()) {
    await seeBodies(page);
    bodies = await page.locator("canvas.organ-canvas").count();
    if ((await look(page)).drawn === 0) trouble.push("a body is not drawn");
  }
  const said = { page: file, verdict, opened_s, charts, bodies, tables: await page.locator("table").count(), trouble,
    faults: await page.locator(".fault").allInnerTexts(), barriers: await findBarriers(root, page) };
  console.log(JSON.stringify(said));
  if (said.trouble.length || said.faults.length || said.barriers.length) failed++;
  await close();
}
await browser.close();
process.exit(failed ? 1 : 0);

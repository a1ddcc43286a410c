// Bundles the scripts of the pages with esbuild, after bringing the packages that package-lock.json names.
//
//     node build_page.mjs OUT_DIR [--tests]
//
// Writes OUT_DIR/NAME.js and NAME.css for each page, and OUT_DIR/built.txt last. `npm ci` is run only if the lock file has changed
// since it was run; `--tests` brings what the tests need as well. Without a registry the pages are not built, which is said, and the exit
// code is 0: a report is written without its scripts then. Exit code 1: the sources are at fault; 2: wrong usage.
import { createHash } from "node:crypto";
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

// A page: its script and its style sheet below this folder.
const PAGES = [
  { name: "report", script: "report/report.ts", style: "report/report.css" },
  { name: "live", script: "live/live.ts", style: "live/live.css" },
  { name: "live_worker", script: "live/worker.ts" },
];

const here = dirname(fileURLToPath(import.meta.url));

/** Whether node_modules is what the lock file says; brings it there if it is not. */
function bringPackages(withTests) {
  const wanted = createHash("sha256").update(readFileSync(join(here, "package-lock.json"))).digest("hex");
  const stamp = join(here, "node_modules", ".palpate-lock");
  const found = existsSync(stamp) ? readFileSync(stamp, "utf8").split(" ") : [];
  if (found[0] === wanted && (!withTests || found[1] === "tests")) return true;
  const everything = withTests || found[1] === "tests";
  const words = ["ci", "--no-progress", "--prefer-offline", "--loglevel=error", ...(everything ? [] : ["--omit=dev"]), ...(process.env.PALPATE_OFFLINE === "1" ? ["--offline"] : [])];
  const done = spawnSync("npm", words, { cwd: here, stdio: ["ignore", "inherit", "inherit"], env: { ...process.env, npm_config_fetch_retries: "1" } });
  if (done.status !== 0) return false;
  writeFileSync(stamp, `${wanted} ${everything ? "tests" : "build"}`);
  return true;
}

/** The licences of the packages whose sources went into a bundle, each text once: they ask to be copied along. */
function licencesOf(inputs) {
  const holders = new Map();
  for (const input of inputs) {
    const [, name] = input.match(/node_modules\/((?:@[^/]+\/)?[^/]+)\//) ?? [];
    if (!name) continue;
    const file = ["LICENSE", "LICENSE.md", "LICENSE.txt"].map((ending) => join(here, "node_modules", name, ending)).find(existsSync);
    const text = file ? readFileSync(file, "utf8").trim() : JSON.parse(readFileSync(join(here, "node_modules", name, "package.json"), "utf8")).license;
    holders.set(text, [...(holders.get(text) ?? []), name].filter((each, place, all) => all.indexOf(each) === place));
  }
  const parts = [...holders].map(([text, names]) => `${names.sort().join(", ")}:\n\n${text}`).sort();
  return parts.length ? `/*\nOf others in this script:\n\n${parts.join("\n\n").replaceAll("*/", "* /")}\n*/\n` : "";
}

async function bundle(page, folder) {
  const { build } = await import("esbuild");
  const common = { absWorkingDir: here, bundle: true, minify: true, charset: "ascii", legalComments: "none", logLevel: "warning", target: ["es2022"] };
  const script = join(folder, `${page.name}.js`);
  const { metafile } = await build({ ...common, entryPoints: [page.script], outfile: script, format: "iife", loader: { ".css": "empty" }, metafile: true });
  writeFileSync(script, licencesOf(Object.keys(metafile.inputs)) + readFileSync(script, "utf8"));
  if (page.style) await build({ ...common, entryPoints: [page.style], outfile: join(folder, `${page.name}.css`) });
}

const [folder, ...flags] = process.argv.slice(2);
if (!folder || flags.some((flag) => flag !== "--tests")) {
  console.error("usage: node build_page.mjs OUT_DIR [--tests]");
  process.exit(2);
}
mkdirSync(folder, { recursive: true });
rmSync(join(folder, "built.txt"), { force: true });
if (!bringPackages(flags.includes("--tests"))) {
  console.error("the packages of page/package-lock.json could not be had: reports are written without their scripts");
  process.exit(0);
}
try {
  for (const page of PAGES) await bundle(page, folder);
} catch (error) {
  console.error(String(error));
  process.exit(1);
}
writeFileSync(join(folder, "built.txt"), `${PAGES.map((page) => page.name).join("\n")}\n`);

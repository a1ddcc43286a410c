// What draws, without a browser: faces against brute force, normals of a sphere, picking against its own projection, frames, colours, CSV.
//
//     node units_test.mjs ROOT
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { pathToFileURL } from "node:url";

const root = process.argv[2];
const { build } = createRequire(join(root, "page", "package.json"))("esbuild");
const folder = mkdtempSync(join(tmpdir(), "palpate-units-"));
process.on("exit", () => rmSync(folder, { recursive: true, force: true }));

async function load(name) {
  const outfile = join(folder, `${name.replaceAll("/", "_")}.mjs`);
  await build({ entryPoints: [join(root, "page", `${name}.ts`)], bundle: true, format: "esm", platform: "node", outfile, logLevel: "error" });
  return import(pathToFileURL(outfile).href);
}

const skin = await load("view/skin");
const { standIn } = await load("view/stand_in");
const { pickTriangle } = await load("view/pick");
const { frameOf } = await load("view/framing");
const colours = await load("view/colour_scale");
const { csvOf } = await load("report/tables");
const { placeNames, styleSeries } = await load("report/series_style");
const { logTicks, wrapped } = await load("report/axes");

const TETS_OF_CUBE = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/** n x n x n cubes of six tetrahedra, over [0, 1]^3. */
function block(n) {
  const number = (i, j, k) => (i * (n + 1) + j) * (n + 1) + k;
  const positions = [];
  for (let i = 0; i <= n; i++) for (let j = 0; j <= n; j++) for (let k = 0; k <= n; k++) positions.push(i / n, j / n, k / n);
  const tets = [];
  for (let i = 0; i < n; i++)
    for (let j = 0; j < n; j++)
      for (let k = 0; k < n; k++)
        for (const tet of TETS_OF_CUBE) tets.push(...tet.map((c) => number(i + (c & 1), j + ((c >> 1) & 1), k + ((c >> 2) & 1))));
  return { positions: Float32Array.from(positions), tets: Uint32Array.from(tets) };
}

/** A sphere by latitude and longitude. */
function sphere(rings, radius = 1) {
  const positions = [0, 0, radius];
  for (let i = 1; i < rings; i++)
    for (let j = 0; j < 2 * rings; j++) {
      const [a, b] = [(Math.PI * i) / rings, (Math.PI * j) / rings];
      positions.push(radius * Math.sin(a) * Math.cos(b), radius * Math.sin(a) * Math.sin(b), radius * Math.cos(a));
    }
  positions.push(0, 0, -radius);
  const last = positions.length / 3 - 1;
  const at = (i, j) => (i === 0 ? 0 : i === rings ? last : 1 + (i - 1) * 2 * rings + (j % (2 * rings)));
  const triangles = [];
  for (let i = 0; i < rings; i++)
    for (let j = 0; j < 2 * rings; j++) {
      if (i > 0) triangles.push(at(i, j), at(i + 1, j), at(i, j + 1));
      if (i < rings - 1) triangles.push(at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
    }
  return { positions: Float32Array.from(positions), triangles: Uint32Array.from(triangles) };
}

/** Six times the signed volume below a closed surface. */
function volumeOf(positions, corners) {
  let sum = 0;
  for (let i = 0; i < corners.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => positions.subarray(3 * corners[i + k], 3 * corners[i + k] + 3));
    sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return sum / 6;
}

function cornersOf(faces, chosen) {
  return Uint32Array.from([...chosen].flatMap((face) => [...faces.corners.subarray(3 * face, 3 * face + 3)]));
}

test("faces are those of brute force, each once, and the boundary encloses the volume outwards", () => {
  const { positions, tets } = block(3);
  const faces = skin.buildFaces(tets, positions.length / 3);
  const counts = new Map();
  for (let t = 0; t < tets.length; t += 4)
    for (const skipped of [0, 1, 2, 3]) {
      const key = [0, 1, 2, 3].filter((c) => c !== skipped).map((c) => tets[t + c]).sort((a, b) => a - b).join();
      counts.set(key, (counts.get(key) ?? 0) + 1);
    }
  assert.equal(faces.inner.length, counts.size);
  faces.inner.forEach((_, face) => {
    const key = [...faces.corners.subarray(3 * face, 3 * face + 3)].sort((a, b) => a - b).join();
    assert.equal(faces.outer[face] < 0 ? 1 : 2, counts.get(key), key);
  });
  const boundary = skin.outerFaces(faces, () => true);
  assert.equal(boundary.length, 2 * 6 * 9);
  assert.ok(Math.abs(volumeOf(positions, cornersOf(faces, boundary)) - 1) < 1e-6);
});

test("what a cut keeps is enclosed by its own faces", () => {
  const { positions, tets } = block(4);
  const faces = skin.buildFaces(tets, positions.length / 3);
  const isKept = (tet) => tet % 3 !== 0;
  const shown = skin.outerFaces(faces, isKept);
  const corners = [];
  for (const face of shown) {
    const [a, b, c] = faces.corners.subarray(3 * face, 3 * face + 3);
    corners.push(...(isKept(faces.inner[face]) ? [a, b, c] : [a, c, b]));
  }
  const kept = Array.from({ length: tets.length / 4 }, (_, tet) => tet).filter(isKept).length;
  assert.ok(Math.abs(volumeOf(positions, Uint32Array.from(corners)) - kept / (tets.length / 4)) < 1e-6);
});

/** The stand-in of a surface, and how many pieces its work came in. */
function standInOf(positions, corners, wanted, held = []) {
  const normals = new Float32Array(positions.length);
  skin.vertexNormals(positions, corners, normals);
  const isHeld = new Uint8Array(positions.length / 3);
  for (const point of held) isHeld[point] = 1;
  const work = standIn({ places: positions, normals, corners, isHeld }, wanted);
  for (let pieces = 1; ; pieces++) {
    const step = work.next();
    if (step.done) return { corners: step.value, pieces };
  }
}

/** Each edge is as often gone along one way as the other. */
function isClosed(corners) {
  const ways = new Map();
  for (let i = 0; i < corners.length; i += 3)
    for (let side = 0; side < 3; side++) {
      const [a, b] = [corners[i + side], corners[i + ((side + 1) % 3)]];
      const key = `${Math.min(a, b)},${Math.max(a, b)}`;
      ways.set(key, (ways.get(key) ?? 0) + (a < b ? 1 : -1));
    }
  return [...ways.values()].every((sum) => sum === 0);
}

test("a stand-in is closed, has about the points that were wanted, and comes nearer to the body with their number", () => {
  const { positions, triangles } = sphere(100);
  assert.ok(isClosed(triangles) && !isClosed(triangles.subarray(3)));
  const missing = [500, 2000].map((wanted) => {
    const { corners, pieces } = standInOf(positions, triangles, wanted);
    assert.ok(isClosed(corners));
    const points = new Set(corners).size;
    assert.ok(points > 0.75 * wanted && points < 1.25 * wanted, `${points} of ${wanted}`);
    assert.ok(pieces > 20, `${pieces} pieces`);
    return 1 - volumeOf(positions, corners) / ((4 / 3) * Math.PI);
  });
  // Regular triangles between N points of a sphere lie an eighth of their squared edge below it on the mean: 5.4 / N of the volume. These are not regular.
  assert.ok(missing[0] > 0 && missing[0] < 1.5 * (5.4 / 500), `${missing[0]}`);
  assert.ok(missing[1] > 0 && missing[1] < 1.5 * (5.4 / 2000), `${missing[1]}`);
  assert.deepEqual(standInOf(positions, triangles, 500), standInOf(positions, triangles, 500));
});

test("the two sides of a thin body stay two, and its corners and held points stay", () => {
  const n = 40;
  const { positions, tets } = block(n);
  const faces = skin.buildFaces(tets, positions.length / 3);
  const triangles = cornersOf(faces, skin.outerFaces(faces, () => true));
  const flat = positions.map((value, i) => (i % 3 === 2 ? value / 1000 : value)); // a fiftieth of what one point stands for
  const ends = [...Array(positions.length / 3).keys()].filter((point) => [0, 1, 2].every((axis) => [0, 1].includes(positions[3 * point + axis])));
  assert.equal(ends.length, 8);
  const held = [...new Set(triangles)].filter((point) => positions[3 * point] === 0.5 && positions[3 * point + 2] === 0);
  const { corners } = standInOf(flat, triangles, 900, held);
  assert.ok(isClosed(corners) && corners.length < triangles.length / 2);
  assert.ok(volumeOf(flat, corners) > 0.9 * 0.001, `${volumeOf(flat, corners)} of 0.001`);
  const solid = new Set(standInOf(positions, triangles, 900, held).corners);
  for (const end of ends) assert.ok(solid.has(end), `corner ${end}`);
  for (const point of held) assert.ok(solid.has(point) && corners.includes(point), `held ${point}`);
});

test("normals of a sphere point from its middle, the better the finer it is", () => {
  const errors = [8, 16, 32].map((rings) => {
    const { positions, triangles } = sphere(rings, 2);
    const normals = new Float32Array(positions.length);
    skin.vertexNormals(positions, triangles, normals);
    let worst = 0;
    for (let i = 0; i < positions.length; i += 3) {
      const dot = (normals[i] * positions[i] + normals[i + 1] * positions[i + 1] + normals[i + 2] * positions[i + 2]) / 2;
      worst = Math.max(worst, Math.acos(Math.min(1, dot)));
    }
    return worst;
  });
  assert.ok(errors[1] < 0.6 * errors[0] && errors[2] < 0.6 * errors[1] && errors[2] < 0.05, String(errors));
});

test("edges are those of Euler's formula", () => {
  const { positions, triangles } = sphere(10);
  const edges = skin.uniqueEdges(triangles, positions.length / 3);
  assert.equal(positions.length / 3 - edges.length / 2 + triangles.length / 3, 2);
});

test("a broken mesh is refused in words, a good one is not", () => {
  const good = block(1);
  assert.equal(skin.meshFault(good), null);
  assert.match(skin.meshFault({ ...good, tets: Uint32Array.from([0, 1, 2, 99]) }), /vertex 99 is named, and there are 8/);
  assert.match(skin.meshFault({ ...good, positions: good.positions.map((value, i) => (i === 4 ? NaN : value)) }), /no finite number/);
  assert.match(skin.meshFault({ positions: new Float32Array(), tets: good.tets }), /no vertices/);
  assert.match(skin.meshFault({ ...good, tets: new Uint32Array() }), /neither tetrahedra nor triangles/);
});

test("a ray meets the sphere where the closed form has it, and nothing beside or behind it", () => {
  const { positions, triangles } = sphere(60);
  for (const [x, y] of [[0, 0], [0.3, -0.2], [-0.7, 0.4]]) {
    const hit = pickTriangle(positions, triangles, [x, y, 5], [0, 0, -1]);
    const z = Math.sqrt(1 - x * x - y * y);
    assert.ok(Math.abs(hit.point[2] - z) < 4e-3, `${hit.point[2]} and ${z}`);
    assert.ok(Math.abs(hit.distance - (5 - hit.point[2])) < 1e-6);
    assert.ok(hit.normal[0] * x + hit.normal[1] * y + hit.normal[2] * z > 0.99);
    let nearest = -1;
    let least = Infinity;
    for (const vertex of triangles.subarray(3 * hit.triangle, 3 * hit.triangle + 3)) {
      const distance = Math.hypot(...[0, 1, 2].map((k) => positions[3 * vertex + k] - hit.point[k]));
      if (distance < least) [least, nearest] = [distance, vertex];
    }
    const own = Math.hypot(...[0, 1, 2].map((k) => positions[3 * hit.vertex + k] - hit.point[k]));
    assert.ok(own <= 1.5 * least + 1e-9, `vertex ${hit.vertex}, nearest ${nearest}`);
  }
  assert.equal(pickTriangle(positions, triangles, [1.2, 0, 5], [0, 0, -1]), null);
  assert.equal(pickTriangle(positions, triangles, [0, 0, 5], [0, 0, 1]), null);
});

test("a frame holds the body, looks across its shortest axis, and moves with it", () => {
  const { positions } = block(3);
  const long = positions.map((value, i) => value * [4, 2, 1][i % 3]);
  const frame = frameOf(long);
  assert.deepEqual(frame.centre, [2, 1, 0.5]);
  assert.ok(Math.abs(frame.radius - Math.hypot(2, 1, 0.5)) < 1e-6);
  assert.ok(Math.abs(frame.toEye[2]) > 0.85 && Math.abs(frame.up[1]) > 0.99, JSON.stringify(frame));
  const moved = frameOf(long.map((value, i) => value + [10, -3, 7][i % 3]));
  frame.toEye.forEach((value, axis) => assert.ok(Math.abs(value - moved.toEye[axis]) < 1e-4));
});

test("colour scales get lighter all the way, and their table has their ends", () => {
  for (const scale of ["viridis", "cividis"]) {
    const light = Array.from({ length: 21 }, (_, i) => colours.colourAt(scale, i / 20)).map(([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b);
    light.forEach((value, i) => assert.ok(i === 0 || value > light[i - 1], `${scale} at ${i}`));
    const table = colours.colourTable(scale);
    assert.deepEqual([...table.slice(0, 3)], colours.colourAt(scale, 0));
    assert.deepEqual([...table.slice(-4, -1)], colours.colourAt(scale, 1));
  }
  assert.deepEqual(colours.rangeOf(Float32Array.from([NaN, 2, -1, Infinity])), [-1, 2]);
  assert.deepEqual(colours.rangeOf(Float32Array.from([NaN])), [0, 1]);
});

test("CSV quotes what it must", () => {
  assert.equal(csvOf(["a", "b,c"], [['say "x"', 1.5], ["line\nbreak", -2]]), 'a,"b,c"\r\n"say ""x""",1.5\r\n"line\nbreak",-2\r\n');
});

test("each colour of a series stands out from the page's ground, light and dark", () => {
  const lightOf = (colour) => {
    const [r, g, b] = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16) / 255).map((x) => (x <= 0.03928 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (a, b) => (Math.max(lightOf(a), lightOf(b)) + 0.05) / (Math.min(lightOf(a), lightOf(b)) + 0.05);
  assert.ok(Math.abs(contrast("#ffffff", "#000000") - 21) < 1e-9);
  const style = readFileSync(join(root, "report", "page", "page.css"), "utf8");
  for (const [dark, paper] of [[false, /:root \{ --paper: (#[0-9a-f]{6})/], [true, /data-theme="dark"\] \{ --paper: (#[0-9a-f]{6})/]].map(([dark, found]) => [dark, style.match(found)[1]])) {
    for (const colour of styleSeries(Array.from({ length: 8 }, (_, i) => `s${i}`), dark).colours) assert.ok(contrast(colour, paper) >= 3, `${colour} on ${paper}: ${contrast(colour, paper)}`);
  }
});

test("no two of the first forty series have the same colour and mark", () => {
  const names = Array.from({ length: 40 }, (_, i) => `s${i}`);
  for (const dark of [false, true]) {
    const { colours: own, marks } = styleSeries(names, dark);
    assert.equal(new Set(names.map((_, i) => own[i] + marks[i])).size, 40);
  }
});

test("a name has the same place on every chart of a page, and no two of one chart share theirs", () => {
  const charts = [["a", "b", "c"], ["x", "y"], ["c", "a"], ["c", "z", "x"]];
  const places = placeNames(charts);
  assert.deepEqual([...places.entries()].filter(([name]) => "abc".includes(name)), [["a", 0], ["b", 1], ["c", 2]]);
  for (const names of charts) assert.equal(new Set(names.map((name) => places.get(name))).size, names.length);
  assert.equal(places.get("x"), 0, "what is beside none of the others may look like them");
  const [all, some] = [charts[0], charts[2]].map((names) => styleSeries(names, false, places));
  assert.deepEqual([some.colours, some.marks], [[all.colours[2], all.colours[0]], [all.marks[2], all.marks[0]]]);
});

test("numbers of a logarithmic axis stand apart however narrow it is, and are the same as before where there is room", () => {
  assert.deepEqual(logTicks([0.9, 120]), [1, 2, 5, 10, 20, 50, 100]);
  assert.deepEqual(logTicks([0.9, 120], 600), [1, 2, 5, 10, 20, 50, 100]);
  assert.deepEqual(logTicks([0.9, 120], 150), [1, 10, 100]);
  assert.deepEqual(logTicks([3, 4e6], 120).length, 3, "1000 and 10000 would touch");
  for (const pixels of [60, 100, 150, 300])
    for (const high of [9, 300, 2e4, 3e7, 2e12]) {
      const ticks = logTicks([1, high], pixels);
      ticks.slice(1).forEach((value, k) => assert.ok((pixels * Math.log(value / ticks[k])) / Math.log(high) > 7 * Math.max(1, String(value).length / 3), `${ticks} on ${pixels}`));
    }
});

test("a long name is broken where it can be, and nothing of it is lost", () => {
  assert.equal(wrapped("short", 10), "short");
  assert.equal(wrapped("palpate.refined (tets_removed_ratio 0.22)", 20), "palpate.refined\n(tets_removed_ratio\n0.22)");
  assert.equal(wrapped("abcdefghij", 4), "abcd\nefgh\nij");
  assert.equal(wrapped("one_two_three", 8), "one_two_\nthree");
});

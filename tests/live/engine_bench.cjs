// What a step of the live page's engine costs in WebAssembly, in processor time, so that other work on the machine counts little. No test: it times.
//
//     node engine_bench.cjs ENGINE.js PAGE.html
"use strict";
const fs = require("fs");
const os = require("os");

const [engineFile, pageFile] = process.argv.slice(2);
const page = fs.readFileSync(pageFile, "utf8");
const part = (id) => page.match(new RegExp(`id="${id}">([^<]*)`))[1];
const body = JSON.parse(part("live-body"));
const bytes = Uint8Array.from(Buffer.from(part("live-arrays"), "base64")).buffer;
const TYPES = { f64: Float64Array, f32: Float32Array, u32: Uint32Array };
const array = (place) => new TYPES[place.type](bytes, place.at, place.count);
const SECONDS = 2;

require(engineFile)().then((engine) => {
  const give = (values) => {
    const at = engine._malloc(Math.max(8, values.byteLength));
    engine.HEAPU8.set(new Uint8Array(values.buffer, values.byteOffset, values.byteLength), at);
    return at;
  };
  const call = (name, ...values) => {
    if (engine.ccall(name, "number", values.map((value) => (typeof value === "string" ? "string" : "number")), values) !== 0)
      throw new Error(engine.ccall("live_message", "string", [], []));
  };
  const level = body.levels[0];
  const scratch = engine._malloc(256);
  const double = () => new Float64Array(engine.HEAPU8.buffer, scratch, 1)[0];
  const law = "corotated", euler = "symplectic_euler";
  const models = {
    springs: ["live_build_springs", "none", 0.6, "node", 1, law, euler],
    "springs, node_average": ["live_build_springs", "node_average", 0.6, "node", 1, law, euler],
    "edge_node, large strain": ["live_build_smoothed", 0, "node", "edge", 0, 1, law, euler],
    "edge_node, small strain": ["live_build_smoothed", 0, "node", "edge", 0, 0, law, euler],
    "linear tets, large strain": ["live_build_smoothed", 1, "tet", "tet", 0, 1, law, euler],
  };
  console.log(`${os.cpus()[0].model}, node ${process.version}; ${level.points.count / 3} vertices, ${level.tets.count / 4} tetrahedra, ${level.spring_rest_m.count} springs`);
  console.log("| model | a step, us of processor time | steps a second | stable step, us | simulated over processor time at 0.9 of it | load |\n|---|---|---|---|---|---|");
  for (const [name, build] of Object.entries(models)) {
    const tets = array(level.tets);
    call("live_setup", level.points.count / 3, give(array(level.points)), tets.length / 4, give(tets), body.young_modulus_pa, body.poisson_ratio, body.density_kg_m3, body.damping_stiffness_s, body.damping_mass_per_s);
    call("live_springs", level.spring_rest_m.count, give(array(level.spring_ends)), give(array(level.spring_rest_m)), give(array(level.spring_n_per_m)));
    for (const support of level.supports) call("live_support", support.weights.count, give(array(support.faces)), give(array(support.weights)), support.stiffness_pa_per_m);
    call(...build);
    call("live_predict_step", body.pad_pa_per_m, scratch, scratch + 8);
    const stable = double();
    const skin = body.table ? array(body.table.vertices)[7] : array(level.supports[0].faces)[0];
    call("live_press", skin, body.pad_radius_m, body.pad_pa_per_m);
    call("live_aim", 0, 0, 0.002, 0.1);
    call("live_step", 0.9 * stable, 50, scratch);
    const began = process.cpuUsage();
    let steps = 0, used = 0;
    for (; used < SECONDS * 1e6; steps += 20) {
      call("live_step", 0.9 * stable, 20, scratch);
      const now = process.cpuUsage(began);
      used = now.user + now.system;
    }
    const us = used / steps;
    console.log(`| ${name} | ${us.toFixed(0)} | ${(1e6 / us).toFixed(0)} | ${(1e6 * stable).toFixed(0)} | ${((0.9 * stable * 1e6) / us).toFixed(2)} | ${os.loadavg()[0].toFixed(1)} |`);
  }
}).catch((error) => {
  console.error(error);
  process.exit(1);
});

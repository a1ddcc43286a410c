// Runs a body of live_interface.h in WebAssembly and writes its state, for the tests that hold it against the same sources compiled natively.
//
//   node step_in_node.cjs ENGINE.js REQUEST.json STATE.bin
//
// REQUEST has the arrays of the setup, the model and the actions in order; STATE gets the displacements and the velocities of all vertices (doubles),
// then the numbers of live_report.
"use strict";
const fs = require("fs");

const [engineFile, requestFile, stateFile] = process.argv.slice(2);
const request = JSON.parse(fs.readFileSync(requestFile, "utf8"));

/** Copies an array into the engine's memory; the address. */
function give(engine, array) {
  const at = engine._malloc(Math.max(8, array.byteLength));
  new Uint8Array(engine.HEAPU8.buffer, at, array.byteLength).set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
  return at;
}

require(engineFile)().then((engine) => {
  const call = (name, types, ...values) => {
    if (engine.ccall(name, "number", types, values) !== 0) throw new Error(name + ": " + engine.ccall("live_message", "string", [], []));
  };
  const n = "number", s = "string";
  const { points, tets, springs, supports, model, actions } = request;
  call("live_setup", [n, n, n, n, n, n, n, n, n], points.length / 3, give(engine, new Float64Array(points)), tets.length / 4,
    give(engine, new Uint32Array(tets)), ...request.material, ...request.damping);
  call("live_springs", [n, n, n, n], springs.ends.length / 2, give(engine, new Uint32Array(springs.ends)),
    give(engine, new Float64Array(springs.rest_length_m)), give(engine, new Float64Array(springs.stiffness_n_per_m)));
  for (const support of supports)
    call("live_support", [n, n, n, n], support.weights.length, give(engine, new Uint32Array(support.faces)),
      give(engine, new Float64Array(support.weights)), support.stiffness_pa_per_m);
  if (model.smoothed) call("live_build_smoothed", [n, s, s, n, n, s, s], ...model.smoothed);
  else call("live_build_springs", [s, n, s, n, s, s], ...model.springs);
  const whole = engine._malloc(8);
  for (const [name, ...values] of actions)
    call(name, values.map(() => n), ...(name === "live_step" ? [...values, whole] : values));
  const vertices = points.length / 3;
  const at = engine._malloc(8 * (6 * vertices + 14));
  call("live_state", [n, n], at, at + 24 * vertices);
  call("live_report", [n], at + 48 * vertices);
  fs.writeFileSync(stateFile, Buffer.from(new Uint8Array(engine.HEAPU8.buffer, at, 8 * (6 * vertices + 14))));
}).catch((error) => {
  console.error(String(error && error.message || error));
  process.exit(1);
});

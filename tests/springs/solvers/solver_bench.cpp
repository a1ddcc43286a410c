// Identification by isotropy rows: rows, blocks and solution, from a kidney-sized cube of 1.3k to 93k
// vertices.
#include <benchmark/benchmark.h>

#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "core/springs/identification/isotropy_fit.h"
#include "core/springs/identification/isotropy_rows.h"

namespace {

using namespace palpate;

/// A cube of n^3 jittered cells, 0.1 m wide, and its springs.
void identify(benchmark::State& state, bool patch) {
  TetMesh mesh = build_kuhn_cube(static_cast<int>(state.range(0)), 0.3, 1);
  for (Vec3& point : mesh.points) point = 0.1 * point;
  SpringNetwork network;
  network.springs = build_edges(mesh);
  for (const auto& [a, b] : network.springs)
    network.rest_length_m.push_back(length(mesh.points[a] - mesh.points[b]));
  springs::IsotropyOptions options;
  options.patch = patch;
  springs::IsotropyReport report;
  for (auto _ : state) report = springs::identify_isotropy(mesh, 1e4, options, network);
  if (!report.solve.converged) state.SkipWithError("the solver did not converge");
  state.counters["vertices"] = static_cast<double>(mesh.points.size());
  state.counters["springs"] = static_cast<double>(network.springs.size());
  state.counters["kkt"] = report.solve.kkt_relative;
  state.counters["inner"] = static_cast<double>(report.solve.cg_iterations);
}

void isotropy(benchmark::State& state) {
  identify(state, false);
}
void isotropy_patch(benchmark::State& state) {
  identify(state, true);
}
// 1331, 10648 and 91125 vertices
BENCHMARK(isotropy)->Arg(10)->Arg(21)->Arg(44)->Unit(benchmark::kMillisecond);
BENCHMARK(isotropy_patch)->Arg(10)->Arg(21)->Arg(44)->Unit(benchmark::kMillisecond);

}  // namespace

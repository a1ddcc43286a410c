// palpate.surface against palpate.refined on the same bulged cubes, at 10k and 100k tets: what the guard of
// the skin costs. Counters: tets removed a second, and the share of the boundary faces that is left.
#include <benchmark/benchmark.h>

#include <map>

#include "core/mesh/shapes/shapes.h"
#include "core/simplify/refined/refined.h"
#include "core/simplify/surface/surface.h"

namespace {

using namespace palpate;

const TetMesh& bulged_cube(int cells) {
  static std::map<int, TetMesh> made;
  TetMesh& mesh = made[cells];
  if (!mesh.tets.empty()) return mesh;
  mesh = build_kuhn_cube(cells, 0.25, 1);
  for (Vec3& p : mesh.points) {
    const Vec3 q = p - Vec3{0.5, 0.5, 0.5};
    p = (1.0 + 0.2 * (0.75 - length_sq(q))) * q;
  }
  return mesh;
}

void add_sizes(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"cells", "removed_percent"})->Unit(benchmark::kMillisecond);
  for (const int cells : {12, 26}) {
    for (const int percent : {50, 90}) bench->Args({cells, percent});
  }
}

void bm_surface(benchmark::State& state) {
  const TetMesh& input = bulged_cube(static_cast<int>(state.range(0)));
  simplify::SurfaceOptions options;
  options.stop.ratio = 0.01 * static_cast<double>(state.range(1));
  options.max_surface_error = 0.02;
  simplify::SurfaceRunReport report;
  for (auto _ : state) {
    TetMesh mesh = input;
    report = simplify::simplify_surface(mesh, options);
  }
  state.counters["removed_per_s"] = benchmark::Counter(static_cast<double>(report.tets_in - report.tets_out),
                                                       benchmark::Counter::kIsIterationInvariantRate);
  state.counters["faces_left"] =
      static_cast<double>(report.boundary_faces_out) / static_cast<double>(report.boundary_faces_in);
}
BENCHMARK(bm_surface)->Apply(add_sizes);

void bm_refined(benchmark::State& state) {
  const TetMesh& input = bulged_cube(static_cast<int>(state.range(0)));
  simplify::RefinedOptions options;
  options.stop.ratio = 0.01 * static_cast<double>(state.range(1));
  std::uint64_t removed = 0;
  for (auto _ : state) {
    TetMesh mesh = input;
    const simplify::RefinedReport report = simplify::simplify_refined(mesh, options);
    removed = report.tets_in - report.tets_out;
  }
  state.counters["removed_per_s"] =
      benchmark::Counter(static_cast<double>(removed), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(bm_refined)->Apply(add_sizes);

}  // namespace

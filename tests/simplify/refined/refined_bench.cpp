// Times of palpate.refined at 10k, 100k and 1M tets in one run (PALPATE_BENCH_LARGE=1 for the last), by
// effort. Counter: tets removed a second.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <map>

#include "core/mesh/shapes/shapes.h"
#include "core/simplify/refined/refined.h"
#include "core/simplify/tet_operations/star_quality.h"

namespace {

using namespace palpate;

/// Cells a side of a jittered Kuhn cube: 10k, 105k, 998k tets.
void add_sizes(benchmark::internal::Benchmark* bench) {
  for (const int cells : {12, 26}) bench->Args({cells, 1});
  for (const int effort : {0, 2, 3, 4, 5}) bench->Args({12, effort});
  if (std::getenv("PALPATE_BENCH_LARGE") != nullptr) bench->Args({55, 1});
  bench->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
}

const TetMesh& cube(int cells) {
  static std::map<int, TetMesh> made;
  auto& mesh = made[cells];
  if (mesh.tets.empty()) mesh = build_kuhn_cube(cells, 0.25, 1);
  return mesh;
}

void refined_to_half(benchmark::State& state) {
  const TetMesh& input = cube(static_cast<int>(state.range(0)));
  simplify::RefinedOptions options;
  options.stop.ratio = 0.5;
  options.effort = static_cast<int>(state.range(1));
  std::uint64_t removed = 0;
  for (auto _ : state) {
    state.PauseTiming();
    TetMesh mesh = input;
    state.ResumeTiming();
    const simplify::RefinedReport report = simplify::simplify_refined(mesh, options);
    removed += report.tets_in - report.tets_out;
  }
  state.counters["removed_per_s"] =
      benchmark::Counter(static_cast<double>(removed), benchmark::Counter::kIsRate);
}
BENCHMARK(refined_to_half)->Apply(add_sizes);

/// One question to a star of 24 tets, about what a free vertex has around it.
void cone_of_24(benchmark::State& state) {
  const SurfaceMesh sphere = build_geodesic_sphere(2);
  simplify::StarQuality star;
  star.start(simplify::scale_of_ideal_volume(0.05), {});
  for (std::size_t f = 0; f < 24; ++f) {
    const Triangle& t = sphere.triangles[f];
    star.add(sphere.points[t[0]], sphere.points[t[1]], sphere.points[t[2]]);
  }
  star.close();
  Vec3 apex{0.01, 0.02, 0.03};
  for (auto _ : state) {
    benchmark::DoNotOptimize(apex);
    benchmark::DoNotOptimize(star.evaluate(apex));
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(24 * state.iterations()));
}
BENCHMARK(cone_of_24);

}  // namespace

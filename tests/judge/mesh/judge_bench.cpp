// Speed of the judge, in tets a second, on jittered Kuhn cubes. PALPATE_BENCH_LARGE=1 adds 4 million tets.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <span>
#include <string_view>

#include "core/base/random.h"
#include "core/judge/mesh/judge.h"
#include "core/judge/surface/surface.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

/// A cube of n^3 cells with its inner vertices moved by up to 0.1 an axis.
TetMesh make_jittered_cube(int n) {
  TetMesh mesh = make_kuhn_block(n, n, n);
  SplitMix64 random(42);
  for (const Index v : interior_vertices_of_block(n, n, n)) {
    const Vec3 step{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    mesh.points[v] = mesh.points[v] + 0.2 * step;
  }
  return mesh;
}

void set_sizes(benchmark::internal::Benchmark* bench) {
  bench->ArgName("cells_a_side")->Unit(benchmark::kMillisecond);
  bench->Arg(12)->Arg(26)->Arg(55);  // 10 thousand, 100 thousand, 1 million tets
  const char* large = std::getenv("PALPATE_BENCH_LARGE");
  if (large != nullptr && std::string_view(large) == "1") bench->Arg(87);
}

void set_rate(benchmark::State& state, const TetMesh& mesh) {
  state.counters["tets"] = static_cast<double>(mesh.tets.size());
  state.counters["tets_per_s"] = benchmark::Counter(static_cast<double>(mesh.tets.size()),
                                                    benchmark::Counter::kIsIterationInvariantRate);
}

void bm_validity(benchmark::State& state) {
  const TetMesh mesh = make_jittered_cube(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const Validity result = check_validity(mesh);
    if (!result.is_valid()) state.SkipWithError("the mesh of the benchmark is not valid");
  }
  set_rate(state, mesh);
}
BENCHMARK(bm_validity)->Apply(set_sizes);

/// The same cube with its vertices and tets in random order: every star and every point is a cache miss.
void bm_validity_shuffled(benchmark::State& state) {
  TetMesh mesh = make_jittered_cube(static_cast<int>(state.range(0)));
  SplitMix64 random(43);
  std::vector<Index> number(mesh.points.size());
  std::iota(number.begin(), number.end(), Index{0});
  shuffle(std::span<Index>(number), random);
  const std::vector<Vec3> points = mesh.points;
  for (std::size_t v = 0; v < points.size(); ++v) mesh.points[number[v]] = points[v];
  for (Tet& tet : mesh.tets) {
    for (Index& v : tet) v = number[v];
  }
  shuffle(std::span<Tet>(mesh.tets), random);
  for (auto _ : state) {
    const Validity result = check_validity(mesh);
    if (!result.is_valid()) state.SkipWithError("the mesh of the benchmark is not valid");
  }
  set_rate(state, mesh);
}
BENCHMARK(bm_validity_shuffled)->Apply(set_sizes);

void bm_counts(benchmark::State& state) {
  const TetMesh mesh = make_jittered_cube(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    if (!count_elements(mesh).formula_a2) state.SkipWithError("the mesh of the benchmark is no ball");
  }
  set_rate(state, mesh);
}
BENCHMARK(bm_counts)->Apply(set_sizes);

void bm_quality(benchmark::State& state) {
  const TetMesh mesh = make_jittered_cube(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    if (!(measure_quality(mesh).min_quality > 0.0)) state.SkipWithError("a quality of zero");
  }
  set_rate(state, mesh);
}
BENCHMARK(bm_quality)->Apply(set_sizes);

void bm_comparison(benchmark::State& state) {
  const TetMesh mesh = make_jittered_cube(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    if (compare_with_input(mesh, mesh).boundary_changed_faces != 0) state.SkipWithError("a changed boundary");
  }
  set_rate(state, mesh);
}
BENCHMARK(bm_comparison)->Apply(set_sizes);

void set_frequencies(benchmark::internal::Benchmark* bench) {
  bench->ArgName("frequency")->Unit(benchmark::kMillisecond);
  bench->Arg(8)->Arg(22)->Arg(71);  // 1 thousand, 10 thousand, 100 thousand triangles
}

void set_triangle_rate(benchmark::State& state, const SurfaceMesh& surface) {
  state.counters["triangles"] = static_cast<double>(surface.triangles.size());
  state.counters["triangles_per_s"] = benchmark::Counter(static_cast<double>(surface.triangles.size()),
                                                         benchmark::Counter::kIsIterationInvariantRate);
}

/// The bean against a coarser one.
void bm_surface_distance(benchmark::State& state) {
  const auto frequency = static_cast<int>(state.range(0));
  const SurfaceMesh fine = build_bean_surface(frequency);
  const SurfaceMesh coarse = build_bean_surface(frequency * 2 / 3);
  for (auto _ : state) {
    const SurfaceDistance distance = measure_surface_distance(coarse, fine);
    const double gap = std::max(0.001 * distance.lower(), 1e-7 * distance.diagonal);
    if (distance.upper() > distance.lower() + 1.001 * gap) state.SkipWithError("the bracket is too wide");
  }
  set_triangle_rate(state, fine);
}
BENCHMARK(bm_surface_distance)->Apply(set_frequencies);

void bm_self_intersections(benchmark::State& state) {
  const SurfaceMesh bean = build_bean_surface(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    if (count_self_intersections(bean) != 0) state.SkipWithError("the bean runs through itself");
  }
  set_triangle_rate(state, bean);
}
BENCHMARK(bm_self_intersections)->Apply(set_frequencies);

}  // namespace
}  // namespace palpate::judge

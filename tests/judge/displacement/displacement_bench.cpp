// Speed of the judge's displacement errors and of the transfer between meshes, in points a second.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/judge/displacement/displacement.h"
#include "core/mesh/shapes/shapes.h"

namespace palpate::judge {
namespace {

std::vector<Vec3> bent_field(const TetMesh& mesh) {
  std::vector<Vec3> field;
  field.reserve(mesh.points.size());
  for (const Vec3& p : mesh.points) field.push_back({p.x * p.y, p.z * p.z, std::sin(3.0 * p.x)});
  return field;
}

void set_rate(benchmark::State& state, std::size_t points) {
  state.counters["points"] = static_cast<double>(points);
  state.counters["points_per_s"] =
      benchmark::Counter(static_cast<double>(points), benchmark::Counter::kIsIterationInvariantRate);
}

void compare_at_vertices(benchmark::State& state) {
  const TetMesh mesh = build_kuhn_cube(static_cast<int>(state.range(0)), 0.2, 1);
  const std::vector<Vec3> truth = bent_field(mesh);
  std::vector<Vec3> field = truth;
  for (Vec3& u : field) u = 1.01 * u;
  for (auto _ : state) benchmark::DoNotOptimize(compare_displacement(mesh, field, truth, 1.0, 1.0));
  set_rate(state, field.size());
}

/// From a mesh of other vertices, half as many cells a side.
void transfer_between_meshes(benchmark::State& state) {
  const auto cells = static_cast<int>(state.range(0));
  const TetMesh fine = build_kuhn_cube(cells, 0.2, 1);
  const TetMesh coarse = build_kuhn_cube(cells / 2, 0.2, 2);
  const std::vector<Vec3> field = bent_field(coarse);
  for (auto _ : state) benchmark::DoNotOptimize(transfer_field(coarse, field, fine.points));
  set_rate(state, fine.points.size());
}

// 2 thousand, 15 thousand and 100 thousand vertices.
BENCHMARK(compare_at_vertices)->Arg(12)->Arg(24)->Arg(46)->Unit(benchmark::kMillisecond);
BENCHMARK(transfer_between_meshes)->Arg(12)->Arg(24)->Arg(46)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace palpate::judge

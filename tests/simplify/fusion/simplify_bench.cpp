// Times of levels, the hierarchical simplifier and sequential TetFusion, at 10k, 100k and 1M tets in one run
// (4M with PALPATE_BENCH_LARGE=1). Counters: tets removed a second, and peak memory above the start, bytes a
// tet.
#include <benchmark/benchmark.h>

#include "core/mesh/shapes/shapes.h"
#include "core/simplify/fusion/cheapest_first.h"
#include "core/simplify/fusion/hierarchical.h"
#include "reference/tetfusion/sequential.h"
#include "tests/support/simplify_bench.h"

namespace {

using namespace palpate;
using namespace palpate::bench_support;

void levels(benchmark::State& state) {
  const TetMesh& input = cube(static_cast<int>(state.range(0)));
  const auto flags = build_boundary_vertex_flags(input);
  const simplify::FusionMesh work =
      simplify::build_fusion_mesh(TetMesh(input), simplify::StorageOrder::kSpatial);
  for (auto _ : state) {
    benchmark::DoNotOptimize(simplify::build_levels(work, flags, simplify::LevelAdjacency::kVertex));
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * input.tets.size()));
}
BENCHMARK(levels)->Apply(add_sizes);

void hierarchical_to_limit(benchmark::State& state) {
  run(state, [](TetMesh& mesh) { return simplify::simplify_hierarchical(mesh, {}); });
}
BENCHMARK(hierarchical_to_limit)->Apply(add_sizes);

void hierarchical_unsorted_to_limit(benchmark::State& state) {
  simplify::SimplifyOptions options;
  options.storage = simplify::StorageOrder::kInput;
  run(state, [&](TetMesh& mesh) { return simplify::simplify_hierarchical(mesh, options); });
}
BENCHMARK(hierarchical_unsorted_to_limit)->Apply(add_sizes);

/// The same on two threads. On a machine that is busy, compare processor time with it, too: the share of a
/// run that two threads can halve is in the difference.
void hierarchical_on_two_threads(benchmark::State& state) {
  simplify::SimplifyOptions options;
  options.threads = 2;
  run(state, [&](TetMesh& mesh) { return simplify::simplify_hierarchical(mesh, options); });
}
BENCHMARK(hierarchical_on_two_threads)->Apply(add_sizes);

void cheapest_first_by_three_tenths(benchmark::State& state) {
  simplify::CheapestFirstOptions options;
  options.common.stop.ratio = 0.3;
  run(state, [&](TetMesh& mesh) { return simplify::simplify_cheapest_first(mesh, options); });
}
BENCHMARK(cheapest_first_by_three_tenths)->Apply(add_sizes);

/// Multi-pass sequential TetFusion down to where the hierarchical one stops: the same removal, side by side.
void sequential_to_the_same_count(benchmark::State& state) {
  TetMesh limit = cube(static_cast<int>(state.range(0)));
  simplify::simplify_hierarchical(limit, {});
  reference::SequentialOptions options;
  options.common.skip_touched = true;
  options.many_passes = true;
  options.common.stop.tets = limit.tets.size();
  limit = {};
  run(state, [&](TetMesh& mesh) { return reference::simplify_sequentially(mesh, options); });
}
BENCHMARK(sequential_to_the_same_count)->Apply(add_sizes);

}  // namespace

// Times of levels, the hierarchical simplifier and sequential TetFusion, at 10k, 100k and 1M tets in one run
// (4M with PALPATE_BENCH_LARGE=1). Counters: tets removed a second, and peak memory above the start, bytes a
// tet.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <string>

#include "core/mesh/shapes.h"
#include "core/simplify/hierarchical.h"
#include "core/simplify/outcome.h"
#include "reference/tetfusion/sequential.h"

namespace {

using namespace palpate;

/// Cells a side of a jittered Kuhn cube: 10k, 105k, 998k, 3.95M tets.
void add_sizes(benchmark::internal::Benchmark* bench) {
  for (const int cells : {12, 26, 55}) bench->Arg(cells);
  if (std::getenv("PALPATE_BENCH_LARGE") != nullptr) bench->Arg(87);
  bench->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
}

const TetMesh& cube(int cells) {
  static std::map<int, TetMesh> made;
  auto& mesh = made[cells];
  if (mesh.tets.empty()) mesh = build_kuhn_cube(cells, 0.25, 1);
  return mesh;
}

/// Peak and present resident memory of this process; the peak starts anew at reset_peak().
std::uint64_t read_status(const char* key) {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    if (word != key) continue;
    std::uint64_t kilobytes = 0;
    status >> kilobytes;
    return kilobytes * 1024;
  }
  return 0;
}
void reset_peak() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

void report(benchmark::State& state, std::uint64_t removed, double bytes_per_tet) {
  state.counters["removed_per_s"] =
      benchmark::Counter(static_cast<double>(removed), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["removed"] = static_cast<double>(removed);
  if (bytes_per_tet > 0.0) state.counters["bytes_per_tet"] = bytes_per_tet;
}

/// Runs `simplify` on copies of the cube; the copy is not timed. Memory: the peak above what stood before the
/// copy.
template <typename Simplify>
void run(benchmark::State& state, Simplify&& simplify) {
  const TetMesh& input = cube(static_cast<int>(state.range(0)));
  std::uint64_t removed = 0;
  double bytes_per_tet = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    const std::uint64_t before = read_status("VmRSS:");
    reset_peak();
    TetMesh mesh = input;
    state.ResumeTiming();
    const simplify::SimplifyReport result = simplify(mesh);
    state.PauseTiming();
    removed = result.tets_in - result.tets_out;
    const std::uint64_t peak = read_status("VmHWM:");
    bytes_per_tet =
        peak > before ? static_cast<double>(peak - before) / static_cast<double>(input.tets.size()) : 0.0;
    state.ResumeTiming();
  }
  report(state, removed, bytes_per_tet);
}

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

void outcome_by_three_tenths(benchmark::State& state) {
  simplify::OutcomeOptions options;
  options.common.stop.ratio = 0.3;
  run(state, [&](TetMesh& mesh) { return simplify::simplify_by_outcome(mesh, options); });
}
BENCHMARK(outcome_by_three_tenths)->Apply(add_sizes);

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

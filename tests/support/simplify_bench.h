// What the benchmarks of simplifiers share: cubes of 10k, 105k and 1M tets (4M with PALPATE_BENCH_LARGE=1),
// and the counters: tets removed a second, and peak memory above the start, bytes a tet.
#pragma once

#include <benchmark/benchmark.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <string>

#include "core/mesh/shapes/shapes.h"
#include "core/simplify/fusion/hierarchical.h"

namespace palpate::bench_support {

/// Cells a side of a jittered Kuhn cube: 10k, 105k, 998k, 3.95M tets.
inline void add_sizes(benchmark::internal::Benchmark* bench) {
  for (const int cells : {12, 26, 55}) bench->Arg(cells);
  if (std::getenv("PALPATE_BENCH_LARGE") != nullptr) bench->Arg(87);
  bench->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
}

inline const TetMesh& cube(int cells) {
  static std::map<int, TetMesh> made;
  auto& mesh = made[cells];
  if (mesh.tets.empty()) mesh = build_kuhn_cube(cells, 0.25, 1);
  return mesh;
}

/// Peak and present resident memory of this process; the peak starts anew at reset_peak().
inline std::uint64_t read_status(const char* key) {
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
inline void reset_peak() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

inline void report(benchmark::State& state, std::uint64_t removed, double bytes_per_tet) {
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

}  // namespace palpate::bench_support

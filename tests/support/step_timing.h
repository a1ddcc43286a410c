// How benchmarks of engines time their steps, all in one way: docs/engine_speed.md.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "core/base/stopwatch.h"

namespace palpate::testing_support {

inline double seconds_of_this_thread() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Times `work` so many times; returns the medians of its seconds, by the wall and by this thread. All of it
/// is one iteration to the library: a benchmark is then set up once a repetition, which takes long at 1M
/// vertices.
template <typename Work>
std::array<double, 2> time_medians(benchmark::State& state, int times, const Work& work) {
  std::vector<double> wall;
  std::vector<double> cpu;
  while (state.KeepRunning()) {
    for (int k = 0; k < times; ++k) {
      const double cpu_start = seconds_of_this_thread();
      const Stopwatch watch;
      work();
      wall.push_back(watch.seconds());
      cpu.push_back(seconds_of_this_thread() - cpu_start);
    }
    state.SetIterationTime(median(wall));
  }
  return {median(wall), median(cpu)};
}

/// Times `take_steps(count)` of a body with so many `parts` (springs, tets) at least 15 times, with as many
/// steps at once as the clock needs (some 0.2 ms); for an engine that starts its threads at each call with
/// enough to make that small: 20, at 1M vertices 4. Counters: ns_per_PART and cpu_ns_per_PART of one step.
template <typename TakeSteps>
void time_steps_of(benchmark::State& state, double parts, const char* part, const TakeSteps& take_steps,
                   bool starts_threads) {
  const double at_once = starts_threads ? std::clamp(3e7 / parts, 4.0, 20.0) : 150000.0 / parts;
  const auto steps = static_cast<std::uint64_t>(std::clamp(at_once, 1.0, 20.0));
  const double times = (starts_threads ? 2e8 : 4e7) / (static_cast<double>(steps) * parts);
  const auto [wall, cpu] =
      time_medians(state, static_cast<int>(std::clamp(times, 15.0, 1500.0)), [&] { take_steps(steps); });
  const double share = 1e9 / (static_cast<double>(steps) * parts);
  state.counters[std::string("ns_per_") + part] = share * wall;
  state.counters[std::string("cpu_ns_per_") + part] = share * cpu;
}

/// Labels a row with the hash of a state.
inline void set_hash(benchmark::State& state, std::uint64_t hash, const char* kind) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%016llx %s", static_cast<unsigned long long>(hash), kind);
  state.SetLabel(text.data());
}

}  // namespace palpate::testing_support

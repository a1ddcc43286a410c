// The order by cost beside the thesis's, at 10k, 105k and 1M tets in one run.
#include "core/simplify/fusion/cheapest_first.h"

#include <benchmark/benchmark.h>

#include "core/simplify/fusion/hierarchical.h"
#include "tests/support/simplify_bench.h"

namespace {

using namespace palpate;
using namespace palpate::bench_support;

/// Removes a share of the tets, 1.0 for all that can go.
void by_cost(benchmark::State& state, double share) {
  run(state, [&](TetMesh& mesh) {
    simplify::CheapestFirstOptions options;
    if (share < 1.0) options.common.stop.ratio = share;
    return simplify::simplify_cheapest_first(mesh, options);
  });
}

/// The thesis's order with the same candidates and checks.
void hierarchical(benchmark::State& state, double share) {
  run(state, [&](TetMesh& mesh) {
    simplify::SimplifyOptions options = simplify::CheapestFirstOptions().common;
    options.skip_touched = false;
    if (share < 1.0) options.stop.ratio = share;
    return simplify::simplify_hierarchical(mesh, options);
  });
}

void by_cost_22_percent(benchmark::State& state) {
  by_cost(state, 0.22);
}
BENCHMARK(by_cost_22_percent)->Apply(add_sizes);

void hierarchical_22_percent(benchmark::State& state) {
  hierarchical(state, 0.22);
}
BENCHMARK(hierarchical_22_percent)->Apply(add_sizes);

void by_cost_50_percent(benchmark::State& state) {
  by_cost(state, 0.5);
}
BENCHMARK(by_cost_50_percent)->Apply(add_sizes);

void hierarchical_50_percent(benchmark::State& state) {
  hierarchical(state, 0.5);
}
BENCHMARK(hierarchical_50_percent)->Apply(add_sizes);

void by_cost_to_limit(benchmark::State& state) {
  by_cost(state, 1.0);
}
BENCHMARK(by_cost_to_limit)->Apply(add_sizes);

}  // namespace

// The order by outcome beside the thesis's, at 10k, 105k and 1M tets in one run.
#include "core/simplify/fusion/outcome.h"

#include <benchmark/benchmark.h>

#include "core/simplify/fusion/hierarchical.h"
#include "tests/support/simplify_bench.h"

namespace {

using namespace palpate;
using namespace palpate::bench_support;

/// Removes a share of the tets, 1.0 for all that can go.
void by_outcome(benchmark::State& state, double share) {
  run(state, [&](TetMesh& mesh) {
    simplify::OutcomeOptions options;
    if (share < 1.0) options.common.stop.ratio = share;
    return simplify::simplify_by_outcome(mesh, options);
  });
}

/// The thesis's order with the same candidates and checks.
void hierarchical(benchmark::State& state, double share) {
  run(state, [&](TetMesh& mesh) {
    simplify::SimplifyOptions options = simplify::OutcomeOptions().common;
    options.skip_touched = false;
    if (share < 1.0) options.stop.ratio = share;
    return simplify::simplify_hierarchical(mesh, options);
  });
}

void outcome_22_percent(benchmark::State& state) {
  by_outcome(state, 0.22);
}
BENCHMARK(outcome_22_percent)->Apply(add_sizes);

void hierarchical_22_percent(benchmark::State& state) {
  hierarchical(state, 0.22);
}
BENCHMARK(hierarchical_22_percent)->Apply(add_sizes);

void outcome_50_percent(benchmark::State& state) {
  by_outcome(state, 0.5);
}
BENCHMARK(outcome_50_percent)->Apply(add_sizes);

void hierarchical_50_percent(benchmark::State& state) {
  hierarchical(state, 0.5);
}
BENCHMARK(hierarchical_50_percent)->Apply(add_sizes);

void outcome_to_limit(benchmark::State& state) {
  by_outcome(state, 1.0);
}
BENCHMARK(outcome_to_limit)->Apply(add_sizes);

}  // namespace

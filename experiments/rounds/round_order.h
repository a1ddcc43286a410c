// The order of a round: random, seeded, and each case behind those that it needs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "experiments/plan_reader/case_list.h"

namespace palpate::experiments {

/// The order in which a round (repeat 0, 1, ... of every case) takes the cases: all of them, each once.
///
/// A permutation drawn from the seed and the repeat alone, so that neither a choice of cases nor a resumption
/// changes it. Each case whose stop or judgement needs another one (Case::tets_of, Case::coarser) comes after
/// it. A drift of the machine, and what one contestant leaves in caches and clocks for the next, meets all
/// alike over the rounds.
std::vector<std::size_t> order_round(const std::vector<Case>& cases, std::uint64_t seed, int repeat);

}  // namespace palpate::experiments

#include "experiments/rounds/round_order.h"

#include <numeric>
#include <span>

#include "core/base/random.h"

namespace palpate::experiments {
namespace {

/// Puts a case into the order, after those that it needs.
void place_case(const std::vector<Case>& cases, std::size_t index, std::vector<bool>& placed,
                std::vector<std::size_t>& order) {
  if (placed[index]) return;
  placed[index] = true;  // needs go to earlier cases alone, so that there is no circle
  for (const auto& needed : {cases[index].tets_of, cases[index].coarser}) {
    if (needed) place_case(cases, *needed, placed, order);
  }
  order.push_back(index);
}

}  // namespace

std::vector<std::size_t> order_round(const std::vector<Case>& cases, std::uint64_t seed, int repeat) {
  std::vector<std::size_t> drawn(cases.size());
  std::iota(drawn.begin(), drawn.end(), std::size_t{0});
  // Seeds next to each other, and repeats, must not share a stretch of one sequence.
  SplitMix64 of_seed(seed);
  SplitMix64 random(of_seed.next() ^ SplitMix64(static_cast<std::uint64_t>(repeat)).next());
  shuffle(std::span<std::size_t>(drawn), random);
  std::vector<std::size_t> order;
  order.reserve(cases.size());
  std::vector<bool> placed(cases.size(), false);
  for (const std::size_t index : drawn) place_case(cases, index, placed, order);
  return order;
}

}  // namespace palpate::experiments

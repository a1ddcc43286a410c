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
  // Neither seeds next to each other nor repeats may share a sequence, or a stretch of one.
  SplitMix64 of_round(SplitMix64(seed).next() + static_cast<std::uint64_t>(repeat));
  SplitMix64 random(of_round.next());
  shuffle(std::span<std::size_t>(drawn), random);
  std::vector<std::size_t> order;
  order.reserve(cases.size());
  std::vector<bool> placed(cases.size(), false);
  for (const std::size_t index : drawn) place_case(cases, index, placed, order);
  return order;
}

}  // namespace palpate::experiments

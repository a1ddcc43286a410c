// Refused candidates, each parked on the tet that failed it.
#pragma once

#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/simplify/fusion/fusion.h"

namespace palpate::simplify {

/// Doubly linked lists of the candidates that are parked on each tet.
struct Parking {
  std::vector<Index> first;  ///< of the candidates parked on this tet
  std::vector<Index> next;   ///< of the candidates on the same witness
  std::vector<Index> previous;
  std::vector<Index> witness;  ///< of this candidate: the present one, or the last

  explicit Parking(std::size_t tets)
      : first(tets, kNoIndex), next(tets, kNoIndex), previous(tets, kNoIndex), witness(tets, kNoIndex) {}

  void park(Index candidate, Index on) {
    witness[candidate] = on;
    previous[candidate] = kNoIndex;
    next[candidate] = first[on];
    if (first[on] != kNoIndex) previous[first[on]] = candidate;
    first[on] = candidate;
  }

  void leave(Index candidate) {
    if (previous[candidate] == kNoIndex) {
      first[witness[candidate]] = next[candidate];
    } else {
      next[previous[candidate]] = next[candidate];
    }
    if (next[candidate] != kNoIndex) previous[next[candidate]] = previous[candidate];
  }

  /// Calls wake(candidate) for all that are parked on a tet that the fusion moved or removed, and takes them
  /// off it.
  template <typename Wake>
  void wake_witnesses_of(const FusionPlan& plan, Wake&& wake) {
    const auto wake_all_on = [&](Index tet) {
      Index candidate = std::exchange(first[tet], kNoIndex);
      while (candidate != kNoIndex) {
        const Index following = next[candidate];  // wake may park it anew
        wake(candidate);
        candidate = following;
      }
    };
    for (const MovedTet& m : plan.moved) wake_all_on(m.tet);
    for (const Index t : plan.dead) wake_all_on(t);
  }
};

}  // namespace palpate::simplify

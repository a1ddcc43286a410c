// Refused candidates, each parked on the tet that failed it.
#pragma once

#include <vector>

#include "core/base/types.h"

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
};

}  // namespace palpate::simplify

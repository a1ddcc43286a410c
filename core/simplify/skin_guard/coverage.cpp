#include "core/simplify/skin_guard/coverage.h"

namespace palpate::simplify {

Coverage::Coverage(std::size_t faces)
    : covering_(faces), covered_by_(faces), input_reach_(faces, 0.0), face_reach_(faces, 0.0) {
  for (Index f = 0; f < faces; ++f) {
    covering_[f] = {f};
    covered_by_[f] = {f};
  }
}

void Coverage::enter(Index f, double reach) {
  if (face_reach_.size() <= f) {
    face_reach_.resize(f + 1, 0.0);
    covered_by_.resize(f + 1);
  }
  face_reach_[f] = reach;
}

}  // namespace palpate::simplify

// Do two boundary faces run into each other? Decided exactly, so that no operation on the skin lets it.
#pragma once

#include <array>

#include "core/base/types.h"

namespace palpate::simplify {

/// A face by the numbers and the places of its corners.
struct PlacedFace {
  Triangle vertices{};
  std::array<Vec3, 3> corner{};
};

/// Whether two faces meet elsewhere than in the vertices (by number) and the edge that they share. Touching
/// and overlapping in one plane count, and so does a face without area, whatever the other one is.
/// Requires: as orientation().
bool are_in_contact(const PlacedFace& a, const PlacedFace& b);

}  // namespace palpate::simplify

// Weights of faces on which what acts is uneven, so that linear elements feel it where it is.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace palpate {

/// A face is divided into so many equal parts where a region's share of it is looked for: 16 along a side.
constexpr int kPartsAlongSide = 16;
constexpr int kPartsOfFace = kPartsAlongSide * kPartsAlongSide;  ///< all of them

/// Calls visit(u, v) with the centroid of each part, a + u (b - a) + v (c - a).
template <typename Visit>
void for_each_part(Visit&& visit) {
  const double step = 1.0 / kPartsAlongSide;
  for (int i = 0; i < kPartsAlongSide; ++i) {
    for (int j = 0; i + j < kPartsAlongSide; ++j) {
      visit((i + 1.0 / 3.0) * step, (j + 1.0 / 3.0) * step);
      if (i + j + 1 < kPartsAlongSide) visit((i + 2.0 / 3.0) * step, (j + 2.0 / 3.0) * step);
    }
  }
}

/// What acts on a face of the skin, as a density between 0 and 1: its mean, and the integral of each corner's
/// linear function times the density, over the face's area. `share` is the sum of the three; they are equal
/// where the density is.
struct FaceCover {
  Triangle face;
  double area = 0.0;
  double share = 0.0;
  std::array<double, 3> corners{};
};

/// One weight a face, at least 0 and possibly above 1: even densities in the place of uneven ones.
///
/// A mean spread evenly over a coarse face reaches farther than the density did; the faces beside it can have
/// more or less to make up for that. Weights minimise, over the vertices v and faces f,
///
///     sum_v (sum_f A_f w_f / 3 - R_v)^2 / (A / 3)^2 + sum_f (w_f - share_f)^2 / 100,    w_f >= 0,
///
/// R_v the integral of the vertex's linear function times the density and A the mean area, by coordinate
/// descent (Gauss and Seidel, projected): what linear elements see of it stays, with no more change than that
/// takes. Faces without a corner of an uneven face keep their shares, and so does the sum of A_f w_f.
///
/// Requires: areas > 0, shares above 0. Returns shares, to the bit, where all densities are even.
std::vector<double> match_moments(std::span<const FaceCover> covers);

}  // namespace palpate

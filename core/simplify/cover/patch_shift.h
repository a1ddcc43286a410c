// How far a piece of the skin shifts when other faces take the place of some: two sheets with one outline,
// seen along a direction.
#pragma once

#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/simplify/cover/sheet_cover.h"

namespace palpate::simplify {

/// What is known of a face of one sheet: no point of it is farther than `reach` from the faces `over` of the
/// other.
struct FaceShift {
  double reach = 0.0;
  std::vector<Index> over;
};

/// Both sheets' faces, held against the other's.
class PatchShift {
 public:
  /// Whether each face of either sheet is proven to be near the other, within the limit of `sheet`, which has
  /// made the tiles. Where not, nothing is known.
  bool measure(SheetCover& sheet, std::span<const Tile> gone, std::span<const Tile> fresh);

  const FaceShift& of_gone(std::size_t k) const { return gone_[k]; }
  const FaceShift& of_fresh(std::size_t k) const { return fresh_[k]; }

 private:
  static bool hold(SheetCover& sheet, std::span<const Tile> faces, std::span<const Tile> others,
                   std::vector<FaceShift>& shifts);

  std::vector<FaceShift> gone_;
  std::vector<FaceShift> fresh_;
};

}  // namespace palpate::simplify

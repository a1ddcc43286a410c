// Faces by place: a grid of cells, by hash.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/geometry.h"

namespace palpate::simplify {

/// Faces, by the cells that their boxes meet.
class FaceGrid {
 public:
  /// Cells with edges of length `cell`, for about so many faces.
  FaceGrid(double cell, std::size_t faces);

  double cell() const { return cell_; }

  void enter(Index f, const BoundingBox& box);
  /// Throws: ContractError if the face is not where the box says.
  void leave(Index f, const BoundingBox& box);

  /// Calls visit(f) for each face in a cell that the box meets, once.
  template <typename Visit>
  void for_each_near(const BoundingBox& box, const Visit& visit) {
    ++visit_;
    for_each_cell(box, [&](std::size_t cell) {
      for (const Index f : cells_[cell]) {
        if (visited_[f] == visit_) continue;
        visited_[f] = visit_;
        visit(f);
      }
    });
  }

 private:
  static std::uint64_t hash(std::int64_t x, std::int64_t y, std::int64_t z);

  template <typename Visit>
  void for_each_cell(const BoundingBox& box, const Visit& visit) const {
    const auto range = [this](double low, double high) {
      const auto cell = [this](double x) { return static_cast<std::int64_t>(std::floor(x / cell_)); };
      return std::pair{cell(low), cell(high)};
    };
    const auto [x0, x1] = range(box.low.x, box.high.x);
    const auto [y0, y1] = range(box.low.y, box.high.y);
    const auto [z0, z1] = range(box.low.z, box.high.z);
    for (std::int64_t x = x0; x <= x1; ++x) {
      for (std::int64_t y = y0; y <= y1; ++y) {
        for (std::int64_t z = z0; z <= z1; ++z) visit(hash(x, y, z) & (cells_.size() - 1));
      }
    }
  }

  double cell_;
  std::vector<std::vector<Index>> cells_;
  std::uint64_t visit_ = 0;
  std::vector<std::uint64_t> visited_;  ///< of each face: the last visit
};

}  // namespace palpate::simplify

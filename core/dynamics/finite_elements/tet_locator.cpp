#include "core/dynamics/finite_elements/tet_locator.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

/// As far outside, in heights of the tet, as rounding may put a point.
constexpr double kMostOutside = 1e-6;

constexpr std::size_t kMostCellsPerTet = 16;
constexpr std::size_t kFewestCells = 4096;

std::array<double, 4> barycentric(const TetMesh& mesh, const Tet& tet, const Vec3& point) {
  std::array<Vec3, 4> corner{};
  for (std::size_t i = 0; i < 4; ++i) corner[i] = mesh.points[tet[i]];
  const double whole = signed_volume(corner[0], corner[1], corner[2], corner[3]);
  std::array<double, 4> at{};
  for (std::size_t i = 0; i < 4; ++i) {
    std::array<Vec3, 4> part = corner;
    part[i] = point;
    at[i] = signed_volume(part[0], part[1], part[2], part[3]) / whole;
  }
  return at;
}

BoundingBox box_of(const TetMesh& mesh, const Tet& tet) {
  std::array<Vec3, 4> corner{};
  for (std::size_t i = 0; i < 4; ++i) corner[i] = mesh.points[tet[i]];
  return bounding_box(corner);
}

}  // namespace

TetLocator::TetLocator(const TetMesh& mesh) : mesh_(mesh) {
  const BoundingBox whole = bounding_box(mesh.points);
  low_ = whole.low;
  double sides = 0.0;  // the mean side of the tets' boxes
  for (const Tet& tet : mesh.tets) sides += longest_side(box_of(mesh, tet));
  if (!mesh.tets.empty() && sides > 0.0) cell_ = sides / static_cast<double>(mesh.tets.size());
  // Of a filled body there are fewer cells than tets; small tets in a large box would ask for any number.
  const double most = static_cast<double>(std::max(kFewestCells, kMostCellsPerTet * mesh.tets.size()));
  const auto cells_along = [&](std::size_t axis) {
    return std::floor(component(whole.high - whole.low, axis) / cell_) + 1.0;
  };
  while (cells_along(0) * cells_along(1) * cells_along(2) > most) cell_ *= 2.0;
  for (std::size_t axis = 0; axis < 3; ++axis) count_[axis] = static_cast<std::size_t>(cells_along(axis));
  // Twice: once to count, once to fill.
  offsets_.assign(count_[0] * count_[1] * count_[2] + 1, 0);
  const auto visit = [&](auto&& use) {
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      const BoundingBox box = box_of(mesh, mesh.tets[t]);
      for (std::size_t i = cell_of(box.low, 0); i <= cell_of(box.high, 0); ++i) {
        for (std::size_t j = cell_of(box.low, 1); j <= cell_of(box.high, 1); ++j) {
          for (std::size_t k = cell_of(box.low, 2); k <= cell_of(box.high, 2); ++k)
            use(number_of(i, j, k), static_cast<Index>(t));
        }
      }
    }
  };
  visit([&](std::size_t cell, Index) { ++offsets_[cell + 1]; });
  for (std::size_t c = 1; c < offsets_.size(); ++c) offsets_[c] += offsets_[c - 1];
  tets_.resize(offsets_.back());
  std::vector<std::size_t> next(offsets_.begin(), offsets_.end() - 1);
  visit([&](std::size_t cell, Index tet) { tets_[next[cell]++] = tet; });
}

std::size_t TetLocator::cell_of(const Vec3& point, std::size_t axis) const {
  const double place = std::floor(component(point - low_, axis) / cell_);
  return static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(count_[axis] - 1)));
}

std::size_t TetLocator::number_of(std::size_t i, std::size_t j, std::size_t k) const {
  return (i * count_[1] + j) * count_[2] + k;
}

TetPlace TetLocator::find(const Vec3& point) const {
  const std::size_t cell = number_of(cell_of(point, 0), cell_of(point, 1), cell_of(point, 2));
  TetPlace best;
  double most = -INFINITY;  // the least coordinate in the best tet
  for (std::size_t n = offsets_[cell]; n < offsets_[cell + 1]; ++n) {
    const std::array<double, 4> at = barycentric(mesh_, mesh_.tets[tets_[n]], point);
    const double least = *std::min_element(at.begin(), at.end());
    if (!(least > most)) continue;
    most = least;
    best = {tets_[n], at};
    if (least >= 0.0) return best;
  }
  if (!(most >= -kMostOutside))
    throw InputError("point", 0, "a point of the body",
                     "(" + std::to_string(point.x) + ", " + std::to_string(point.y) + ", " +
                         std::to_string(point.z) + ") m, outside of it");
  return best;
}

Vec3 evaluate(const ElementSpace& space, std::span<const Vec3> field, const TetPlace& place) {
  require(field.size() == space.nodes(), "one value a node");
  const Index* nodes = space.tet_nodes.data() + place.tet * space.nodes_per_tet();
  Vec3 sum;
  for (std::size_t i = 0; i < 4; ++i) {
    const double l = place.at[i];
    sum = sum + (space.order == 1 ? l : l * (2.0 * l - 1.0)) * field[nodes[i]];
  }
  if (space.order == 1) return sum;
  for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
    const double product = place.at[static_cast<std::size_t>(kTetEdges[e][0])] *
                           place.at[static_cast<std::size_t>(kTetEdges[e][1])];
    sum = sum + (4.0 * product) * field[nodes[4 + e]];
  }
  return sum;
}

}  // namespace palpate::dynamics

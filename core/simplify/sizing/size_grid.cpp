#include "core/simplify/sizing/size_grid.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"

namespace palpate::simplify {
namespace {

constexpr double kCellOverSpacing = 0.75;
constexpr double kMostCellsAlong = 512.0;
constexpr double kMostRatio = 1000.0;
/// Barycentric coordinates of a place on a face, by rounding.
constexpr double kOnFace = -1e-9;

std::vector<double> relative_sizes(const TetMesh& mesh, std::span<const double> sizes) {
  if (sizes.size() != mesh.points.size())
    throw InputError("sizes", 0, "one for each of " + std::to_string(mesh.points.size()) + " vertices",
                     std::to_string(sizes.size()));
  for (std::size_t v = 0; v < sizes.size(); ++v) {
    if (!(sizes[v] > 0.0 && std::isfinite(sizes[v])))
      throw InputError("sizes", 0, "finite numbers above 0",
                       short_number(sizes[v]) + " at vertex " + std::to_string(v));
  }
  if (sizes.empty()) return {};
  const double least = *std::min_element(sizes.begin(), sizes.end());
  const double most = *std::max_element(sizes.begin(), sizes.end());
  if (most > kMostRatio * least)
    throw InputError("sizes", 0, "none more than 1000 times another",
                     short_number(least) + " and " + short_number(most));
  std::vector<double> relative(sizes.size());
  std::transform(sizes.begin(), sizes.end(), relative.begin(), [&](double s) { return s / most; });
  return relative;
}

}  // namespace

SizeGrid::SizeGrid(const TetMesh& mesh, std::span<const double> sizes) {
  const std::vector<double> relative = relative_sizes(mesh, sizes);
  if (mesh.tets.empty()) throw InputError("sizes", 0, "a mesh with tetrahedra", "none");
  lay_out(mesh);
  for (const Tet& tet : mesh.tets) fill_tet(mesh, tet, relative);
  fill_at_vertices(mesh, relative);
  fill_outside();
  least_ = *std::min_element(value_.begin(), value_.end());
}

/// The box with a cell to spare on each side.
void SizeGrid::lay_out(const TetMesh& mesh) {
  const BoundingBox box = bounding_box(mesh.points);
  const double room = std::fabs(total_volume(mesh)) / static_cast<double>(mesh.points.size());
  cell_ = std::max(kCellOverSpacing * std::cbrt(room), longest_side(box) / kMostCellsAlong);
  low_ = box.low - Vec3{cell_, cell_, cell_};
  const Vec3 size = box.high - box.low;
  std::size_t count = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    nodes_[axis] = static_cast<std::size_t>(std::ceil(component(size, axis) / cell_)) + 3;
    count *= nodes_[axis];
  }
  value_.assign(count, 0.0F);
}

void SizeGrid::fill_tet(const TetMesh& mesh, const Tet& tet, std::span<const double> relative) {
  std::array<Vec3, 4> p;
  for (std::size_t i = 0; i < 4; ++i) p[i] = mesh.points[tet[i]];
  const double volume = signed_volume(p[0], p[1], p[2], p[3]);
  if (!(volume > 0.0)) return;
  const BoundingBox box = bounding_box(p);
  std::array<std::size_t, 3> from{};
  std::array<std::size_t, 3> to{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double first = (component(box.low, axis) - component(low_, axis)) / cell_;
    const double last = (component(box.high, axis) - component(low_, axis)) / cell_;
    from[axis] = static_cast<std::size_t>(std::ceil(first));
    to[axis] = std::min(static_cast<std::size_t>(std::floor(last)), nodes_[axis] - 1);
  }
  for (std::size_t k = from[2]; k <= to[2]; ++k) {
    for (std::size_t j = from[1]; j <= to[1]; ++j) {
      for (std::size_t i = from[0]; i <= to[0]; ++i) {
        float& value = value_[index(i, j, k)];
        if (value > 0.0F) continue;
        const Vec3 x =
            low_ + cell_ * Vec3{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
        const std::array<double, 4> share{
            signed_volume(x, p[1], p[2], p[3]) / volume, signed_volume(p[0], x, p[2], p[3]) / volume,
            signed_volume(p[0], p[1], x, p[3]) / volume, signed_volume(p[0], p[1], p[2], x) / volume};
        if (std::any_of(share.begin(), share.end(), [](double s) { return s < kOnFace; })) continue;
        double sum = 0.0;
        for (std::size_t c = 0; c < 4; ++c) sum += share[c] * relative[tet[c]];
        value = static_cast<float>(std::clamp(sum, 1.0 / kMostRatio, 1.0));
      }
    }
  }
}

/// Parts of the body that are thinner than a cell may have no node inside: there the node next to a vertex
/// has the mean of such vertices.
void SizeGrid::fill_at_vertices(const TetMesh& mesh, std::span<const double> relative) {
  std::vector<std::pair<std::size_t, double>> found;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    std::array<std::size_t, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      at[axis] = static_cast<std::size_t>(
          std::lround((component(mesh.points[v], axis) - component(low_, axis)) / cell_));
    const std::size_t node = index(at[0], at[1], at[2]);
    if (value_[node] > 0.0F) continue;
    found.emplace_back(node, relative[v]);
  }
  std::sort(found.begin(), found.end());
  for (std::size_t i = 0; i < found.size();) {
    double sum = 0.0;
    std::size_t end = i;
    for (; end < found.size() && found[end].first == found[i].first; ++end) sum += found[end].second;
    value_[found[i].first] = static_cast<float>(sum / static_cast<double>(end - i));
    i = end;
  }
}

/// Layer after layer, each node the mean of its known neighbours along the axes.
void SizeGrid::fill_outside() {
  const std::array<std::size_t, 3> stride{1, nodes_[0], nodes_[0] * nodes_[1]};
  const auto for_neighbours = [&](std::size_t node, const auto& visit) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t along = node / stride[axis] % nodes_[axis];
      if (along > 0) visit(node - stride[axis]);
      if (along + 1 < nodes_[axis]) visit(node + stride[axis]);
    }
  };
  std::vector<std::size_t> layer;
  std::vector<std::uint8_t> is_waiting(value_.size(), 0);
  const auto wait_for = [&](std::size_t node, std::vector<std::size_t>& next) {
    if (value_[node] > 0.0F || is_waiting[node] != 0) return;
    is_waiting[node] = 1;
    next.push_back(node);
  };
  for (std::size_t node = 0; node < value_.size(); ++node) {
    if (value_[node] > 0.0F) for_neighbours(node, [&](std::size_t other) { wait_for(other, layer); });
  }
  std::vector<float> fresh;
  std::vector<std::size_t> next;
  while (!layer.empty()) {
    fresh.clear();
    for (const std::size_t node : layer) {
      float sum = 0.0F;
      float count = 0.0F;
      for_neighbours(node, [&](std::size_t other) {
        if (!(value_[other] > 0.0F)) return;
        sum += value_[other];
        count += 1.0F;
      });
      fresh.push_back(sum / count);
    }
    for (std::size_t i = 0; i < layer.size(); ++i) value_[layer[i]] = fresh[i];
    next.clear();
    for (const std::size_t node : layer)
      for_neighbours(node, [&](std::size_t other) { wait_for(other, next); });
    layer.swap(next);
  }
}

double SizeGrid::at(const Vec3& x) const {
  std::array<std::size_t, 3> cell{};
  std::array<double, 3> share{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double along = (component(x, axis) - component(low_, axis)) / cell_;
    const double most = static_cast<double>(nodes_[axis] - 1);
    const double inside = std::clamp(along, 0.0, most);
    cell[axis] = std::min(static_cast<std::size_t>(inside), nodes_[axis] - 2);
    share[axis] = inside - static_cast<double>(cell[axis]);
  }
  const auto along_x = [&](std::size_t j, std::size_t k) {
    const std::size_t first = index(cell[0], cell[1] + j, cell[2] + k);
    return (1.0 - share[0]) * static_cast<double>(value_[first]) +
           share[0] * static_cast<double>(value_[first + 1]);
  };
  const auto along_y = [&](std::size_t k) {
    return (1.0 - share[1]) * along_x(0, k) + share[1] * along_x(1, k);
  };
  return (1.0 - share[2]) * along_y(0) + share[2] * along_y(1);
}

std::shared_ptr<const SizeGrid> make_size_grid(const TetMesh& mesh, std::span<const double> sizes) {
  const std::vector<double> relative = relative_sizes(mesh, sizes);
  if (std::all_of(relative.begin(), relative.end(), [](double s) { return s == 1.0; })) return nullptr;
  return std::make_shared<const SizeGrid>(mesh, sizes);
}

}  // namespace palpate::simplify

#include "tests/support/marching_tets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "core/mesh/orientation.h"
#include "tests/support/small_meshes.h"

namespace palpate::testing_support {
namespace {

using Wedge = std::array<Index, 6>;  // two triangles, 0 1 2 and 3 4 5; corner k is joined with k + 3

class LevelCut {
 public:
  LevelCut(const TetMesh& grid, const std::function<double(const Vec3&)>& level) : grid_(grid) {
    cut_.points = grid.points;
    for (const Vec3& p : grid.points) {
      const double value = level(p);
      values_.push_back(value != 0.0 ? value : 1e-12);
    }
  }

  TetMesh make() {
    for (const Tet& tet : grid_.tets) take(tet);
    std::vector<Index> number(cut_.points.size(), kNoIndex);
    TetMesh mesh;
    for (Tet& tet : cut_.tets) {
      for (Index& v : tet) {
        if (number[v] == kNoIndex) {
          number[v] = static_cast<Index>(mesh.points.size());
          mesh.points.push_back(cut_.points[v]);
        }
        v = number[v];
      }
    }
    mesh.tets = std::move(cut_.tets);
    return mesh;
  }

 private:
  void take(const Tet& tet) {
    std::vector<Index> in;
    std::vector<Index> out;
    for (const Index v : tet) (values_[v] > 0.0 ? in : out).push_back(v);
    if (in.size() == 4) add(tet);
    if (in.size() == 1)
      add({in[0], crossing(in[0], out[0]), crossing(in[0], out[1]), crossing(in[0], out[2])});
    if (in.size() == 2)
      divide({in[0], crossing(in[0], out[0]), crossing(in[0], out[1]), in[1], crossing(in[1], out[0]),
              crossing(in[1], out[1])});
    if (in.size() == 3)
      divide(
          {in[0], in[1], in[2], crossing(in[0], out[0]), crossing(in[1], out[0]), crossing(in[2], out[0])});
  }

  Index crossing(Index a, Index b) {
    const auto [entry, is_new] =
        crossings_.try_emplace(std::minmax(a, b), static_cast<Index>(cut_.points.size()));
    if (is_new) {
      const double share = values_[a] / (values_[a] - values_[b]);
      cut_.points.push_back(grid_.points[a] + share * (grid_.points[b] - grid_.points[a]));
    }
    return entry->second;
  }

  void divide(Wedge w) {
    const auto least = static_cast<std::size_t>(std::min_element(w.begin(), w.end()) - w.begin());
    if (least >= 3) std::rotate(w.begin(), w.begin() + 3, w.end());
    std::rotate(w.begin(), w.begin() + least % 3, w.begin() + 3);
    std::rotate(w.begin() + 3, w.begin() + 3 + least % 3, w.end());
    add({w[0], w[3], w[4], w[5]});
    if (std::min(w[1], w[5]) < std::min(w[2], w[4])) {
      add({w[0], w[1], w[2], w[5]});
      add({w[0], w[1], w[5], w[4]});
    } else {
      add({w[0], w[1], w[2], w[4]});
      add({w[0], w[2], w[4], w[5]});
    }
  }

  void add(Tet tet) {
    const auto sign = [&] {
      return orientation(cut_.points[tet[0]], cut_.points[tet[1]], cut_.points[tet[2]], cut_.points[tet[3]]);
    };
    if (sign() < 0) std::swap(tet[2], tet[3]);
    cut_.tets.push_back(tet);
  }

  const TetMesh& grid_;
  std::vector<double> values_;
  std::map<std::pair<Index, Index>, Index> crossings_;
  TetMesh cut_;
};

}  // namespace

TetMesh cut_by_level(const TetMesh& grid, const std::function<double(const Vec3&)>& level) {
  return LevelCut(grid, level).make();
}

TetMesh make_marching_ring(int n) {
  TetMesh grid = make_kuhn_block(4 * n, 4 * n, 2 * n);
  const double cell = 0.5 / n;
  for (Vec3& p : grid.points) p = cell * p - Vec3{1.0, 1.0, 0.5};
  return cut_by_level(grid, [](const Vec3& p) {
    const double z = p.z - 0.11 * p.x + 0.07 * p.y;  // askew: the skin crosses edges at any place
    const double from_axis = std::hypot(p.x, p.y);
    return 0.31 - std::hypot(from_axis - 0.62, z);
  });
}

}  // namespace palpate::testing_support

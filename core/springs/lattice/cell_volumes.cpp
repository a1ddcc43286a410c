#include "core/springs/lattice/cell_volumes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/component.h"
#include "core/mesh/geometry.h"
#include "core/springs/lattice/cell_cuts.h"

namespace palpate::springs {
namespace {

using Piece = std::array<Vec3, 4>;

/// The prism between the triangles abc and def (a over d, b over e, c over f) as three tets.
void add_prism(const std::array<Vec3, 6>& p, std::vector<Piece>& pieces) {
  pieces.push_back({p[0], p[1], p[2], p[5]});
  pieces.push_back({p[0], p[1], p[4], p[5]});
  pieces.push_back({p[0], p[3], p[4], p[5]});
}

/// The tip at `apex` and the stump under it.
void cut_tip(const Vec3& apex, const std::array<Vec3, 3>& base, const std::array<Vec3, 3>& cut,
             std::vector<Piece>& tip, std::vector<Piece>& stump) {
  tip.push_back({apex, cut[0], cut[1], cut[2]});
  add_prism({cut[0], cut[1], cut[2], base[0], base[1], base[2]}, stump);
}

/// Cuts a tet at a plane; the signs of the parts' volumes are lost.
void cut_piece(const Piece& piece, std::size_t axis, double plane, std::vector<Piece>& below,
               std::vector<Piece>& above) {
  std::array<Vec3, 4> low;
  std::array<Vec3, 4> high;
  std::size_t lows = 0;
  std::size_t highs = 0;
  for (const Vec3& corner : piece) {
    if (component(corner, axis) <= plane) {
      low[lows++] = corner;
    } else {
      high[highs++] = corner;
    }
  }
  const auto at = [&](const Vec3& a, const Vec3& b) { return meet_plane(a, b, axis, plane); };
  if (highs == 0) {
    below.push_back(piece);
  } else if (lows == 0) {
    above.push_back(piece);
  } else if (lows == 1) {
    cut_tip(low[0], {high[0], high[1], high[2]},
            {at(low[0], high[0]), at(low[0], high[1]), at(low[0], high[2])}, below, above);
  } else if (highs == 1) {
    cut_tip(high[0], {low[0], low[1], low[2]},
            {at(low[0], high[0]), at(low[1], high[0]), at(low[2], high[0])}, above, below);
  } else {
    const Vec3 p00 = at(low[0], high[0]);
    const Vec3 p01 = at(low[0], high[1]);
    const Vec3 p10 = at(low[1], high[0]);
    const Vec3 p11 = at(low[1], high[1]);
    add_prism({low[0], p00, p01, low[1], p10, p11}, below);
    add_prism({high[0], p00, p10, high[1], p01, p11}, above);
  }
}

/// Hands out pieces to the cells, axis by axis.
class CellFiller {
 public:
  explicit CellFiller(const std::array<int, 3>& size)
      : size_(size),
        volumes_(static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
                 static_cast<std::size_t>(size[2])) {}

  void add(const Piece& piece, std::size_t axis = 0) {
    if (axis == 3) {
      const std::size_t cell = static_cast<std::size_t>(place_[0]) +
                               static_cast<std::size_t>(size_[0]) *
                                   (static_cast<std::size_t>(place_[1]) +
                                    static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(place_[2]));
      volumes_[cell] += std::fabs(signed_volume(piece[0], piece[1], piece[2], piece[3]));
      return;
    }
    const long outermost = size_[axis] - 1;
    CellSpan span = span_cells(piece, axis);
    span.first = std::clamp(span.first, 0L, outermost);
    span.last = std::clamp(span.last, span.first, outermost);
    const auto cut = [&](const Piece& each, double plane, std::vector<Piece>& below,
                         std::vector<Piece>& above) { cut_piece(each, axis, plane, below, above); };
    const auto take = [&](long cell, const std::vector<Piece>& pieces) {
      place_[axis] = static_cast<int>(cell);
      for (const Piece& each : pieces) add(each, axis + 1);
    };
    std::vector<Piece> rest{piece};
    cut_between_cells(span, cut, take, rest);
    take(span.last, rest);
  }

  std::vector<double> take() { return std::move(volumes_); }

 private:
  std::array<int, 3> size_;
  std::array<int, 3> place_{};
  std::vector<double> volumes_;
};

}  // namespace

std::vector<double> measure_cell_volumes(const TetMesh& body, const std::array<int, 3>& size) {
  CellFiller filler(size);
  for (const Tet& t : body.tets)
    filler.add({body.points[t[0]], body.points[t[1]], body.points[t[2]], body.points[t[3]]});
  return filler.take();
}

}  // namespace palpate::springs

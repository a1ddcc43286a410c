#include "core/springs/lattice/embedding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/error.h"

namespace palpate::springs {
namespace {

/// How far a place is from a cell, in spacings.
double distance_to(const std::array<double, 3>& p, const std::array<int, 3>& place) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double off = std::max({place[i] - p[i], p[i] - (place[i] + 1.0), 0.0});
    sum += off * off;
  }
  return std::sqrt(sum);
}

struct NearestCell {
  Index cell = kNoIndex;
  double distance = std::numeric_limits<double>::infinity();
};

/// Looks through cubes of places that grow around the point's own: one that is `ring` places away is at least
/// ring - 1 spacings away.
NearestCell find_nearest(const Lattice& lattice, const std::array<double, 3>& p) {
  std::array<int, 3> own{};
  int most = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    own[i] = std::clamp(static_cast<int>(std::floor(std::clamp(p[i], -1.0, lattice.size[i] + 1.0))), 0,
                        lattice.size[i] - 1);
    most = std::max(most, lattice.size[i]);
  }
  NearestCell nearest;
  for (int ring = 0; ring <= most && nearest.distance > ring - 1.0; ++ring) {
    for (int k = own[2] - ring; k <= own[2] + ring; ++k) {
      for (int j = own[1] - ring; j <= own[1] + ring; ++j) {
        const bool is_side = std::abs(k - own[2]) == ring || std::abs(j - own[1]) == ring;
        const int stride = is_side || ring == 0 ? 1 : 2 * ring;
        for (int i = own[0] - ring; i <= own[0] + ring; i += stride) {
          const Index cell = lattice.at({i, j, k});
          if (cell == kNoIndex) continue;
          const double distance = distance_to(p, {i, j, k});
          if (distance < nearest.distance || (distance == nearest.distance && cell < nearest.cell))
            nearest = {cell, distance};
        }
      }
    }
    if (nearest.distance == 0.0) break;
  }
  return nearest;
}

void add_point(const Lattice& lattice, Index cell, const std::array<double, 3>& p, Embedding& out) {
  std::array<double, 3> in{};
  double farthest = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    in[i] = p[i] - lattice.place[cell][i];
    farthest = std::max(farthest, std::fabs(in[i] - 0.5));
  }
  const bool has_centre = lattice.kind == LatticeKind::kBodyCentred;
  const double tent = has_centre ? std::max(0.0, 1.0 - 2.0 * farthest) : 0.0;
  for (std::size_t c = 0; c < 8; ++c) {
    double weight = -tent / 8.0;
    double product = 1.0;
    for (std::size_t i = 0; i < 3; ++i) product *= ((c >> i) & 1U) != 0 ? in[i] : 1.0 - in[i];
    weight += product;
    if (weight == 0.0) continue;
    out.nodes.push_back(lattice.corners[cell][c]);
    out.weights.push_back(weight);
  }
  if (tent > 0.0) {
    out.nodes.push_back(lattice.centres[cell]);
    out.weights.push_back(tent);
  }
  out.offsets.push_back(static_cast<Index>(out.nodes.size()));
}

}  // namespace

Embedding build_embedding(const Lattice& lattice, std::span<const Vec3> points) {
  require(lattice.cells() > 0, "a lattice has cells");
  constexpr double kOutside = 1e-9;  // of a spacing: rounding
  Embedding out;
  for (const Vec3& x : points) {
    if (!is_finite(x)) throw InputError("points", 0, "finite numbers", "a point that is not");
    const Vec3 at = lattice.frame.to_cells(x);
    const std::array<double, 3> p{at.x, at.y, at.z};
    const NearestCell nearest = find_nearest(lattice, p);
    require(nearest.cell != kNoIndex, "a cell is found");
    if (nearest.distance > kOutside) ++out.outside;
    out.farthest_cells = std::max(out.farthest_cells, nearest.distance);
    add_point(lattice, nearest.cell, p, out);
  }
  return out;
}

std::vector<Vec3> interpolate(const Embedding& embedding, std::span<const Vec3> at_nodes) {
  std::vector<Vec3> out(embedding.points());
  for (std::size_t p = 0; p < out.size(); ++p) {
    for (Index k = embedding.offsets[p]; k < embedding.offsets[p + 1]; ++k)
      out[p] = out[p] + embedding.weights[k] * at_nodes[embedding.nodes[k]];
  }
  return out;
}

void carry_back(const Embedding& embedding, std::span<const Vec3> at_points, std::span<Vec3> at_nodes) {
  require(at_points.size() == embedding.points(), "one force a point");
  for (std::size_t p = 0; p < at_points.size(); ++p) {
    for (Index k = embedding.offsets[p]; k < embedding.offsets[p + 1]; ++k) {
      Vec3& sum = at_nodes[embedding.nodes[k]];
      sum = sum + embedding.weights[k] * at_points[p];
    }
  }
}

}  // namespace palpate::springs

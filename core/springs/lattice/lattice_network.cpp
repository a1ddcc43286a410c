#include "core/springs/lattice/lattice_network.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "core/base/error.h"

namespace palpate::springs {
namespace {

struct WeightedEdge {
  Edge ends;
  double stiffness = 0.0;
};

/// Springs as they come, several between the same nodes.
class SpringList {
 public:
  void add(Index a, Index b, double stiffness) {
    if (stiffness > 0.0) springs_.push_back({{std::min(a, b), std::max(a, b)}, stiffness});
  }

  /// Each pair of nodes once, with the sum of its stiffness.
  SpringNetwork sum(const std::vector<Vec3>& nodes) {
    std::stable_sort(springs_.begin(), springs_.end(),
                     [](const WeightedEdge& a, const WeightedEdge& b) { return a.ends < b.ends; });
    SpringNetwork network;
    for (const WeightedEdge& each : springs_) {
      if (network.springs.empty() || network.springs.back() != each.ends) {
        network.springs.push_back(each.ends);
        network.rest_length_m.push_back(length(nodes[each.ends[1]] - nodes[each.ends[0]]));
        network.stiffness_n_per_m.push_back(0.0);
      }
      network.stiffness_n_per_m.back() += each.stiffness;
    }
    return network;
  }

 private:
  std::vector<WeightedEdge> springs_;
};

/// Shares of a hexahedral cell, in units of E h.
void add_hexahedral_cell(const std::array<Index, 8>& corners, double body_share, double unit,
                         SpringList& springs) {
  const std::array<double, 4> stiffness{0.0, 0.1 * (1.0 + body_share), 0.2 * (1.0 - body_share),
                                        0.3 * body_share};
  for (unsigned a = 0; a < 8; ++a) {
    for (unsigned b = a + 1; b < 8; ++b)
      springs.add(corners[a], corners[b], unit * stiffness[static_cast<std::size_t>(std::popcount(a ^ b))]);
  }
}

/// The corners of a cell's face; `side` 0 or 1.
std::array<Index, 4> face_corners(const std::array<Index, 8>& corners, unsigned axis, unsigned side) {
  std::array<Index, 4> face{};
  std::size_t count = 0;
  for (unsigned c = 0; c < 8; ++c) {
    if (((c >> axis) & 1U) == side) face[count++] = corners[c];
  }
  return face;
}

void add_body_centred_cell(const Lattice& lattice, std::size_t cell, double unit, SpringList& springs,
                           std::vector<HalfAxis>& half_axes) {
  const std::array<Index, 8>& corners = lattice.corners[cell];
  const Index centre = lattice.centres[cell];
  const double share = lattice.share[cell];
  for (unsigned c = 0; c < 8; ++c) {
    springs.add(corners[c], centre, 0.6 * share * unit);
    for (unsigned axis = 0; axis < 3; ++axis) {
      if (((c >> axis) & 1U) == 0) springs.add(corners[c], corners[c | (1U << axis)], 0.1 * share * unit);
    }
  }
  for (unsigned axis = 0; axis < 3; ++axis) {
    for (const unsigned side : {0U, 1U}) {
      std::array<int, 3> next = lattice.place[cell];
      next[axis] += side == 0 ? -1 : 1;
      const Index there = lattice.at(next);
      const double both = there == kNoIndex ? 0.0 : std::min(share, lattice.share[there]);
      if (both > 0.0) springs.add(centre, lattice.centres[there], 0.2 * both * unit);
      if (share > both)
        half_axes.push_back({centre, face_corners(corners, axis, side), lattice.frame.axes[axis],
                             0.8 * (share - both) * unit});
    }
  }
}

}  // namespace

LatticeSprings build_lattice_springs(const Lattice& lattice, double young_modulus_pa, const LatticeMix& mix) {
  if (!(young_modulus_pa > 0.0) || !std::isfinite(young_modulus_pa))
    throw InputError("young_modulus_pa", 0, "a finite number above 0", std::to_string(young_modulus_pa));
  constexpr double kMostBody = 0.9;
  constexpr double kMostFace = 0.9;
  if (!(mix.body_share >= 0.0 && mix.body_share <= kMostBody))
    throw InputError("body_share", 0, "0 to 0.9: without face diagonals the lattice is floppy",
                     std::to_string(mix.body_share));
  if (!(mix.face_share >= 0.0 && mix.face_share <= kMostFace))
    throw InputError("face_share", 0, "0 to 0.9: without half diagonals the centres are loose",
                     std::to_string(mix.face_share));
  SpringList springs;
  LatticeSprings out;
  const double unit = young_modulus_pa * lattice.frame.spacing_m;
  for (std::size_t cell = 0; cell < lattice.cells(); ++cell) {
    if (lattice.kind == LatticeKind::kHexahedral) {
      add_hexahedral_cell(lattice.corners[cell], mix.body_share, unit * lattice.share[cell], springs);
    } else {
      const double t = mix.face_share;
      add_body_centred_cell(lattice, cell, (1.0 - t) * unit, springs, out.half_axes);
      if (t > 0.0) add_hexahedral_cell(lattice.corners[cell], 0.0, t * unit * lattice.share[cell], springs);
    }
  }
  out.network = springs.sum(lattice.nodes);
  return out;
}

std::vector<double> build_lattice_masses(const Lattice& lattice, double density_kg_m3) {
  if (!(density_kg_m3 > 0.0) || !std::isfinite(density_kg_m3))
    throw InputError("density_kg_m3", 0, "a finite number above zero", std::to_string(density_kg_m3));
  std::vector<double> mass(lattice.nodes.size(), 0.0);
  const bool has_centres = lattice.kind == LatticeKind::kBodyCentred;
  for (std::size_t cell = 0; cell < lattice.cells(); ++cell) {
    const double whole = density_kg_m3 * lattice.cell_volume_m3() * lattice.share[cell];
    for (const Index corner : lattice.corners[cell]) mass[corner] += whole / (has_centres ? 16.0 : 8.0);
    if (has_centres) mass[lattice.centres[cell]] += 0.5 * whole;
  }
  return mass;
}

std::array<Vec3, 8> mean_cell_gradients(const Lattice& lattice) {
  const double quarter = 0.25 / lattice.frame.spacing_m;
  const auto sign = [&](std::size_t corner, std::size_t axis) {
    return ((corner >> axis) & 1U) != 0 ? quarter : -quarter;
  };
  std::array<Vec3, 8> gradients;
  for (std::size_t c = 0; c < 8; ++c) gradients[c] = lattice.frame.turn({sign(c, 0), sign(c, 1), sign(c, 2)});
  return gradients;
}

}  // namespace palpate::springs

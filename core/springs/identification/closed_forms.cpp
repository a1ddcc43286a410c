#include "core/springs/identification/closed_forms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/mesh/geometry.h"
#include "core/springs/network/tet_shares.h"

namespace palpate::springs {
namespace {

double volume_of(const TetMesh& mesh, const Tet& tet) {
  return signed_volume(mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]);
}

/// Adds of(tet, edge, spring) to the spring of each edge of each tet, edges numbered as in kTetEdges, and
/// gives springs between opposite apexes their share.
template <typename Of>
void sum_over_tets(const TetMesh& mesh, SpringNetwork& network, Of&& of) {
  TetShares shares(mesh, network);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    std::array<double, 6> found{};
    for (std::size_t i = 0; i < 6; ++i) found[i] = of(mesh.tets[t], i, shares.springs_of(t)[i]);
    shares.add(t, found);
  }
}

/// Area of the piece, in one tet, of the interface between the influence volumes of the edge's vertices.
double interface_area(const TetMesh& mesh, const Tet& tet, std::size_t edge) {
  const auto [i, j] = kTetEdges[edge];
  const auto [k, l] = kTetEdges[5 - edge];  // the opposite edge
  const Vec3 middle = 0.5 * (mesh.points[tet[i]] + mesh.points[tet[j]]);
  return length(cross(mesh.points[tet[k]] - middle, mesh.points[tet[l]] - middle)) / 12.0;
}

}  // namespace

void set_uniform(const TetMesh& mesh, double young_modulus_pa, std::optional<double> given,
                 SpringNetwork& network) {
  double stiffness = 0.0;
  if (given) {
    stiffness = *given;
  } else {
    double length_sq = 0.0;
    for (const double u : network.rest_length_m) length_sq += u * u;
    stiffness = 6.0 * young_modulus_pa * total_volume(mesh) / length_sq;
  }
  std::fill(network.stiffness_n_per_m.begin(), network.stiffness_n_per_m.end(), stiffness);
}

void set_van_gelder(const TetMesh& mesh, double young_modulus_pa, SpringNetwork& network) {
  sum_over_tets(mesh, network, [&](const Tet& tet, std::size_t, Index spring) {
    const double l = network.rest_length_m[spring];
    return young_modulus_pa * volume_of(mesh, tet) / (l * l);
  });
}

void set_lloyd(const TetMesh& mesh, double young_modulus_pa, SpringNetwork& network) {
  const double factor = 2.0 * std::sqrt(2.0) / 25.0 * young_modulus_pa * std::cbrt(6.0 * std::sqrt(2.0));
  sum_over_tets(mesh, network,
                [&](const Tet& tet, std::size_t, Index) { return factor * std::cbrt(volume_of(mesh, tet)); });
}

void set_maciel(const TetMesh& mesh, double young_modulus_pa, SpringNetwork& network) {
  sum_over_tets(mesh, network, [&](const Tet& tet, std::size_t edge, Index spring) {
    return young_modulus_pa * interface_area(mesh, tet, edge) / network.rest_length_m[spring];
  });
}

}  // namespace palpate::springs

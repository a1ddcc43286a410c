// What a method finds tet by tet, handed to the springs.
#pragma once

#include <array>
#include <vector>

#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::springs {

/// Adds up constants that are found for the six edges of each tet. Where the network has springs between
/// opposite apexes too, a tet shares its sum of k l^2 out: with f of its faces inside the mesh, its edges
/// keep 6 / (6 + f) of their constants, and each of its f opposite springs gets 1 / (6 + f) of the sum. So
/// what a method says of sum k l^2 (6 E V for Van Gelder) holds with opposite springs as without. The rule is
/// ours.
class TetShares {
 public:
  /// Sets all constants of `network` to zero. `network` must be build_spring_network(mesh) and outlive this.
  /// Throws: ContractError if an edge of the mesh has no spring.
  TetShares(const TetMesh& mesh, SpringNetwork& network);

  /// Springs of the tet's edges, in the order of kTetEdges.
  const std::array<Index, 6>& springs_of(std::size_t tet) const { return tet_springs_[tet]; }

  /// `stiffness_n_per_m`: of the tet's edges, in the order of kTetEdges.
  void add(std::size_t tet, const std::array<double, 6>& stiffness_n_per_m);

 private:
  void find_opposite(const TetMesh& mesh);

  SpringNetwork& network_;
  std::vector<std::array<Index, 6>> tet_springs_;
  std::vector<std::array<Index, 4>> opposite_;  ///< a tet's springs to other apexes, kNoIndex after the last
};

}  // namespace palpate::springs

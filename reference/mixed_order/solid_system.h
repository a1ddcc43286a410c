// A body in quadratic elements, some of whose nodes may follow others: its equations, and its answer.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/dynamics/finite_elements/node_loads.h"
#include "core/dynamics/finite_elements/node_map.h"
#include "core/dynamics/reduced/modal_basis.h"

namespace palpate::reference {

/// A mesh, its quadratic elements, and which of their nodes are unknown.
struct SolidSpace {
  TetMesh mesh;
  dynamics::ElementSpace space;
  dynamics::NodeMap map;
};

/// Stiffness of the unknowns, of the body alone and of its supports.
struct SolidSystem {
  dynamics::ElementMatrices body;  ///< the stiffness alone
  dynamics::BlockMatrix supports;
  std::vector<std::uint8_t> held;
  std::vector<Vec3> held_by_m;

  /// s K + S.
  dynamics::BlockMatrix stiffness(double modulus_scale) const;
};

/// Assembles it; `loads` are those of solid.space.
SolidSystem build_solid_system(const SolidSpace& solid, const Material& material,
                               const dynamics::NodeLoads& loads);

/// All forces on the nodes of a space: dead loads, and what moved supports pull with.
std::vector<Vec3> sum_forces(const dynamics::NodeLoads& loads, int order);

/// What an answer of quadratic elements reports beside times.
///
/// Shape:  `all_m` has one entry a node of the space.
struct SolidFigures {
  double energy_j = 0.0;
  double potential_j = 0.0;
  double residual_relative = 0.0;  ///< forces out of balance at free unknowns, over all forces on them
  std::vector<Vec3> support_forces_n;
};
SolidFigures measure_solid(const SolidSpace& solid, const SolidSystem& system,
                           const dynamics::NodeLoads& loads, double modulus_scale,
                           std::span<const Vec3> unknown_m, std::size_t supports);

/// Adds them to a report, with outcome and iterations.
void report_figures(const SolidFigures& figures, nlohmann::json& report);

/// The same loads and holding, but nothing pulls: supports and held faces rest, dead loads are gone.
BoundaryProblem holding_of(const BoundaryProblem& problem);

/// What a displacement is once its best rigid motion is taken off: by least squares with weights, such as the
/// volumes around vertices.
class Deformation {
 public:
  /// Around the vertices of a mesh, a quarter of each tet's volume a corner.
  explicit Deformation(const TetMesh& mesh);
  /// Takes the best rigid motion off.
  void take_off_rigid(std::vector<Vec3>& field) const;
  /// The weighted product of two fields.
  double product(std::span<const Vec3> a, std::span<const Vec3> b) const;

 private:
  std::vector<double> weights_;
  std::array<std::vector<Vec3>, 6> motions_;  ///< orthonormal in the product
};

}  // namespace palpate::reference

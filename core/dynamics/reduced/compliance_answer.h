// What a table of compliances answers: any supports, held faces and loads on the skin, by a small dense
// system.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/dynamics/reduced/compliance_table.h"
#include "core/mesh/boundary_problem.h"

namespace palpate::dynamics {

/// An answer of a table.
///
/// Shape:  displacement_m has one entry a vertex of the mesh; skin_force_n and skin_m one a node of the skin:
///         all forces on it, reactions among them, and its displacement in the mean that works with them.
struct ComplianceAnswer {
  std::vector<Vec3> displacement_m;
  std::vector<Vec3> skin_force_n;
  std::vector<Vec3> skin_m;
  double energy_j = 0.0;     ///< elastic, of the body
  double potential_j = 0.0;  ///< with that of the supports, less the work of the loads
  /// Of the small system: what holding and elasticity leave over, over the largest terms.
  double residual_relative = 0.0;
  std::vector<Vec3> support_forces_n;  ///< integral of stiffness x (by - u), one a support of the problem
};

/// A body on given supports and held faces. Factors are made once; loads may then change.
///
/// With reactions r on the touched components (supports S with their consistent mass W, held ones H), loads q
/// elsewhere and a rigid motion R a:
///
///   (A_TT / E + W^-1 on S) r + R_T a = W^-1 W by on S, by on H,  less A_TL q / E
///   R_T^T r = -(R^T q + work of the weight)
///
/// The block, with a multiple of R_T R_T^T (R_T^T r is known), is symmetric and positive definite: Cholesky,
/// then six unknowns more.
class HeldBody {
 public:
  /// `table` and `mesh` must outlive it. What holds the body is taken from `problem`; its loads are not yet.
  ///
  /// Throws: InputError if the table is of another mesh or another Poisson's ratio, the strain is large, a
  ///         rigid motion is left free, or the problem is wrong.
  HeldBody(const ComplianceTable& table, const TetMesh& mesh, const BoundaryProblem& problem);
  ~HeldBody();

  /// Touched components, supports and held faces together.
  std::size_t touched() const;

  /// Brings the loads of a problem to the skin: gravity, tractions, nodal forces, and how far supports and
  /// held faces move, which may differ from those that it was made for.
  ///
  /// Throws: InputError for other supports or held faces, a force on a vertex inside the body, or a body
  ///         force that varies.
  struct SkinLoad;
  std::unique_ptr<SkinLoad> prepare(const BoundaryProblem& problem) const;

  /// Reactions and rigid motion for a load: all that contact needs. Time: touched^2, and touched x loaded.
  void react(SkinLoad& load) const;
  /// The displacement of the skin's vertices after react(), then of those inside. Time: of one product.
  void move_skin(SkinLoad& load) const;
  void move_inside(SkinLoad& load) const;

  /// All of it, with energies.
  ComplianceAnswer solve(const BoundaryProblem& problem) const;
  ComplianceAnswer finish(const SkinLoad& load) const;

  struct State;

 private:
  std::unique_ptr<State> state_;
};

/// What a load of a held body is while it is worked on.
///
/// Shape:  force_n and displacement_m hold three numbers a node of the skin, or a vertex in the table's
/// order.
struct HeldBody::SkinLoad {
  std::vector<double> external_n;       ///< on the skin, without reactions
  std::vector<std::size_t> loaded;      ///< components of it that are not zero
  std::vector<double> holding_m;        ///< right side of the touched components
  std::vector<double> support_force_n;  ///< W by and what held components do to supported ones
  std::array<double, 6> resultant{};    ///< work of loads and weight in the six rigid motions
  std::array<double, 6> weight{};       ///< that of the weight alone
  BoundaryProblem problem;
  std::vector<double> force_n;  ///< all forces on the skin
  std::array<double, 6> rigid{};
  std::vector<double> displacement_m;
};

}  // namespace palpate::dynamics

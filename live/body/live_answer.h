// The finite elements' answer to the same finger, from a table of compliances: small strain, at rest.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/dynamics/reduced/compliance_answer.h"

namespace palpate::live {

/// A body whose skin answers a pad at once. It is linear in how far the pad is moved: a pad costs a small
/// factorisation and three products with the table, a move three numbers times three fields.
class LiveAnswer {
 public:
  /// `table` may lack the rows of `field` behind those of the skin: the inside is not moved. Throws:
  /// InputError as HeldBody does.
  LiveAnswer(TetMesh mesh, dynamics::ComplianceTable table, BoundaryProblem holding);

  /// Another pad. Throws: InputError as HeldBody does.
  void press(const FacePatch& patch, double stiffness_pa_per_m);
  void release();

  /// The skin's vertices, rising: the order of displacement().
  const std::vector<Index>& vertices() const { return table_.nodes.vertices; }

  /// Of the skin's vertices, in m, with the pad moved by `by_m`; zero without one.
  std::vector<Vec3> displacement(const Vec3& by_m) const;
  /// The pad's force on the body, in N.
  Vec3 pad_force(const Vec3& by_m) const;

 private:
  TetMesh mesh_;
  dynamics::ComplianceTable table_;
  BoundaryProblem holding_;
  std::array<std::vector<Vec3>, 3> unit_;  ///< with the pad moved by 1 m along each axis
  std::array<Vec3, 3> unit_force_n_;
  bool is_pressed_ = false;
};

}  // namespace palpate::live

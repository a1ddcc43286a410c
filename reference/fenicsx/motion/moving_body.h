// A body with its masses and everything that acts on it over time.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "reference/door/motion_problem.h"
#include "reference/fenicsx/statics/boundary_terms.h"
#include "reference/fenicsx/statics/elastic_body.h"

namespace palpate::reference::fenicsx {

/// Where the body is: displacement, velocity and acceleration, with ghosts up to date.
struct MotionState {
  double time_s = 0.0;
  Vector displacement;
  Vector velocity;
  Vector acceleration;
};

/// The matrices of a body and its groups of loads: group 0 is what holds it all the time, group k load k - 1.
class MovingBody {
 public:
  /// Assembles stiffness and mass as matrices of type `type`. `mesh`, `problem` and `body` must outlive it.
  MovingBody(const TetMesh& mesh, const MotionProblem& problem, ElasticBody& body, const char* type);

  ElasticBody& body() const { return body_; }
  const MotionProblem& problem() const { return problem_; }
  const Matrix& stiffness() const { return stiffness_; }  ///< of the body alone
  const Matrix& mass() const { return mass_; }

  /// The groups that are there in a phase. Throws: InputError if two of them hold one component of a node.
  std::vector<std::size_t> groups_of(const LoadPhase& phase) const;
  /// Global rows that the groups hold.
  std::vector<PetscInt> held_rows(const std::vector<std::size_t>& groups) const;
  /// The body's stiffness with the groups' supports, assembled.
  Matrix stiffness_with(const std::vector<std::size_t>& groups) const;

  /// Puts held entries of displacement, velocity and acceleration where the profiles have them.
  void impose(const std::vector<std::size_t>& groups, const MotionState& state) const;
  /// Sets the entries that the groups hold to zero.
  void clear_held(const std::vector<std::size_t>& groups, const Vector& vector) const;
  /// loads(t) + supports - M (a + alpha v) - K (u + beta v): the force that is missing.
  Vector residual(const std::vector<std::size_t>& groups, const MotionState& state) const;
  /// The row of the history.
  std::vector<double> measure(const std::vector<std::size_t>& groups, const MotionState& state) const;
  /// The displacement of each vertex of the mesh.
  std::vector<Vec3> at_vertices(const MotionState& state) const;

 private:
  struct Group {
    std::unique_ptr<BoundaryTerms> terms;
    Vector dead;  ///< gravity, tractions, nodal forces
    Vec3 dead_total;
    dynamics::TimeProfile profile;
  };

  void add_group(const BoundaryProblem& part, const dynamics::TimeProfile& profile);
  void append_tools(const std::vector<std::size_t>& groups, const MotionState& state,
                    std::vector<double>& row) const;
  void append_probes(const MotionState& state, std::vector<double>& row) const;

  const TetMesh& mesh_;
  const MotionProblem& problem_;
  ElasticBody& body_;
  Matrix stiffness_;
  Matrix mass_;
  std::vector<Group> groups_;
  std::vector<std::size_t> probe_nodes_;  ///< of this process; else as many as it has nodes
};

}  // namespace palpate::reference::fenicsx

// What acts on the boundary of a body: held displacements, elastic supports, tractions, nodal forces.
#pragma once

#include <vector>

#include "core/mesh/boundary_problem.h"
#include "reference/fenicsx/statics/elastic_body.h"

namespace palpate::reference::fenicsx {

/// The terms of a problem on the nodes of one body. The matrices of faces are exact: the mass and the load
/// vector of linear or quadratic triangles, times the face's weight.
class BoundaryTerms {
 public:
  BoundaryTerms(const TetMesh& mesh, const BoundaryProblem& problem, const ElasticBody& body);

  /// Sets the held entries of `u`, ghosts too, to `factor` times what is prescribed.
  void set_held(double factor, const Vector& u) const;
  /// Sets the held entries to zero.
  void clear_held(const Vector& u) const;
  /// Global rows of the held entries that this process owns.
  const std::vector<PetscInt>& held_rows() const { return held_rows_; }
  /// Is any held displacement other than zero, on any process?
  bool is_anything_moved() const { return is_moved_; }

  /// Adds the stiffness of the supports.
  void add_supports(const Matrix& tangent) const;
  /// Adds the pull of the supports towards `factor` times where they stand.
  void add_support_force(const Vector& u, double factor, const Vector& force) const;
  /// 1/2 k |u - factor by|^2 over the supports, in J, of all processes together.
  double support_energy(const Vector& u, double factor) const;
  /// The sum of that pull, in N, of all processes together.
  Vec3 total_support_force(const Vector& u, double factor) const;
  /// The same of each support by itself, in the problem's order: the integral of k (factor by - u).
  std::vector<Vec3> support_forces(const Vector& u, double factor) const;
  /// The sum of the held entries of `force` by axis, of all processes together.
  Vec3 total_at_held(const Vector& force) const;
  /// Adds tractions, pressures and nodal forces.
  void add_loads(const Vector& force) const;

 private:
  struct Held {
    std::size_t entry;  ///< 3 x local node + axis
    double value_m;
  };
  struct FaceTerm {
    LocalFace face;
    double scale;        ///< support: k x weight x area, in N/m; load: 1
    Vec3 vector;         ///< support: where it stands; load: the force on the face
    std::size_t of = 0;  ///< support: its place in the problem
  };

  void find_held(const TetMesh& mesh, const BoundaryProblem& problem, const ElasticBody& body);
  void find_faces(const TetMesh& mesh, const BoundaryProblem& problem, const ElasticBody& body);

  std::vector<Held> held_;
  std::vector<PetscInt> held_rows_;
  std::size_t owned_nodes_ = 0;
  bool is_moved_ = false;
  std::vector<FaceTerm> supports_;
  std::size_t support_count_ = 0;
  std::vector<FaceTerm> loads_;
  std::vector<std::pair<PetscInt, Vec3>> nodal_forces_;
};

/// The mass matrix of a triangle of unit area with 3 linear or 6 quadratic shape functions (vertices, then
/// midpoints of 0-1, 1-2, 2-0): entry (i, j). Rows and columns beyond 3 are for 6 nodes alone.
double face_mass(int node_count, std::size_t i, std::size_t j);

/// The integral of shape function i over that triangle.
double face_load(int node_count, std::size_t i);

}  // namespace palpate::reference::fenicsx

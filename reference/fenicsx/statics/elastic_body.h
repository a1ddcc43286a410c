// An elastic body as dolfinx sees it: mesh, vector-valued Lagrange space and the forms of elasticity.py.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "reference/fenicsx/statics/petsc_handles.h"

namespace palpate::reference::fenicsx {

/// A boundary face on this process: its nodes, counted locally. Three vertices as in the given triangle, then
/// (degree 2) the midpoints of its edges 0-1, 1-2 and 2-0.
struct LocalFace {
  std::size_t given = 0;  ///< its place in the list of faces that was asked for
  int node_count = 3;
  std::array<PetscInt, 6> nodes{};
};

/// The body: nothing of dolfinx is seen outside. Everything that takes or gives a Vec or Mat is collective.
class ElasticBody {
 public:
  /// `degree` is 1 or 2. Each process passes the same whole mesh and gets its part of it.
  ElasticBody(const TetMesh& mesh, const Material& material, StrainSize strain, int degree);
  ~ElasticBody();
  ElasticBody(const ElasticBody&) = delete;
  ElasticBody& operator=(const ElasticBody&) = delete;

  /// The same body with linear shape functions, on the same parts of the mesh.
  std::unique_ptr<ElasticBody> with_linear_shapes() const;

  /// The vertices (a, b), a <= b, between which each node of this process lies in the middle, owned nodes
  /// first, then ghosts; a = b at a vertex.
  const std::vector<Edge>& nodes() const;
  std::size_t owned_nodes() const;
  std::size_t global_nodes() const;
  /// Global numbers, of dolfinx's making, of the nodes of this process.
  const std::vector<PetscInt>& global_numbers() const;

  /// Those of `faces` whose tet belongs to this process; every boundary face belongs to one.
  std::vector<LocalFace> find_faces(const std::vector<Triangle>& faces) const;

  /// A ghosted vector of zeros, three entries a node.
  Vector create_vector() const;
  /// A matrix of type `type` ("baij", "aij") with the pattern of the tangent.
  Matrix create_matrix(const char* type) const;

  /// Adds the second derivative of the stored energy at `u`, without assembling the matrix at the end.
  void add_tangent(const Vector& u, const Matrix& tangent);
  /// Adds the consistent mass matrix, in kg, without assembling the matrix at the end.
  void add_mass(const Matrix& mass) const;
  /// Adds the derivative of the stored energy at `u` to owned and ghost entries.
  void add_internal_force(const Vector& u, const Vector& force);
  /// Adds a force a unit of volume, in N/m^3.
  void add_body_force(const Vec3& force_n_m3, const Vector& force);
  /// Adds a force a unit of volume that varies: a value at each vertex and each of `edges` (build_edges of
  /// the mesh), quadratic in each tet.
  void add_body_force_field(const std::vector<Vec3>& force_n_m3, const std::vector<Edge>& edges,
                            const Vector& force);
  /// The stored energy at `u` in J, of all processes together; NaN where a tet is turned inside out.
  double stored_energy(const Vector& u);

 private:
  struct Parts;
  explicit ElasticBody(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate::reference::fenicsx

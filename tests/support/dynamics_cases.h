// Bodies, springs and displacements that the tests of core/dynamics share.
#pragma once

#include <cstdint>
#include <vector>

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::testing_support {

/// A spring an edge with k = E x (volume of the tets around) / length^2, so that sum k l^2 = 6 E V.
SpringNetwork make_edge_springs(const TetMesh& mesh, double young_modulus_pa);

/// Random displacements of up to `size` along each axis.
std::vector<Vec3> make_random_field(std::size_t vertices, double size, std::uint64_t seed);

/// gradient x + shift at each point x.
std::vector<Vec3> make_affine_field(const std::vector<Vec3>& points, const dynamics::Mat3& gradient,
                                    const Vec3& shift);

/// The rotation by `angle` about `axis`, which must be a unit vector.
dynamics::Mat3 make_rotation(const Vec3& axis, double angle);

/// The boundary faces of `mesh` whose vertices all have x[axis] within 1e-9 of `at`.
std::vector<Triangle> find_faces_at(const TetMesh& mesh, int axis, double at);

/// Coordinate `axis` of a vector.
double coordinate(const Vec3& v, int axis);

/// sqrt(sum of |a_v|^2).
double field_norm(const std::vector<Vec3>& a);

/// field_norm(a - b).
double field_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b);

}  // namespace palpate::testing_support

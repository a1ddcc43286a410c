// A displacement made of the spheres' functions, those of them that may move, and what integrates it.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/dynamics/linear_algebra/matrix3.h"
#include "core/mesh/tet_mesh.h"
#include "reference/finite_spheres/functions.h"
#include "reference/finite_spheres/quadrature.h"
#include "reference/finite_spheres/spheres.h"

namespace palpate::reference {

/// kGauss: points in each tet. kNodal: one point a vertex, with gradients that are averaged over its dual
/// cell.
enum class SphereIntegration { kGauss, kNodal };

/// By the option `integration`.
inline constexpr EnumNames<SphereIntegration, 2> kSphereIntegrationNames{"integration", {"gauss", "nodal"}};

/// How integrals are taken.
struct IntegrationOptions {
  SphereIntegration kind = SphereIntegration::kGauss;
  int points = 4;     ///< a tet: 1, 4 or 14 (kGauss)
  int subdivide = 0;  ///< how often each tet and face is split for its points (kGauss)

  /// The rule over faces: Gauss points, or those that belong to the dual cells.
  std::vector<FacePoint> face_rule() const {
    return kind == SphereIntegration::kNodal ? build_dual_face_rule() : build_face_rule(subdivide);
  }
};

/// The functions of a body and the numbers of their coefficients.
///
/// Shape:  moving has one entry a sphere: its place among those that move, kNoIndex for one at rest.
/// Coefficient
///         functions_per_sphere x moving[I] + n, a vector in m, belongs to function n of sphere I.
struct SphereField {
  const TetMesh* mesh = nullptr;  ///< outlives the field
  Spheres spheres;
  SphereFunctions functions = SphereFunctions::kLeastSquares;
  std::vector<Index> moving;
  std::size_t moving_spheres = 0;

  /// How many coefficients there are, three numbers each.
  std::size_t coefficients() const { return functions_per_sphere(functions) * moving_spheres; }
};

/// A field in which all spheres move.
SphereField build_sphere_field(const TetMesh& mesh, double factor, SphereFunctions functions);

/// Lets those spheres move whose centres are within `radius_m` of a loaded place (a triangle of the mesh; a
/// point is three times the same vertex); all others rest, without displacement. Throws: InputError if
/// nothing is loaded.
void localise(SphereField& field, std::span<const Triangle> loaded, double radius_m);

/// Evaluates the moving functions at a point of a tet; `numbers` are those of coefficients.
void evaluate_moving(const SphereField& field, std::size_t tet, const Vec3& at, FunctionValues& out);

/// The moving spheres that reach a tet, by their places, increasing.
void collect_moving(const SphereField& field, std::size_t tet, std::vector<Index>& out);

/// sum of coefficient x value, and of coefficient x gradient^T (row i: the gradient of component i).
Vec3 sum_values(const FunctionValues& at, std::span<const Vec3> coefficients);
dynamics::Mat3 sum_gradients(const FunctionValues& at, std::span<const Vec3> coefficients);

/// The displacement at the vertices and, if asked for, at the midpoints of build_edges, in m.
std::vector<Vec3> sample_displacement(const SphereField& field, std::span<const Vec3> coefficients,
                                      bool with_midpoints);

/// A point of a tet, in m.
Vec3 point_in_tet(const TetMesh& mesh, std::size_t tet, const std::array<double, 4>& at);

/// The volume of a tet, in m^3.
double tet_volume(const TetMesh& mesh, std::size_t tet);

}  // namespace palpate::reference

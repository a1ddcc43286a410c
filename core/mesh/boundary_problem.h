// An elastic body, held and loaded: what every deformation contestant is asked to solve, region by region
// resolved to the faces and vertices of one mesh. All in SI units; the mesh's points are in metres.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/base/types.h"

namespace palpate {

/// An isotropic material.
struct Material {
  double young_modulus_pa = 0.0;
  double poisson_ratio = 0.0;
  double density_kg_m3 = 0.0;

  /// Lame's first parameter, E nu / ((1 + nu)(1 - 2 nu)), in Pa.
  double lambda_pa() const {
    return young_modulus_pa * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
  }
  /// Shear modulus, E / (2 (1 + nu)), in Pa.
  double mu_pa() const { return young_modulus_pa / (2.0 * (1.0 + poisson_ratio)); }
};

/// Boundary faces, each with the share of it that belongs to a region: an integral over the region is the sum
/// over the faces of weight x the integral over the face, with linear (P1) or quadratic (P2) shape functions
/// and the consistent face mass, never a lumped one.
///
/// Shape:  one weight in (0, 1] a face; faces counter-clockwise seen from outside.
struct FacePatch {
  std::vector<Triangle> faces;
  std::vector<double> weight;
};

/// A hard clamp, or a prescribed displacement: everything on these faces moves by `by_m`, in the directions
/// that `axes` names. Vertices of two of them must agree.
struct HeldFaces {
  std::vector<Triangle> faces;
  std::array<bool, 3> axes{true, true, true};
  Vec3 by_m;
};

/// An elastic support, or an elastic pad that moves by `by_m`: the energy 1/2 k |u - by_m|^2 a unit of rest
/// area.
struct ElasticSupport {
  FacePatch patch;
  double stiffness_pa_per_m = 0.0;
  Vec3 by_m;
};

/// A dead load: a force a unit of rest area, and a pressure against the outward normal of the rest shape.
struct Traction {
  FacePatch patch;
  Vec3 traction_pa;
  double pressure_pa = 0.0;
};

/// A force on one vertex.
struct NodalForce {
  Index vertex = 0;
  Vec3 force_n;
};

/// How strains are measured: `kSmall` is linear elasticity; `kLarge` is held against the neo-Hookean solid
/// W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2, which has the same small-strain limit.
enum class StrainSize { kSmall, kLarge };

/// A static problem on one mesh.
struct BoundaryProblem {
  Material material;
  StrainSize strain = StrainSize::kSmall;
  Vec3 gravity_m_s2;  ///< body force density_kg_m3 x gravity
  std::vector<HeldFaces> held;
  std::vector<ElasticSupport> supports;
  std::vector<Traction> tractions;
  std::vector<NodalForce> nodal_forces;
  /// A body force that varies, in N/m^3, beside gravity: a value at each vertex and at each edge midpoint of
  /// build_edges, quadratic in each tet. Empty: none. Linear elements may use all of it or the vertices'
  /// alone.
  std::vector<Vec3> body_force_n_m3;
  /// A displacement that varies, added to `by_m` of every held face in its held directions: a value at each
  /// vertex and at each edge midpoint, as above; linear elements use the vertices' alone. Empty: zero.
  std::vector<Vec3> held_field_m;
};

}  // namespace palpate

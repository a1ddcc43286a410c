// The thesis's volume force (4.2.9), its sign corrected: a force without an energy.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::dynamics {

/// A force of the same size on each vertex, towards the organ's center while the organ is larger than at
/// rest:
///
///   f_v = k (V(x) - V0) d_v,   d_v = (c - x_v) / |c - x_v|,   c = mean of the barycenters of all tets
///
/// As printed it points outwards and blows the organ up. It keeps neither momentum nor energy: the d_v don't
/// add up to zero, so a squeezed organ is pushed as a whole.
/// Source: thesis 4.2.6 (volume and center), 4.2.9 (force).
struct VolumeForce {
  double stiffness_n_per_m3 = 0.0;     ///< k, the thesis's m_kv
  double rest_volume_m3 = 0.0;         ///< V0
  std::vector<Tet> tets;               ///< of the mesh
  std::vector<double> center_weights;  ///< share of each vertex in c; they add up to 1
};

/// The force for a mesh. With `stiffness_ratio` = m_kv / k_s as the thesis counts both (positions in a box of
/// half side 1, Table 4.1: 100 / 100 = 1), k = ratio x mean spring stiffness / (half the longest side)^2.
/// Throws: InputError for a negative or infinite ratio.
VolumeForce build_volume_force(const TetMesh& mesh, double mean_spring_stiffness_n_per_m,
                               double stiffness_ratio);

/// Adds the force on each vertex, in N. A vertex at the center has no direction and gets none.
void add_volume_force(const VolumeForce& volume_force, std::span<const Vec3> rest,
                      std::span<const Vec3> displacement, std::span<Vec3> force);

/// The derivative of the force: a sparse part and products of two vectors. With r_v = |c - x_v|,
///
///   df_v = k (V - V0) (I - d_v d_v^T) / r_v (dc - dx_v) + k d_v dV,
///   dV = sum of volume_gradient . dx,   dc = sum of center_weights dx.
///
/// Shape:  direction and volume_gradient hold one entry a vertex; turning the matrix
///         k (V - V0) (I - d d^T) / r of each vertex, as xx, xy, xz, yy, yz, zz.
struct VolumeForceTangent {
  std::vector<Vec3> direction;
  std::vector<Vec3> volume_gradient;
  std::vector<std::array<double, 6>> turning;
};
/// The parts of the derivative at `displacement` (one entry a vertex, in m). Linear time.
VolumeForceTangent differentiate_volume_force(const VolumeForce& volume_force, std::span<const Vec3> rest,
                                              std::span<const Vec3> displacement);

}  // namespace palpate::dynamics

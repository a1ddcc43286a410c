// Strain smoothing: the displacement gradient averaged over tets, faces, edges or nodes, as one sparse
// operator.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/dynamics/linear_algebra/matrix3.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::dynamics {

/// Where gradients are averaged: in each tet (no smoothing: linear elements), or over the tets around each
/// face, edge or vertex.
enum class StrainDomain { kTet, kFace, kEdge, kNode };

/// "tet", "face", "edge" or "node". Throws: InputError.
StrainDomain parse_strain_domain(std::string_view name);
/// The name that parse_strain_domain reads.
const char* strain_domain_name(StrainDomain domain);

/// A linear map from displacements to one displacement gradient a domain:
///
///   H_s = sum over its vertices v of u_v (x) g_sv
///
/// Shape:  volume_m3 has one entry a domain; offsets one more; vertices (increasing within a domain) and
///         gradients (in 1/m) hold the entries offsets[s] .. offsets[s + 1] of domain s. The gradients of a
///         domain add up to zero, and the volumes to that of the mesh.
struct StrainOperator {
  std::vector<double> volume_m3;
  std::vector<Index> offsets;
  std::vector<Index> vertices;
  std::vector<Vec3> gradients;

  std::size_t domains() const { return volume_m3.size(); }
  std::span<const Index> vertices_of(std::size_t domain) const {
    return {vertices.data() + offsets[domain], vertices.data() + offsets[domain + 1]};
  }
  std::span<const Vec3> gradients_of(std::size_t domain) const {
    return {gradients.data() + offsets[domain], gradients.data() + offsets[domain + 1]};
  }
};

/// Gradients of the linear shape functions of each tet, averaged by volume: each tet T gives V_T / 4 to each
/// of its vertices (or faces), V_T / 6 to each of its edges, or V_T to itself, and
///
///   V_s = sum of those shares,   g_sv = sum over T of share_sT grad N_v|T / V_s.
///
/// Domains are numbered as mesh.tets, build_faces, build_edges or mesh.points. A vertex of no tet has an
/// empty domain of volume zero.
///
/// Throws: InputError for a tet without positive volume.
///
/// Source: C. Dohrmann et al., Int. J. Numer. Meth. Engng 47 (2000), for nodes; G. Liu and T. Nguyen-Thoi,
/// Smoothed Finite Element Methods, CRC Press 2010, for faces and edges.
StrainOperator build_strain_operator(const TetMesh& mesh, StrainDomain domain);

/// H of one domain.
Mat3 displacement_gradient(const StrainOperator& op, std::size_t domain, std::span<const Vec3> displacement);

}  // namespace palpate::dynamics

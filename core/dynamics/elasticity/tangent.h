// The stiffness of an elastic model: the second derivative of its energy.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/linear_algebra/block_matrix.h"

namespace palpate::dynamics {

/// kExact is the second derivative; kProjected makes each spring and each domain semidefinite on its own, so
/// that what it solves for is a way down.
enum class TangentKind { kExact, kProjected };

/// The zero matrix with the pattern of the model's tangent and of the triangles `faces` (elastic supports).
BlockMatrix build_tangent_pattern(const ElasticModel& model, std::span<const Triangle> faces);

/// Adds the tangent of elastic_energy in N/m:
///
///   springs: k (n n^T + (1 - L/|d|)(I - n n^T)), n = d / |d|; linearised: k e e^T
///   strain terms: sum over s of V_s (dP/dF)_ijkl g_sa,j g_sb,l
///
/// The volume force, if there is one, is left out: see differentiate_volume_force. `more` of a term and the
/// displacement gradient is added to dP/dF in each domain whose law is not linear, in the same pass.
/// Requires: the pattern of build_tangent_pattern; a finite energy.
void add_tangent(const ElasticModel& model, std::span<const Vec3> displacement, TangentKind kind,
                 BlockMatrix& matrix,
                 const std::function<Tangent9(const StrainTerm& term, const Mat3& h)>& more = {});

/// Adds V_s g_a . C_s . g_b for each domain s and each pair (a, b) of its vertices; `tangent_of(s)` is C_s.
/// Requires: the pattern of build_tangent_pattern of a model that has the term; each C_s symmetric, (ij, kl)
///           as (kl, ij), and what is in the matrix already too: one half is added, and the other is its
///           mirror.
void add_domain_tangents(const StrainOperator& op, const std::function<Tangent9(std::size_t)>& tangent_of,
                         BlockMatrix& matrix);

}  // namespace palpate::dynamics

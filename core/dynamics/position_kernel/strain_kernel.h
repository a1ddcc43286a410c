// Domains of strain of XPBD, eight at a time: one form for every processor and one for those with AVX2, with
// the same bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/dynamics/elasticity/elastic_law.h"
#include "core/dynamics/position_kernel/position_rows.h"
#include "core/dynamics/tet_engine/domain_kernel.h"

namespace palpate::dynamics {

/// Eight domains with at most so many vertices each: where their numbers begin.
struct StrainGroup {
  std::size_t vertices = 0;
  std::size_t values = 0;
  std::size_t at = 0;
};

/// What the domains of a term and a step have in common.
struct StrainStep {
  StrainLaw law = StrainLaw::kCorotated;
  double shear = 0.0;      ///< h^2 mu
  double bulk = 0.0;       ///< h^2 (lambda + mu)
  double rest = 0.0;       ///< mu / (lambda + mu)
  double step_sq = 0.0;    ///< h^2
  double damping = 0.0;    ///< h b
  double root_even = 0.0;  ///< the square root of the moduli: of each normal strain
  double root_sum = 0.0;   ///< of what normal strains share
  double root_shear = 0.0;
};

/// Lanes of a group that the law's step is made of: of kStableNeoHookean A, M and M A, six each; else the 21
/// of (1 + (h^2 + h b) S G S)^-1.
constexpr std::size_t count_weights(StrainLaw law) {
  return law == StrainLaw::kStableNeoHookean ? 18 : 21;
}

/// Lanes of a group that a step leaves for its next sweep: the six multipliers of strains; of
/// kStableNeoHookean those of the damping behind L (9), what C_H has pulled (9) and l, and then the gradient
/// at the start (9) and the factors (21) of the damping's system.
constexpr std::size_t count_kept(StrainLaw law) {
  return law == StrainLaw::kStableNeoHookean ? 55 : 6;
}

/// Where entry (i, j) of a symmetric 6 x 6 matrix is among the 21 of its lower triangle, row after row.
constexpr std::size_t triangle_at(std::size_t i, std::size_t j) {
  return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i;
}

/// Domains of a sweep.
///
/// Shape:  a group's values are eight volumes, eight roots of them, and eight x, y and z of the gradients of
///         each vertex but the first; at has eight places of each vertex, each kRowNumbers x its row. A
///         domain that is not there has zeros and the row of the padding, so has a vertex that is not there.
struct StrainRun {
  StrainStep step;
  std::span<const StrainGroup> groups;
  const double* values = nullptr;
  const std::uint32_t* at = nullptr;
  const double* weights = nullptr;
  double* kept = nullptr;
};

/// Solves domains for their own multipliers, group after group (from the last to the first where the sweep is
/// backward). kStableNeoHookean as core/dynamics/integrators/neo_hookean_constraints.h has it; kLinear and
/// kCorotated as position_step.h there, both with multipliers n of S c, S the square root of the moduli K:
///
///   dn = -(1 + (h^2 + h b) S G S)^-1 (n + S (h^2 c + h b (c - c_before))),   u' += W grad c^T S dn
///
/// which is the same step with a symmetric matrix. Requires: no vertex twice in a group.
void sweep_strains(const StrainRun& run, const SweptRows& rows, const SweepOrder& order);

/// The same with AVX2. Requires: has_avx2() (core/base/processor.h).
void sweep_strains_avx2(const StrainRun& run, const SweptRows& rows, const SweepOrder& order);

/// h of eight domains, and F - R in place of what is there, by nearest_rotation, where `is_off` says so.
struct EightRotations {
  std::array<std::array<double, kGroupDomains>, 9> h;
  std::array<std::array<double, kGroupDomains>, 9> apart;
};
/// Puts right those that are off.
void mend_rotations(const std::array<bool, kGroupDomains>& is_off, EightRotations& domains);

}  // namespace palpate::dynamics

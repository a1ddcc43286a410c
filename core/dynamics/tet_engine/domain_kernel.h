// The innermost loop of the tet engine: what eight domains of strain at a time do to the vertices of a block.
// There is one form for every processor and one for those with AVX2; both give the same bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/dynamics/elasticity/elastic_law.h"

namespace palpate::dynamics {

/// Domains of a group.
inline constexpr std::size_t kGroupDomains = 8;

/// Vertices that a block sees at most: 4 x place has to fit 16 bits.
inline constexpr std::size_t kMostBlockRows = 16384;

/// Numbers of a group of domains with `vertices` vertices each: eight volumes, then eight x, y and z of the
/// gradients of each vertex but the first.
constexpr std::size_t group_values(std::size_t vertices) {
  return kGroupDomains * (3 * vertices - 2);
}

/// Groups with the same number of vertices a domain, one behind the other.
///
/// Shape:  values has group_values(vertices) a group, in m^3 and 1/m; at has eight places of each vertex,
/// each
///         4 x the row of the vertex. A domain that is not there repeats another one with volume zero; a
///         vertex that is not there repeats the domain's first one with gradient zero.
template <typename Real>
struct DomainRun {
  std::size_t vertices = 4;
  std::size_t groups = 0;
  const Real* values = nullptr;
  const std::uint16_t* at = nullptr;
};

/// What domains resist with: stress of `law` with these moduli, and damping_stress with damping_s x moduli.
struct DomainLaw {
  StrainLaw law = StrainLaw::kCorotated;
  Moduli moduli;
  double damping_s = 0.0;
};

/// Displacements and velocities of the vertices that a block sees: rows of four numbers, the last one zero.
template <typename Real>
struct BlockMotion {
  const Real* u = nullptr;
  const Real* v = nullptr;  ///< not read without damping, nor by kLinear
};

/// Adds to `force`, four numbers a row, what the domains of a run do to their vertices:
///
///   H = sum over the vertices k > 0 of (u_k - u_0) (x) g_k,   f_k = -V P g_k,   f_0 = -sum of f_k
///
/// the same with velocities for the rate. kLinear takes its damping with its stress, in which it is linear:
/// `u` then has to be u + damping_s v.
///
/// kCorotated finds R and S - I from the invariants of E = F^T F - I without cancellation: y = tr S - 3 is
/// the largest root of a quartic, by Newton steps from its series in E, three in single precision and four in
/// double; then F - R is a polynomial in F over the quartic's derivative. kNeoHookean takes ln J from the
/// series of 2 artanh(j / (2 + j)), j = J - 1. So R, S - I and ln J are right to a few roundings, relative to
/// the strain as far as H is. Domains where this does not hold (the last Newton step above a bound, two
/// stretches that nearly cancel, J outside 1/2 .. 2, with damping J < 0) are computed by elastic_law.h in
/// double precision, one by one.
///
/// Each operation is rounded by itself. Forces are added group after group, vertex after vertex (the first
/// one last), domain after domain: an order that does not depend on the processor.
///
/// Source: total Lagrangian form: K. Miller, G. Joldes, D. Lance, A. Wittek, Commun. Numer. Meth. Engng 23
/// (2007), doi 10.1002/cnm.887. Quartic and R as its derivative: H. Lin, F. Chitalu, T. Komura, ACM Trans.
/// Graph. 41 (2022), doi 10.1145/3550454.3555507.
template <typename Real>
void add_domain_forces(const DomainLaw& law, const DomainRun<Real>& run, const BlockMotion<Real>& motion,
                       Real* force);

/// The same with AVX2. Requires: has_avx2() (core/base/processor.h).
void add_domain_forces_avx2(const DomainLaw& law, const DomainRun<float>& run,
                            const BlockMotion<float>& motion, float* force);
/// The same with AVX2. Requires: has_avx2().
void add_domain_forces_avx2(const DomainLaw& law, const DomainRun<double>& run,
                            const BlockMotion<double>& motion, double* force);

/// Eight domains as they lie in memory: entry (i, j) of H is h[3 i + j].
template <typename Real>
struct EightDomains {
  std::array<std::array<Real, kGroupDomains>, 9> h;
  std::array<std::array<Real, kGroupDomains>, 9> rate;
  std::array<std::array<Real, kGroupDomains>, 9> stress;  ///< x -volume
  std::array<Real, kGroupDomains> volume;
  std::array<bool, kGroupDomains> is_off;
};

/// Computes the stresses of those that are off by elastic_law.h.
template <typename Real>
void mend_domains(const DomainLaw& law, EightDomains<Real>& domains);

/// Compiled once, in domain_kernel_any.cpp.
extern template void add_domain_forces(const DomainLaw&, const DomainRun<float>&, const BlockMotion<float>&,
                                       float*);
/// Compiled once, in domain_kernel_any.cpp.
extern template void add_domain_forces(const DomainLaw&, const DomainRun<double>&, const BlockMotion<double>&,
                                       double*);
/// Compiled once, in domain_kernel.cpp.
extern template void mend_domains(const DomainLaw&, EightDomains<float>&);
/// Compiled once, in domain_kernel.cpp.
extern template void mend_domains(const DomainLaw&, EightDomains<double>&);

}  // namespace palpate::dynamics

// The innermost loop of the plain engine: what eight springs at a time do to the vertices of a block. There
// is one form for every processor and one for those with AVX2; both give the same bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace palpate::dynamics {

/// Position and velocity of a vertex side by side: 32 bytes in single precision.
template <typename Real>
struct alignas(8 * sizeof(Real)) Particle {
  std::array<Real, 4> x{};  ///< the last one is zero
  std::array<Real, 4> v{};
};

/// Springs of a group.
inline constexpr std::size_t kGroupSprings = 8;

/// Vertices of a block at most: 4 x place has to fit 16 bits.
inline constexpr std::size_t kMostBlockVertices = 16384;

/// Eight springs of one block. `a` holds 4 x the place of the first end within the block; `b` the same of the
/// second end (16 bits), or for springs that leave the block the second end's place in the whole (32 bits).
/// 16 bytes a spring in single precision within a block.
template <typename Real, typename End>
struct SpringGroup {
  std::array<std::uint16_t, kGroupSprings> a{};
  std::array<End, kGroupSprings> b{};
  std::array<Real, kGroupSprings> stiffness{};
  std::array<Real, kGroupSprings> pull{};  ///< stiffness x rest length
  std::array<Real, kGroupSprings> damping{};
};
template <typename Real>
using InsideGroup = SpringGroup<Real, std::uint16_t>;
template <typename Real>
using AcrossGroup = SpringGroup<Real, std::uint32_t>;

/// A block's springs and the vertices that they see.
template <typename Real>
struct BlockSprings {
  std::span<const InsideGroup<Real>> inside;
  std::span<const AcrossGroup<Real>> across;
  const Particle<Real>* all = nullptr;  ///< all vertices
  std::size_t first = 0;                ///< place of the block's first vertex
};

/// Adds to `force`, 4 numbers a vertex of the block, what its springs do to them:
///
///   f_a = (k - k L / r + (c (w . d)) / r^2) d,  f_b = -f_a,  d = x_b - x_a,  w = v_b - v_a,  r = |d|
///
/// spring after spring in the order of the groups, those within the block first. Each operation is rounded by
/// itself, in an order that does not depend on the processor. 1 / r is sqrt(r^2) (1 / r^2): root and quotient
/// then need not wait for each other.
///
/// Returns:  the least r^2, at most 1. Below 1e-36 a spring has no direction; its d is too small to matter.
template <typename Real>
Real add_spring_forces(const BlockSprings<Real>& springs, Real* force);

/// The same with AVX2, in single precision. Requires: has_avx2().
float add_spring_forces_avx2(const BlockSprings<float>& springs, float* force);

/// Fetches the cache line at `where`, which may lie past the end of an array, before it is needed.
inline void fetch_ahead([[maybe_unused]] const void* where) {
#ifdef __GNUC__
  __builtin_prefetch(where);
#endif
}

/// How many groups ahead the springs are fetched: some 0.3 microseconds.
inline constexpr std::size_t kGroupsAhead = 24;

/// Whether this processor, and this build, can do the above.
bool has_avx2();

extern template float add_spring_forces(const BlockSprings<float>&, float*);
extern template double add_spring_forces(const BlockSprings<double>&, double*);

}  // namespace palpate::dynamics

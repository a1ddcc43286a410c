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

/// What springs of a group are made of.
template <typename Real>
struct GroupConstants {
  std::array<Real, kGroupSprings> stiffness{};
  std::array<Real, kGroupSprings> pull{};  ///< stiffness x rest length
  std::array<Real, kGroupSprings> damping{};
};

/// Two fans of four springs within a block: springs 0 to 3 meet at hub[0], 4 to 7 at hub[1]. `b` and `hub`
/// hold 4 x the place of a vertex within the block. 16 bytes a spring in single precision.
template <typename Real>
struct alignas(32) InsideGroup : GroupConstants<Real> {
  std::array<std::uint16_t, kGroupSprings> b{};
  std::array<std::uint16_t, 2> hub{};
};

/// Eight springs that leave the block. `a` holds 4 x the place within the block of the end there, `b` the
/// place of the other end in the whole.
template <typename Real>
struct AcrossGroup : GroupConstants<Real> {
  std::array<std::uint16_t, kGroupSprings> a{};
  std::array<std::uint32_t, kGroupSprings> b{};
};

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
/// group after group, those within the block first, and in each group spring after spring; the four forces of
/// a fan are added up as (f_0 + f_1) + (f_2 + f_3) and then to its hub. Each operation is rounded by itself,
/// in an order that does not depend on the processor. 1 / r is sqrt(r^2) (1 / r^2): root and quotient then
/// need not wait for each other.
///
/// Returns:  the least r^2, at most 1. Below 1e-36 a spring has no direction; its d is too small to matter.
template <typename Real>
Real add_spring_forces(const BlockSprings<Real>& springs, Real* force);

/// The same with AVX2, in single precision. Requires: has_avx2() (core/base/processor.h).
float add_spring_forces_avx2(const BlockSprings<float>& springs, float* force);

/// Fetches the cache line at `where`, which may lie past the end of an array, before it is needed.
inline void fetch_ahead([[maybe_unused]] const void* where) {
#ifdef __GNUC__
  __builtin_prefetch(where);
#endif
}

/// How many groups ahead the springs are fetched: some 0.3 microseconds.
inline constexpr std::size_t kGroupsAhead = 24;

/// Compiled once, in plain_kernel.cpp.
extern template float add_spring_forces(const BlockSprings<float>&, float*);
/// Compiled once, in plain_kernel.cpp.
extern template double add_spring_forces(const BlockSprings<double>&, double*);

}  // namespace palpate::dynamics

// What a quasi-Newton method remembers: how forces changed along the last corrections.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace palpate::dynamics {

/// The last five pairs of a correction s and of the change y of what was out of balance (less after s by y),
/// and the matrix that they make of an approximate inverse: limited-memory BFGS by two loops.
///
/// Source: J. Nocedal, Math. Comp. 35 (1980), 773-782; around a factored matrix in time steps: T. Liu,
/// S. Bouaziz and L. Kavan, ACM Trans. Graph. 36 (2017), with five pairs as here.
class CurvaturePairs {
 public:
  static constexpr std::size_t kMost = 5;

  explicit CurvaturePairs(std::size_t vertices);

  void clear() { count_ = 0; }
  bool is_empty() const { return count_ == 0; }

  /// Keeps a pair in the place of the oldest; one without curvature (s . y not above zero by more than
  /// rounding) is left out. Shape: one entry a vertex; s in m, y in N.
  void keep(std::span<const Vec3> s, std::span<const Vec3> y);

  /// Takes `field` (N) to the correction (m) that the pairs make of it, with `approximate` in the middle:
  /// it takes a field of forces to displacements by a fixed symmetric positive definite matrix, in place.
  void apply(std::span<Vec3> field, const std::function<void(std::span<Vec3>)>& approximate) const;

 private:
  struct Pair {
    std::vector<Vec3> s;
    std::vector<Vec3> y;
    double inverse_curvature = 0.0;  ///< 1 / (s . y)
  };

  /// The pair that was kept `age` pairs ago.
  const Pair& aged(std::size_t age) const { return pairs_.at((next_ + 2 * kMost - 1 - age) % kMost); }

  std::array<Pair, kMost> pairs_;
  std::size_t next_ = 0;
  std::size_t count_ = 0;
};

}  // namespace palpate::dynamics

// The tets between one apex and the triangles around it: the kernel of palpate.refined, which asks again and
// again how good they would be with the apex elsewhere.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/base/types.h"
#include "core/simplify/lane_pair.h"

namespace palpate::simplify {

/// What tets are scored by.
///
///   score = min(q^3, dihedral_weight * sin^2(least of the six sines of dihedral angles)),
///   q^3 = (least solid angle / 0.55 sr) (shortest / longest edge) min(1, V / ideal)
///
/// without cube root or trigonometry: the least solid angle is 2 atan(x), x = 6 V / (largest denominator of
/// Van Oosterom and Strackee's formula), and as it is at most 0.5513 sr, x <= 0.283 and four terms of the
/// series are good to 1e-6.
struct ScoreScale {
  double inverse_six_ideal = 0.0;  ///< 1 / (6 * ideal volume)
  double dihedral_weight = 0.0;    ///< 0: dihedral angles play no part
};

/// A tet of at least this score is certainly positive: its rounded volume is far above the rounding error.
/// Below it, orientation() decides.
inline constexpr double kSafeScore = 1e-10;

/// Figures of a set of tets.
struct ConeFigures {
  double worst = 0.0;  ///< least score; not above 0 if a tet may not be positive
  double sum = 0.0;    ///< sum of the gains (see gain_of_score)
};

/// What a score is worth in a sum over tets: about q, with a penalty for what is bad.
double gain_of_score(double score);

/// A set of base triangles (a, b, c), such that the tet (apex, a, b, c) is to be positive.
class Cone {
 public:
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  void add(const Vec3& a, const Vec3& b, const Vec3& c);

  /// Figures with the apex at p. Ends early, with what it has, once the worst is below `bound`.
  ConeFigures evaluate(const ScoreScale& scale, const Vec3& p, double bound) const;

  /// Scores of each tet with the apex at p, in the order of add(). `scores` is resized.
  void scores(const ScoreScale& scale, const Vec3& p, std::vector<double>& scores) const;

  /// The same for an apex on the other side: scores of the tets (p, a, c, b).
  void scores_from_behind(const ScoreScale& scale, const Vec3& p, std::vector<double>& scores) const;

  /// Volume-weighted mean of the tets' barycenters with the apex at p.
  Vec3 volume_centroid(const Vec3& p) const;

  bool is_positive_exactly(const Vec3& p) const;

 private:
  void reserve_next();
  template <bool kFromBehind>
  LanePair score_pair(const ScoreScale& scale, const Vec3& p, std::size_t i) const;

  std::size_t size_ = 0;
  // Rows of coordinates: ax ay az bx by bz cx cy cz, lengths bc ca ab.
  static constexpr std::size_t kRows = 12;
  std::array<std::vector<double>, kRows> rows_;
};

}  // namespace palpate::simplify

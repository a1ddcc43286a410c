// The tets between one apex and the triangles around it: the kernel of palpate.refined, which asks again and
// again how good they would be with the apex elsewhere.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/simplify/star_kernel/star_kernel.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// What tets are scored by, beside their angles.
enum class ScoreForm : std::uint8_t {
  kSolidAngle,  ///< q^3, the thesis's quality
  kMeanRatio    ///< the mean ratio
};

/// What tets are scored by.
///
///   score = min(shape, dihedral_weight * sin^2(the dihedral angle farthest from 90 degrees)),
///   shape = q^3 = (least solid angle / 0.55 sr) (shortest / longest edge) min(1, V / ideal), or
///   shape = kMeanRatioWeight eta^3 min(1, small_volume V / ideal), eta^3 = 15552 V^2 / (sum of l^2)^3
///
/// without cube root or trigonometry: the least solid angle is 2 atan(x), x = 6 V / (largest denominator of
/// Van Oosterom and Strackee's formula), and as it is at most 0.5513 sr, x <= 0.283 and four terms of the
/// series are good to 5e-6; eta is the mean ratio (Liu and Joe 1994), 1 for a regular tet. Scores are
/// computed in single precision, from coordinates relative to a point near by, in units of about the ideal
/// edge: they tell good from bad, never positive from inverted; that is orientation()'s.
struct ScoreScale {
  double unit = 1.0;          ///< lengths are multiplied by this first; a power of two
  double ideal_volume = 1.0;  ///< in the mesh's own unit
  double dihedral_weight = 0.5;
  double gain_offset = 0.1;  ///< c of gain_of_score: the smaller, the more the worst tets count
  ScoreForm form = ScoreForm::kSolidAngle;
  double usual_score = 0.33;  ///< of a tet of a good mesh (q about 0.7): what a tet more or less is worth
  double small_volume = 1.0;  ///< the ideal volume over the greatest one that counts as small
  double flip_share = 1.0;    ///< thresholds of flips and of repairs, over those for scores by solid angles
  double repair_share = 1.0;
};

/// The scale for tets of a given ideal volume, in one of the forms, with all that is usual for it.
ScoreScale scale_of_ideal_volume(double ideal_volume, ScoreForm form = ScoreForm::kSolidAngle);

/// How much of the mean ratio's cube is a score.
inline constexpr double kMeanRatioWeight = 0.2;

/// What a score is worth in a sum over tets: -1 / (c + score), steep where the score is low. Sums of it trade
/// the mean against the worst.
inline double gain_of_score(const ScoreScale& scale, double score) {
  return -1.0 / ((score > 0.0 ? score : 0.0) + scale.gain_offset);
}

/// What a tet more is worth: one of the usual score nothing, so that counts are not free.
inline double worth_of_tet(const ScoreScale& scale, double score) {
  return gain_of_score(scale, score) - gain_of_score(scale, scale.usual_score);
}

/// How good a star would be: a set of base triangles (a, b, c), such that the tets (apex, a, b, c) are to be
/// positive.
///
/// Use: start(), add() each triangle, close(), then ask for as many places of the apex as wanted. The points
/// given to add() must outlive the questions. One object serves for many stars without allocating.
class StarQuality {
 public:
  /// By the better form of the arithmetic, or by the one given; both give the same bits.
  explicit StarQuality(const StarKernel& kernel = star_kernel()) : kernel_(&kernel) {}

  /// Begins anew; `origin` should be near, such as the apex.
  void start(const ScoreScale& scale, const Vec3& origin) {
    size_ = 0;
    origin_ = origin;
    scale_ = scale;
  }

  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    if (size_ == base_.size()) grow();
    base_[size_++] = {&a, &b, &c};
  }

  /// To be called after the last add(): takes the points' coordinates and measures the base edges.
  void close();

  std::size_t size() const { return size_; }

  const ScoreScale& scale() const { return scale_; }

  /// Figures with the apex at p. Ends early, with what it has, once the worst is below `bound`. What did not
  /// end early leaves the scores of each tet in last_scores().
  StarFigures evaluate(const Vec3& p, double bound = -1e300);

  /// Scores of each tet, in the order of add(), at the place of the last evaluate().
  std::span<const float> last_scores() const { return {scores_.data(), size_}; }

  /// In place of add() and close(): all triangles (i, k, j), i < k < j, of a ring of 3 to kLargestRing
  /// points, ordered by i, k and j. Only what follows here may be asked of them, with the apex at `a` and,
  /// for the tets (b, i, j, k), at `b`.
  void take_ring(const RingPoints& ring, std::size_t count);

  /// Bit t is set if both tets of triangle t have a positive volume, as far as single precision tells; where
  /// it is not, one of their scores is not above 0.
  std::uint64_t find_positive(const Vec3& a, const Vec3& b) const;

  /// Scores of both tets of each triangle. The vectors are resized.
  void score_both(const Vec3& a, const Vec3& b, std::vector<float>& at_a, std::vector<float>& at_b);

  /// Scores of each tet with the apex at p, in the order of add(). `scores` is resized.
  void scores(const Vec3& p, std::vector<float>& scores) const;

  /// The same for an apex on the other side: scores of the tets (p, a, c, b).
  void scores_from_behind(const Vec3& p, std::vector<float>& scores) const;

  /// Volume-weighted mean of the tets' barycenters with the apex at p.
  Vec3 volume_centroid(const Vec3& p) const;

  /// Whether all tets are positive with the apex at p, exactly. To be asked after close().
  bool is_positive(const Vec3& p) const;

 private:
  void grow();
  void take_scale();
  StarApex apex_at(const Vec3& p) const;
  /// Room for `size_` scores and the lanes behind them.
  std::size_t padded_size() const {
    return (size_ + kBlockTriangles - 1) / kBlockTriangles * kBlockTriangles;
  }

  const StarKernel* kernel_;
  std::size_t size_ = 0;
  Vec3 origin_;
  ScoreScale scale_;
  float inverse_six_ideal_ = 0.0F;
  std::vector<float> blocks_;
  std::vector<StarTriangle> base_;
  std::vector<float> scores_;
};

/// Adds the base triangles of the tets around v, without those that have `without` (kNoIndex: all).
void add_star(const WorkingMesh& mesh, Index v, Index without, StarQuality& star);

/// The score of one tet (a, b, c, d).
float score_tet(const ScoreScale& scale, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace palpate::simplify

#include "core/simplify/tet_operations/quality_floor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/mesh/geometry.h"
#include "core/simplify/fusion/fusion.h"
#include "core/simplify/quality/quality.h"
#include "core/simplify/tet_operations/star_quality.h"

namespace palpate::simplify {
namespace {

/// Scores are in single precision: a tet whose score is above a bound by less than this share may be below.
constexpr double kSlack = 1e-3;

/// How far the quality of a batch may be from that in full precision: far more than the grid it is rounded
/// to.
constexpr double kBatchSlack = 1e-9;

struct Corners {
  Vec3 a, b, c, d;
};

/// Those of tet t, with v at `place` if it has it.
Corners corners_with(const WorkingMesh& mesh, Index t, Index v, const Vec3& place) {
  const auto at = [&](Index w) { return w == v ? place : mesh.points[w]; };
  const Tet& tet = mesh.tets[t];
  return {at(tet[0]), at(tet[1]), at(tet[2]), at(tet[3])};
}

}  // namespace

double cosine_of_least_dihedral(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  // Outward normals of the faces opposite to a, b, c and d.
  std::array<Vec3, 4> normals{cross(d - b, c - b), cross(c - a, d - a), cross(d - a, b - a),
                              cross(b - a, c - a)};
  if (dot(normals[3], d - a) > 0.0) normals[3] = -1.0 * normals[3];
  if (dot(normals[2], c - a) > 0.0) normals[2] = -1.0 * normals[2];
  if (dot(normals[1], b - a) > 0.0) normals[1] = -1.0 * normals[1];
  if (dot(normals[0], a - b) > 0.0) normals[0] = -1.0 * normals[0];
  double most = -1.0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double size = std::sqrt(length_sq(normals[i]) * length_sq(normals[j]));
      most = std::max(most, size > 0.0 ? -dot(normals[i], normals[j]) / size : 1.0);
    }
  }
  return most;
}

double QualityFloor::cube_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) const {
  const TetFigures figures = measure_positive_tet(kThesisMetric, a, b, c, d);
  return quality_key(kThesisMetric, figures.shape, figures.volume, ideal_volume_) / ideal_volume_;
}

/// The floor's cube of quality, or that of the lowest tet of a batch, which is emptied, if that is lower.
/// Only what may be the lowest by its quality in the batch is measured in full precision.
double QualityFloor::least_cube_with(TetBatch& batch) const {
  measure_batch(kThesisMetric, ideal_volume_, batch);
  double least = least_cube_;
  for (std::size_t i = 0; i < batch.size; ++i) {
    const double above = batch.quality[i] - kBatchSlack;
    if (above > 0.0 && above * above * above > least) continue;
    least =
        std::min(least, cube_of(batch.point(0, i), batch.point(1, i), batch.point(2, i), batch.point(3, i)));
  }
  batch.size = 0;
  return least;
}

/// Whether a tet of that score may be at the floor's angle or below it: a score is at most so many times the
/// squared sine of the least angle. WorkingMesh::kNoScore may.
bool QualityFloor::may_have_least_angle(float score) const {
  const double least_sine_sq = (1.0 - kSlack) * double{score} / ScoreScale{}.dihedral_weight;
  return !(score > 0.0F) || !(greatest_cosine_ > 0.0) ||
         least_sine_sq <= 1.0 - greatest_cosine_ * greatest_cosine_;
}

void QualityFloor::take(const WorkingMesh& mesh) {
  least_cube_ = std::numeric_limits<double>::infinity();
  greatest_cosine_ = -1.0;
  TetBatch batch;
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    if (!mesh.is_alive(t)) continue;
    const auto [a, b, c, d] = corners_with(mesh, t, kNoIndex, {});
    if (may_have_least_angle(mesh.score[t]))
      greatest_cosine_ = std::max(greatest_cosine_, cosine_of_least_dihedral(a, b, c, d));
    batch.add(a, b, c, d);
    if (batch.size == TetBatch::kCapacity) least_cube_ = least_cube_with(batch);
  }
  least_cube_ = least_cube_with(batch);
}

bool QualityFloor::admits(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) const {
  return cube_of(a, b, c, d) >= least_cube_ && cosine_of_least_dihedral(a, b, c, d) <= greatest_cosine_;
}

bool QualityFloor::admits_star(const WorkingMesh& mesh, Index v, const Vec3& place,
                               std::span<const float> scores, Index without) const {
  const auto star = mesh.star(v);
  TetBatch batch;
  for (std::size_t i = 0; i < star.size(); ++i) {
    if (corners_that_are(mesh.tets[star[i]], without) != 0U) continue;
    const auto [a, b, c, d] = corners_with(mesh, star[i], v, place);
    const float score = scores.empty() ? WorkingMesh::kNoScore : scores[i];
    if (may_have_least_angle(score) && cosine_of_least_dihedral(a, b, c, d) > greatest_cosine_) return false;
    batch.add(a, b, c, d);
    if (batch.size == TetBatch::kCapacity && least_cube_with(batch) < least_cube_) return false;
  }
  return !(least_cube_with(batch) < least_cube_);
}

}  // namespace palpate::simplify

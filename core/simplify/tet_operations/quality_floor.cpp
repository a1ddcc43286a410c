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

void QualityFloor::take(const WorkingMesh& mesh, const std::function<double(Index)>& score_of) {
  least_cube_ = std::numeric_limits<double>::infinity();
  greatest_cosine_ = -1.0;
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    if (!mesh.is_alive(t)) continue;
    // score <= q^3 and score <= half the squared sine of the least angle.
    const double least_score = (1.0 - kSlack) * score_of(t);
    const double sine_sq = greatest_cosine_ > 0.0 ? 1.0 - greatest_cosine_ * greatest_cosine_ : 1.0;
    if (least_score > least_cube_ && least_score > ScoreScale{}.dihedral_weight * sine_sq) continue;
    const Tet& v = mesh.tets[t];
    const Vec3& a = mesh.points[v[0]];
    const Vec3& b = mesh.points[v[1]];
    const Vec3& c = mesh.points[v[2]];
    const Vec3& d = mesh.points[v[3]];
    least_cube_ = std::min(least_cube_, cube_of(a, b, c, d));
    greatest_cosine_ = std::max(greatest_cosine_, cosine_of_least_dihedral(a, b, c, d));
  }
}

bool QualityFloor::admits(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) const {
  return cube_of(a, b, c, d) >= least_cube_ && cosine_of_least_dihedral(a, b, c, d) <= greatest_cosine_;
}

bool QualityFloor::admits_star(const WorkingMesh& mesh, Index v, const Vec3& place, Index without) const {
  const auto star = mesh.star(v);
  return std::all_of(star.begin(), star.end(), [&](Index t) {
    const Tet& tet = mesh.tets[t];
    if (corners_that_are(tet, without) != 0U) return true;
    std::array<Vec3, 4> p;
    for (std::size_t i = 0; i < 4; ++i) p[i] = tet[i] == v ? place : mesh.points[tet[i]];
    return admits(p[0], p[1], p[2], p[3]);
  });
}

}  // namespace palpate::simplify

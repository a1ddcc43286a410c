#include "core/simplify/tet_operations/star_quality.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/mesh/orientation.h"
#include "core/simplify/fusion/fusion.h"

namespace palpate::simplify {

ScoreScale scale_of_ideal_volume(double ideal_volume, ScoreForm form) {
  constexpr double kEdgeCubedPerVolume = 8.485281374238571;  // 6 sqrt(2), of a regular tet
  ScoreScale scale;
  scale.form = form;
  if (form == ScoreForm::kMeanRatio) {
    scale.usual_score = 0.18;
    scale.gain_offset = 0.4;
    scale.small_volume = 2.5;
    scale.flip_share = 0.6;  // these scores are lower
    scale.repair_share = 0.7;
  }
  scale.ideal_volume = ideal_volume;
  const double edge = std::cbrt(kEdgeCubedPerVolume * ideal_volume);
  int exponent = 0;
  if (edge > 0.0 && std::isfinite(edge)) std::frexp(edge, &exponent);
  scale.unit = std::ldexp(1.0, -exponent);
  return scale;
}

void StarQuality::grow() {
  constexpr std::size_t kMoreBlocks = 8;
  const std::size_t blocks = base_.size() / kBlockTriangles + kMoreBlocks;
  base_.resize(blocks * kBlockTriangles);
  blocks_.resize(blocks * kBlockFloats);
  scores_.resize(blocks * kBlockTriangles);
}

void StarQuality::close() {
  if (size_ == 0) return;
  std::fill(base_.begin() + static_cast<std::ptrdiff_t>(size_),
            base_.begin() + static_cast<std::ptrdiff_t>(padded_size()), base_[size_ - 1]);
  take_scale();
  kernel_->pack(base_.data(), size_, origin_, scale_.unit, blocks_.data());
}

void StarQuality::take_scale() {
  const double ideal = scale_.ideal_volume * scale_.unit * scale_.unit * scale_.unit;
  const double small = ideal / scale_.small_volume;
  inverse_six_ideal_ = static_cast<float>(1.0 / (6.0 * small));
}

StarApex StarQuality::apex_at(const Vec3& p) const {
  const auto lane = [&](double x) { return static_cast<float>(x * scale_.unit); };
  return {lane(p.x - origin_.x),
          lane(p.y - origin_.y),
          lane(p.z - origin_.z),
          inverse_six_ideal_,
          static_cast<float>(scale_.dihedral_weight),
          scale_.form == ScoreForm::kMeanRatio ? static_cast<float>(kMeanRatioWeight) : 0.0F};
}

StarFigures StarQuality::evaluate(const Vec3& p, double bound) {
  return kernel_->evaluate(blocks_.data(), size_, apex_at(p), static_cast<float>(scale_.gain_offset),
                           static_cast<float>(std::max(bound, double{2.0F * kWorstScore})), scores_.data());
}

void StarQuality::take_ring(const RingPoints& ring, std::size_t count) {
  take_scale();
  size_ = ring_triangles(count).size;
  while (base_.size() < size_) grow();
  RingPoints filled = ring;
  std::fill(filled.begin() + static_cast<std::ptrdiff_t>(count), filled.end(), ring[count - 1]);
  kernel_->pack_ring(filled, count, origin_, scale_.unit, blocks_.data());
}

std::uint64_t StarQuality::find_positive(const Vec3& a, const Vec3& b) const {
  return kernel_->find_positive(blocks_.data(), size_, apex_at(a), apex_at(b));
}

void StarQuality::score_both(const Vec3& a, const Vec3& b, std::vector<float>& at_a,
                             std::vector<float>& at_b) {
  constexpr std::size_t kHalf = kBlockTriangles / 2;
  if (size_ > kHalf) {
    scores(a, at_a);
    scores_from_behind(b, at_b);
    return;
  }
  kernel_->score_both(blocks_.data(), apex_at(a), apex_at(b), scores_.data());
  at_a.assign(scores_.data(), scores_.data() + size_);
  at_b.assign(scores_.data() + kHalf, scores_.data() + kHalf + size_);
}

void StarQuality::scores(const Vec3& p, std::vector<float>& scores) const {
  scores.resize(padded_size());
  kernel_->score(blocks_.data(), size_, apex_at(p), scores.data());
  scores.resize(size_);
}

void StarQuality::scores_from_behind(const Vec3& p, std::vector<float>& scores) const {
  scores.resize(padded_size());
  kernel_->score_from_behind(blocks_.data(), size_, apex_at(p), scores.data());
  scores.resize(size_);
}

Vec3 StarQuality::volume_centroid(const Vec3& p) const {
  Vec3 sum{};
  double volume = 0.0;
  for (std::size_t i = 0; i < size_; ++i) {
    const Vec3 a = *base_[i][0] - p;
    const Vec3 b = *base_[i][1] - p;
    const Vec3 c = *base_[i][2] - p;
    const double six = dot(cross(a, b), c);
    volume += six;
    sum = sum + six * (a + b + c);
  }
  return volume > 0.0 ? p + (0.25 / volume) * sum : p;
}

bool StarQuality::is_positive(const Vec3& p) const {
  if (kernel_->are_surely_positive(blocks_.data(), size_, apex_at(p))) return true;
  for (std::size_t i = 0; i < size_; ++i) {
    if (orientation(p, *base_[i][0], *base_[i][1], *base_[i][2]) <= 0) return false;
  }
  return true;
}

void add_star(const WorkingMesh& mesh, Index v, Index without, StarQuality& star) {
  for (const Index t : mesh.star(v)) {
    const Tet& tet = mesh.tets[t];
    if (without != kNoIndex && corners_that_are(tet, without) != 0U) continue;
    const auto& face = kTetFaces[static_cast<std::size_t>(std::countr_zero(corners_that_are(tet, v)))];
    star.add(mesh.points[tet[static_cast<std::size_t>(face[0])]],
             mesh.points[tet[static_cast<std::size_t>(face[1])]],
             mesh.points[tet[static_cast<std::size_t>(face[2])]]);
  }
}

float score_tet(const ScoreScale& scale, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  static thread_local StarQuality star;
  star.start(scale, a);
  star.add(b, c, d);
  star.close();
  return static_cast<float>(star.evaluate(a).worst);
}

}  // namespace palpate::simplify

#include "core/simplify/tet_operations/star_quality.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/base/lanes.h"
#include "core/mesh/orientation.h"
#include "core/simplify/fusion/fusion.h"

namespace palpate::simplify {
namespace {

using LaneQuad = Lanes<float>;

constexpr float kIdealSolidAngleSr = 0.55F;

/// Score of a tet whose figures do not fit single precision: nothing is worse.
constexpr float kWorstScore = -1e30F;

struct LaneVec {
  LaneQuad x;
  LaneQuad y;
  LaneQuad z;
};

LaneVec operator+(const LaneVec& a, const LaneVec& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

LaneVec operator-(const LaneVec& a, const LaneVec& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

LaneQuad dot(const LaneVec& a, const LaneVec& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

LaneVec cross(const LaneVec& a, const LaneVec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

LaneVec load_point(const float* rows) {
  return {LaneQuad::load(rows), LaneQuad::load(rows + 4), LaneQuad::load(rows + 8)};
}

/// An apex and what its scores depend on, in all lanes.
struct LaneApex {
  LaneVec at;
  LaneQuad inverse_six_ideal;
  LaneQuad dihedral_weight;
};

LaneApex build_apex(const ScoreScale& scale, const Vec3& origin, const Vec3& p) {
  const auto lane = [&](double x) { return LaneQuad::of(static_cast<float>(x * scale.unit)); };
  const double ideal = scale.ideal_volume * scale.unit * scale.unit * scale.unit;
  return {{lane(p.x - origin.x), lane(p.y - origin.y), lane(p.z - origin.z)},
          LaneQuad::of(static_cast<float>(1.0 / (6.0 * ideal))),
          LaneQuad::of(static_cast<float>(scale.dihedral_weight))};
}

/// Scores of the four tets of a block; see ScoreScale. u, v, w lead from the apex to the base's vertices.
template <bool kFromBehind>
[[gnu::always_inline]] inline LaneQuad score_block(const LaneApex& apex, const float* block) {
  const LaneVec u = load_point(block) - apex.at;
  const LaneVec v = load_point(block + 12) - apex.at;
  const LaneVec w = load_point(block + 24) - apex.at;
  const LaneQuad vw = LaneQuad::load(block + 36);
  const LaneQuad wu = LaneQuad::load(block + 40);
  const LaneQuad uv = LaneQuad::load(block + 44);
  const LaneVec normal_u = cross(v, w);
  const LaneVec normal_v = cross(w, u);
  const LaneVec normal_w = cross(u, v);
  const LaneQuad six_volume = kFromBehind ? LaneQuad::of(0.0F) - dot(u, normal_u) : dot(u, normal_u);
  const LaneQuad uu = dot(u, u);
  const LaneQuad vv = dot(v, v);
  const LaneQuad ww = dot(w, w);
  const LaneQuad lu = sqrt(uu);
  const LaneQuad lv = sqrt(vv);
  const LaneQuad lw = sqrt(ww);
  // Scalar products at the apex, from which those at the other corners follow.
  const LaneQuad u_v = dot(u, v);
  const LaneQuad v_w = dot(v, w);
  const LaneQuad w_u = dot(w, u);
  const auto denominator = [](LaneQuad a, LaneQuad b, LaneQuad c, LaneQuad ab, LaneQuad bc, LaneQuad ca) {
    return a * b * c + ab * c + bc * a + ca * b;
  };
  const LaneQuad at_p = denominator(lu, lv, lw, u_v, v_w, w_u);
  const LaneQuad at_a = denominator(lu, uv, wu, uu - u_v, uu - u_v + v_w - w_u, uu - w_u);
  const LaneQuad at_b = denominator(lv, vw, uv, vv - v_w, vv - v_w + w_u - u_v, vv - u_v);
  const LaneQuad at_c = denominator(lw, wu, vw, ww - w_u, ww - w_u + u_v - v_w, ww - v_w);
  const LaneQuad x = six_volume / max(max(at_p, at_a), max(at_b, at_c));
  const LaneQuad xx = x * x;
  const LaneQuad series =
      LaneQuad::of(1.0F) -
      xx * (LaneQuad::of(1.0F / 3.0F) - xx * (LaneQuad::of(0.2F) - xx * LaneQuad::of(1.0F / 7.0F)));
  const LaneQuad shortest = min(min(min(lu, lv), min(lw, vw)), min(wu, uv));
  const LaneQuad longest = max(max(max(lu, lv), max(lw, vw)), max(wu, uv));
  const LaneQuad volume_factor = min(LaneQuad::of(1.0F), six_volume * apex.inverse_six_ideal);
  // The magnitude of x: a product of two negative factors must not look positive.
  const LaneQuad cube =
      sqrt(xx) * series * LaneQuad::of(2.0F / kIdealSolidAngleSr) * (shortest / longest) * volume_factor;
  // sin^2 at the edge e of faces i and j: (6 V / |n_i|^2) (6 V / |n_j|^2) e^2
  const LaneVec normal_p = normal_u + normal_v + normal_w;
  const LaneQuad at_u = six_volume / dot(normal_u, normal_u);
  const LaneQuad at_v = six_volume / dot(normal_v, normal_v);
  const LaneQuad at_w = six_volume / dot(normal_w, normal_w);
  const LaneQuad at_base = six_volume / dot(normal_p, normal_p);
  const LaneQuad sine_sq =
      min(min(min(ww * at_u * at_v, vv * at_u * at_w), min(uu * at_v * at_w, vw * vw * at_u * at_base)),
          min(wu * wu * at_v * at_base, uv * uv * at_w * at_base));
  return max(min(cube, sine_sq * apex.dihedral_weight), LaneQuad::of(kWorstScore));
}

}  // namespace

ScoreScale scale_of_ideal_volume(double ideal_volume) {
  constexpr double kEdgeCubedPerVolume = 8.485281374238571;  // 6 sqrt(2), of a regular tet
  ScoreScale scale;
  scale.ideal_volume = ideal_volume;
  const double edge = std::cbrt(kEdgeCubedPerVolume * ideal_volume);
  int exponent = 0;
  if (edge > 0.0 && std::isfinite(edge)) std::frexp(edge, &exponent);
  scale.unit = std::ldexp(1.0, -exponent);
  return scale;
}

void StarQuality::grow() {
  const std::size_t blocks = lanes_.size() / kBlock + 16;
  lanes_.resize(blocks * kBlock);
  base_.resize(4 * blocks);
}

void StarQuality::close() {
  if (size_ == 0) return;
  for (std::size_t i = size_; i % 4 != 0; ++i) {  // the lanes behind the last triangle repeat it
    float* const block = lanes_.data() + kBlock * (i / 4);
    for (std::size_t r = 0; r < 9; ++r) block[4 * r + i % 4] = block[4 * r + i % 4 - 1];
  }
  for (float* block = lanes_.data(); block < lanes_.data() + kBlock * ((size_ + 3) / 4); block += kBlock) {
    const LaneVec a = load_point(block);
    const LaneVec b = load_point(block + 12);
    const LaneVec c = load_point(block + 24);
    sqrt(dot(c - b, c - b)).store(block + 36);
    sqrt(dot(a - c, a - c)).store(block + 40);
    sqrt(dot(b - a, b - a)).store(block + 44);
  }
}

StarFigures StarQuality::evaluate(const Vec3& p, double bound) const {
  const LaneApex apex = build_apex(scale_, origin_, p);
  const LaneQuad limit = LaneQuad::of(static_cast<float>(std::max(bound, double{2.0F * kWorstScore})));
  const LaneQuad offset = LaneQuad::of(static_cast<float>(scale_.gain_offset));
  LaneQuad worst = LaneQuad::of(std::numeric_limits<float>::max());
  LaneQuad sum = LaneQuad::of(0.0F);
  std::array<float, 4> out{};
  StarFigures figures;
  for (std::size_t i = 0; i < size_; i += 4) {
    const LaneQuad score = score_block<false>(apex, lanes_.data() + kBlock * (i / 4));
    worst = min(worst, score);
    if (any_less(worst, limit)) break;
    const LaneQuad gain = LaneQuad::of(-1.0F) / (max(score, LaneQuad::of(0.0F)) + offset);
    if (i + 4 <= size_) {
      sum = sum + gain;
    } else {
      gain.store(out.data());
      for (std::size_t k = 0; i + k < size_; ++k) figures.sum += double{out[k]};
    }
  }
  sum.store(out.data());
  for (const float lane : out) figures.sum += double{lane};
  worst.store(out.data());
  figures.worst = double{std::min(std::min(out[0], out[1]), std::min(out[2], out[3]))};
  return figures;
}

template <bool kFromBehind>
void StarQuality::fill_scores(const Vec3& p, std::vector<double>& scores) const {
  const LaneApex apex = build_apex(scale_, origin_, p);
  scores.resize(size_);
  std::array<float, 4> out{};
  for (std::size_t i = 0; i < size_; i += 4) {
    score_block<kFromBehind>(apex, lanes_.data() + kBlock * (i / 4)).store(out.data());
    for (std::size_t k = 0; k < 4 && i + k < size_; ++k) scores[i + k] = double{out[k]};
  }
}

void StarQuality::scores(const Vec3& p, std::vector<double>& scores) const {
  fill_scores<false>(p, scores);
}

void StarQuality::scores_from_behind(const Vec3& p, std::vector<double>& scores) const {
  fill_scores<true>(p, scores);
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

double score_tet(const ScoreScale& scale, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  static thread_local StarQuality star;
  star.start(scale, a);
  star.add(b, c, d);
  star.close();
  return star.evaluate(a).worst;
}

}  // namespace palpate::simplify

#include "core/simplify/cone.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/orientation.h"

namespace palpate::simplify {
namespace {

struct LaneVec {
  LanePair x;
  LanePair y;
  LanePair z;
};

LaneVec operator-(const LaneVec& a, const LaneVec& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

LanePair dot(const LaneVec& a, const LaneVec& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

LaneVec cross(const LaneVec& a, const LaneVec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

constexpr double kIdealSolidAngleSr = 0.55;

LanePair gain_of(LanePair score) {
  const LanePair s = max(score, LanePair::of(1e-9));
  return sqrt(sqrt(s));
}

}  // namespace

double gain_of_score(double score) {
  std::array<double, 2> out{};
  gain_of(LanePair::of(score)).store(out.data());
  return out[0];
}

void Cone::reserve_next() {
  if (size_ + 2 <= rows_[0].size()) return;
  for (std::vector<double>& row : rows_) row.resize(2 * size_ + 64);
}

void Cone::add(const Vec3& a, const Vec3& b, const Vec3& c) {
  reserve_next();
  const std::array<double, kRows> entry{a.x, a.y, a.z, b.x,           b.y,           b.z,
                                        c.x, c.y, c.z, length(c - b), length(a - c), length(b - a)};
  // The entry behind the last one repeats it, so that pairs are always whole.
  for (std::size_t r = 0; r < kRows; ++r) rows_[r][size_] = rows_[r][size_ + 1] = entry[r];
  ++size_;
}

template <bool kFromBehind>
LanePair Cone::score_pair(const ScoreScale& scale, const Vec3& p, std::size_t i) const {
  const auto row = [&](std::size_t r) { return LanePair::load(rows_[r].data() + i); };
  const LaneVec apex{LanePair::of(p.x), LanePair::of(p.y), LanePair::of(p.z)};
  const LaneVec u = LaneVec{row(0), row(1), row(2)} - apex;
  const LaneVec v = LaneVec{row(3), row(4), row(5)} - apex;
  const LaneVec w = LaneVec{row(6), row(7), row(8)} - apex;
  const LanePair vw = row(9);
  const LanePair wu = row(10);
  const LanePair uv = row(11);
  const LaneVec n_u = cross(v, w);
  const LaneVec n_v = cross(w, u);
  const LaneVec n_w = cross(u, v);
  const LanePair six = kFromBehind ? LanePair::of(0.0) - dot(u, n_u) : dot(u, n_u);
  const LanePair uu2 = dot(u, u);
  const LanePair vv2 = dot(v, v);
  const LanePair ww2 = dot(w, w);
  const LanePair vw2 = vw * vw;
  const LanePair wu2 = wu * wu;
  const LanePair uv2 = uv * uv;
  const LanePair lu = sqrt(uu2);
  const LanePair lv = sqrt(vv2);
  const LanePair lw = sqrt(ww2);
  const LanePair half = LanePair::of(0.5);
  const auto denominator = [&](LanePair a, LanePair b, LanePair c, LanePair aa, LanePair bb, LanePair cc,
                               LanePair ab, LanePair bc, LanePair ca) {
    return a * b * c + half * ((aa + bb - ab) * c + (bb + cc - bc) * a + (cc + aa - ca) * b);
  };
  const LanePair at_p = denominator(lu, lv, lw, uu2, vv2, ww2, uv2, vw2, wu2);
  const LanePair at_a = denominator(lu, uv, wu, uu2, uv2, wu2, vv2, vw2, ww2);
  const LanePair at_b = denominator(lv, uv, vw, vv2, uv2, vw2, uu2, wu2, ww2);
  const LanePair at_c = denominator(lw, wu, vw, ww2, wu2, vw2, uu2, uv2, vv2);
  const LanePair x = six / max(max(at_p, at_a), max(at_b, at_c));
  const LanePair x2 = x * x;
  const LanePair series = LanePair::of(1.0) - x2 * (LanePair::of(1.0 / 3.0) -
                                                    x2 * (LanePair::of(0.2) - x2 * LanePair::of(1.0 / 7.0)));
  const LanePair shortest = min(min(min(lu, lv), min(lw, vw)), min(wu, uv));
  const LanePair longest = max(max(max(lu, lv), max(lw, vw)), max(wu, uv));
  const LanePair relative_volume = min(LanePair::of(1.0), six * LanePair::of(scale.inverse_six_ideal));
  LanePair cube = x * series * LanePair::of(2.0 / kIdealSolidAngleSr) * (shortest / longest);
  cube = cube * max(relative_volume, LanePair::of(-1.0));
  // Products of two negative factors must not look positive.
  cube = min(cube, six * LanePair::of(scale.inverse_six_ideal) * LanePair::of(1e6));
  if (scale.dihedral_weight == 0.0) return cube;
  // sin^2 at the edge of faces i and j: (6 V)^2 e^2 / (4 A_i^2 4 A_j^2)
  const LaneVec n_p = {n_u.x + n_v.x + n_w.x, n_u.y + n_v.y + n_w.y, n_u.z + n_v.z + n_w.z};
  const LanePair area_u = dot(n_u, n_u);
  const LanePair area_v = dot(n_v, n_v);
  const LanePair area_w = dot(n_w, n_w);
  const LanePair area_p = dot(n_p, n_p);
  const LanePair area_uv = area_u * area_v;
  const LanePair area_wp = area_w * area_p;
  const LanePair area_uw = area_u * area_w;
  const LanePair area_vp = area_v * area_p;
  const LanePair area_vw = area_v * area_w;
  const LanePair area_up = area_u * area_p;
  // faces u and v (opposite to a and b) meet in the edge (p, c), and so on
  const LanePair least = min(min(min(ww2 * area_wp, uv2 * area_uv), min(vv2 * area_vp, wu2 * area_uw)),
                             min(uu2 * area_up, vw2 * area_vw));
  const LanePair sine_sq = six * six * least / (area_uv * area_wp);
  // Three points in a line: 0 / 0. min gives its second operand for that, and that one is a number: a bad
  // score that turned into none would be lost in the worst of the set.
  return min(sine_sq * LanePair::of(scale.dihedral_weight), cube);
}

ConeFigures Cone::evaluate(const ScoreScale& scale, const Vec3& p, double bound) const {
  ConeFigures figures{1e300, 0.0};
  const LanePair limit = LanePair::of(bound);
  LanePair worst = LanePair::of(1e300);
  LanePair sum = LanePair::of(0.0);
  std::size_t i = 0;
  for (; i + 1 < size_; i += 2) {
    const LanePair score = score_pair<false>(scale, p, i);
    worst = min(worst, score);
    if (any_less(worst, limit)) break;
    sum = sum + gain_of(score);
  }
  std::array<double, 2> out{};
  if (i + 1 == size_) {  // both lanes hold the last tet
    const LanePair score = score_pair<false>(scale, p, i);
    worst = min(worst, score);
    gain_of(score).store(out.data());
    figures.sum = out[0];
  }
  sum.store(out.data());
  figures.sum += out[0] + out[1];
  worst.store(out.data());
  figures.worst = std::min(out[0], out[1]);
  return figures;
}

void Cone::scores(const ScoreScale& scale, const Vec3& p, std::vector<double>& scores) const {
  scores.resize(size_ + 1);
  for (std::size_t i = 0; i < size_; i += 2) score_pair<false>(scale, p, i).store(scores.data() + i);
  scores.resize(size_);
}

void Cone::scores_from_behind(const ScoreScale& scale, const Vec3& p, std::vector<double>& scores) const {
  scores.resize(size_ + 1);
  for (std::size_t i = 0; i < size_; i += 2) score_pair<true>(scale, p, i).store(scores.data() + i);
  scores.resize(size_);
}

Vec3 Cone::volume_centroid(const Vec3& p) const {
  Vec3 sum{};
  double volume = 0.0;
  for (std::size_t i = 0; i < size_; ++i) {
    const Vec3 a{rows_[0][i], rows_[1][i], rows_[2][i]};
    const Vec3 b{rows_[3][i], rows_[4][i], rows_[5][i]};
    const Vec3 c{rows_[6][i], rows_[7][i], rows_[8][i]};
    const double six = dot(cross(a - p, b - p), c - p);
    volume += six;
    sum = sum + (0.25 * six) * (a + b + c + p);
  }
  return volume > 0.0 ? (1.0 / volume) * sum : p;
}

bool Cone::is_positive_exactly(const Vec3& p) const {
  for (std::size_t i = 0; i < size_; ++i) {
    if (orientation(p, {rows_[0][i], rows_[1][i], rows_[2][i]}, {rows_[3][i], rows_[4][i], rows_[5][i]},
                    {rows_[6][i], rows_[7][i], rows_[8][i]}) <= 0) {
      return false;
    }
  }
  return true;
}

}  // namespace palpate::simplify

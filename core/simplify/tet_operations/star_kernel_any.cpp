// Four tets at a time on every processor.
#include "core/base/processor.h"
#include "core/simplify/tet_operations/star_lanes.h"

namespace palpate::simplify {
namespace {

using Four = Lanes<float>;

/// Four lanes as star_lanes.h asks for them.
struct StarFour {
  static constexpr std::size_t kWidth = 4;

  Four v;

  static StarFour of(float all) { return {Four::of(all)}; }
  static StarFour load(const float* four) { return {Four::load(four)}; }
  void store(float* four) const { v.store(four); }
  Four low() const { return v; }
  friend StarFour operator+(const StarFour& a, const StarFour& b) { return {a.v + b.v}; }
  friend StarFour operator-(const StarFour& a, const StarFour& b) { return {a.v - b.v}; }
  friend StarFour operator*(const StarFour& a, const StarFour& b) { return {a.v * b.v}; }
  friend StarFour operator/(const StarFour& a, const StarFour& b) { return {a.v / b.v}; }
  friend StarFour min(const StarFour& a, const StarFour& b) { return {min(a.v, b.v)}; }
  friend StarFour max(const StarFour& a, const StarFour& b) { return {max(a.v, b.v)}; }
  friend StarFour sqrt(const StarFour& a) { return {sqrt(a.v)}; }
  friend StarFour root_of_square(const StarFour& /*x*/, const StarFour& square) { return sqrt(square); }
  friend bool any_less(const StarFour& a, const StarFour& b) { return any_less(a.v, b.v); }

  static LaneVec<StarFour> load_points(const StarTriangle* base, std::size_t corner, const Vec3& origin,
                                       double unit) {
    std::array<std::array<float, 4>, 3> rows{};
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3& p = *base[i][corner];
      rows[0][i] = static_cast<float>((p.x - origin.x) * unit);
      rows[1][i] = static_cast<float>((p.y - origin.y) * unit);
      rows[2][i] = static_cast<float>((p.z - origin.z) * unit);
    }
    return {load(rows[0].data()), load(rows[1].data()), load(rows[2].data())};
  }
};

void pack(const StarTriangle* base, std::size_t size, const Vec3& origin, double unit, float* blocks) {
  pack_lanes<StarFour>(base, size, origin, unit, blocks);
}

template <bool kFromBehind>
void score(const float* blocks, std::size_t size, const StarApex& apex, float* scores) {
  score_all_lanes<kFromBehind, StarFour>(blocks, size, apex, scores);
}

StarFigures evaluate(const float* blocks, std::size_t size, const StarApex& apex, float gain_offset,
                     float bound, float* scores) {
  return evaluate_lanes<StarFour>(blocks, size, apex, gain_offset, bound, scores);
}

}  // namespace

const StarKernel kStarKernel{pack, score<false>, score<true>, evaluate};

const StarKernel& star_kernel() {
  static const StarKernel& best = has_avx2() ? kStarKernelAvx2 : kStarKernel;
  return best;
}

}  // namespace palpate::simplify

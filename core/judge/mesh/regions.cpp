#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/judge/mesh/judge.h"
#include "core/judge/mesh/vertex_links.h"

namespace palpate::judge {
namespace {

constexpr int kMostSteps = 1000;

double largest_coordinate(const TetMesh& mesh) {
  double largest = 0.0;
  for (const Vec3& p : mesh.points) {
    for (const double x : {p.x, p.y, p.z}) {
      if (std::isfinite(x)) largest = std::max(largest, std::fabs(x));
    }
  }
  return largest;
}

struct Box {
  Vec3 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
           std::numeric_limits<double>::infinity()};
  Vec3 high{-low.x, -low.y, -low.z};

  void add(const Vec3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }

  bool is_apart(const Box& other, double by) const {
    return low.x - other.high.x > by || other.low.x - high.x > by || low.y - other.high.y > by ||
           other.low.y - high.y > by || low.z - other.high.z > by || other.low.z - high.z > by;
  }
};

Box box_of(std::span<const Vec3> points) {
  Box box;
  for (const Vec3& p : points) box.add(p);
  return box;
}

/// The corner of the convex hull of p - q that lies farthest against `direction`.
Vec3 support_against(std::span<const Vec3> p, std::span<const Vec3> q, const Vec3& direction) {
  const auto along = [&](const Vec3& a, const Vec3& b) { return dot(a, direction) < dot(b, direction); };
  return *std::min_element(p.begin(), p.end(), along) - *std::max_element(q.begin(), q.end(), along);
}

/// Are the convex hulls of p and q certainly within `reach` of each other?
bool are_within(std::span<const Vec3> p, std::span<const Vec3> q, double reach) {
  Vec3 nearest = p[0] - q[0];
  for (const Vec3& a : p) {
    for (const Vec3& b : q) {
      if (length_sq(a - b) < length_sq(nearest)) nearest = a - b;
    }
  }
  for (int step = 0; step < kMostSteps; ++step) {
    const double size = length(nearest);
    if (size <= reach) return true;
    const Vec3 corner = support_against(p, q, nearest);
    if (dot(corner, nearest) > reach * size) return false;
    const Vec3 back = nearest - corner;
    const double back_sq = length_sq(back);
    if (!(back_sq > 0.0)) return false;
    nearest = nearest - std::clamp(dot(nearest, back) / back_sq, 0.0, 1.0) * back;
  }
  return false;
}

/// The boundary faces with a vertex in the ball.
std::vector<std::array<Vec3, 3>> faces_of_patch(const TetMesh& mesh, const Region& region) {
  std::vector<std::array<Vec3, 3>> faces;
  for_each_boundary_face(mesh, [&](const Triangle& t) {
    const std::array<Vec3, 3> corners{mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]};
    if (std::any_of(corners.begin(), corners.end(),
                    [&](const Vec3& p) { return length(p - region.vector) <= region.size; }))
      faces.push_back(corners);
  });
  return faces;
}

/// Answers for one region which tets certainly meet it.
class RegionTest {
 public:
  RegionTest(const Region& region, const TetMesh& input)
      : region_(region), margin_(std::ldexp(largest_coordinate(input), -40)) {
    if (region.kind == Region::Kind::kSurfacePatch) faces_ = faces_of_patch(input, region);
    for (const auto& face : faces_) {
      face_boxes_.push_back(box_of(face));
      for (const Vec3& p : face) patch_box_.add(p);
    }
  }

  bool meets(const std::array<Vec3, 4>& tet) const {
    switch (region_.kind) {
      case Region::Kind::kSphere:
        return are_within(tet, {&region_.vector, 1}, std::max(0.0, region_.size - margin_));
      case Region::Kind::kHalfSpace: {
        const double least = std::min({dot(region_.vector, tet[0]), dot(region_.vector, tet[1]),
                                       dot(region_.vector, tet[2]), dot(region_.vector, tet[3])});
        return least <= region_.size - margin_ * length(region_.vector);
      }
      case Region::Kind::kSurfacePatch:
        return meets_patch(tet);
    }
    return false;
  }

 private:
  bool meets_patch(const std::array<Vec3, 4>& tet) const {
    const double reach = std::max(0.0, region_.depth - margin_);
    const Box box = box_of(tet);
    if (box.is_apart(patch_box_, reach)) return false;
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      if (!box.is_apart(face_boxes_[i], reach) && are_within(tet, faces_[i], reach)) return true;
    }
    return false;
  }

  Region region_;
  double margin_;
  std::vector<std::array<Vec3, 3>> faces_;
  std::vector<Box> face_boxes_;
  Box patch_box_;
};

/// Calls visit(corners) for each tet with valid indices that meets a region. The answer does not depend on
/// the order of its corners.
template <typename Visit>
void for_each_met(const std::vector<RegionTest>& tests, const TetMesh& mesh, Visit&& visit) {
  for (const Tet& t : mesh.tets) {
    if (!has_valid_indices(t, mesh.points.size())) continue;
    const std::array<Vec3, 4> corners{mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]],
                                      mesh.points[t[3]]};
    std::array<Vec3, 4> sorted = corners;
    std::sort(sorted.begin(), sorted.end(),
              [](const Vec3& a, const Vec3& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); });
    if (std::any_of(tests.begin(), tests.end(), [&](const RegionTest& test) { return test.meets(sorted); }))
      visit(corners);
  }
}

/// The bit patterns of a tet's points in order, then 1 if sorting them took an odd number of swaps.
using TetBits = std::array<std::uint64_t, 13>;

TetBits corner_bits(std::array<Vec3, 4> corners) {
  std::array<std::array<std::uint64_t, 3>, 4> points;
  for (std::size_t i = 0; i < 4; ++i) {
    points[i] = {std::bit_cast<std::uint64_t>(corners[i].x), std::bit_cast<std::uint64_t>(corners[i].y),
                 std::bit_cast<std::uint64_t>(corners[i].z)};
  }
  std::uint64_t odd = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    for (std::size_t j = i; j > 0 && points[j] < points[j - 1]; --j) {
      std::swap(points[j], points[j - 1]);
      odd ^= 1U;
    }
  }
  TetBits bits{};
  for (std::size_t i = 0; i < 12; ++i) bits[i] = points[i / 3][i % 3];
  bits[12] = odd;
  return bits;
}

}  // namespace

RegionFigures compare_in_regions(const TetMesh& output, const TetMesh& input,
                                 std::span<const Region> regions) {
  RegionFigures figures;
  if (regions.empty()) return figures;
  std::vector<RegionTest> tests;
  for (const Region& region : regions) tests.emplace_back(region, input);
  std::vector<TetBits> wanted;
  for_each_met(tests, input, [&](const auto& corners) { wanted.push_back(corner_bits(corners)); });
  std::vector<TetBits> found;
  for_each_met(tests, output, [&](const auto& corners) { found.push_back(corner_bits(corners)); });
  figures.input_tets = wanted.size();
  figures.output_tets = found.size();
  std::sort(wanted.begin(), wanted.end());
  std::sort(found.begin(), found.end());
  std::vector<TetBits> missing;
  std::set_difference(wanted.begin(), wanted.end(), found.begin(), found.end(), std::back_inserter(missing));
  figures.changed_tets = missing.size();
  return figures;
}

}  // namespace palpate::judge

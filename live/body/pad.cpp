#include "live/body/pad.h"

#include <limits>
#include <string>

#include "core/base/error.h"

namespace palpate::live {
namespace {

constexpr int kParts = 8;  ///< along an edge of a face: 64 in all

Vec3 area_of(std::span<const Vec3> rest, const Triangle& face) {
  return 0.5 * cross(rest[face[1]] - rest[face[0]], rest[face[2]] - rest[face[0]]);
}

/// The share of a face's parts whose centroids are near enough.
double share_within(std::span<const Vec3> rest, const Triangle& face, const Vec3& center, double radius) {
  const Vec3& a = rest[face[0]];
  const Vec3 ab = (1.0 / kParts) * (rest[face[1]] - a);
  const Vec3 ac = (1.0 / kParts) * (rest[face[2]] - a);
  int within = 0;
  for (int i = 0; i < kParts; ++i) {
    for (int j = 0; i + j < kParts; ++j) {
      const auto is_near = [&](double s, double t) {
        return length_sq(a + s * ab + t * ac - center) <= radius * radius;
      };
      within += is_near(i + 1.0 / 3.0, j + 1.0 / 3.0) ? 1 : 0;
      if (i + j + 1 < kParts) within += is_near(i + 2.0 / 3.0, j + 2.0 / 3.0) ? 1 : 0;
    }
  }
  return static_cast<double>(within) / (kParts * kParts);
}

}  // namespace

FacePatch find_pad(std::span<const Vec3> rest, std::span<const Triangle> skin, const Vec3& center_m,
                   const Vec3& outward, double radius_m) {
  require(!skin.empty() && radius_m > 0.0, "a skin, and a radius above zero");
  FacePatch patch;
  double nearest_sq = std::numeric_limits<double>::infinity();
  Triangle nearest = skin.front();
  for (const Triangle& face : skin) {
    if (!(dot(area_of(rest, face), outward) > 0.0)) continue;
    const Vec3 middle = (1.0 / 3.0) * (rest[face[0]] + rest[face[1]] + rest[face[2]]);
    const double away_sq = length_sq(middle - center_m);
    if (away_sq < nearest_sq) {
      nearest_sq = away_sq;
      nearest = face;
    }
    const double share = share_within(rest, face, center_m, radius_m);
    if (share <= 0.0) continue;
    patch.faces.push_back(face);
    patch.weight.push_back(share);
  }
  if (patch.faces.empty()) patch = {{nearest}, {1.0}};
  return patch;
}

Vec3 skin_normal(std::span<const Vec3> rest, std::span<const Triangle> skin, Index vertex) {
  Vec3 sum;
  for (const Triangle& face : skin) {
    if (face[0] == vertex || face[1] == vertex || face[2] == vertex) sum = sum + area_of(rest, face);
  }
  const double size = length(sum);
  if (!(size > 0.0)) throw InputError("vertex", 0, "one of the skin", std::to_string(vertex));
  return (1.0 / size) * sum;
}

std::vector<dynamics::SupportFace> pad_faces(std::span<const Vec3> rest, const FacePatch& patch,
                                             double stiffness_pa_per_m) {
  std::vector<dynamics::SupportFace> faces;
  for (std::size_t f = 0; f < patch.faces.size(); ++f) {
    const double area = length(area_of(rest, patch.faces[f]));
    faces.push_back({patch.faces[f], stiffness_pa_per_m * patch.weight[f] * area / 12.0, {}});
  }
  return faces;
}

}  // namespace palpate::live

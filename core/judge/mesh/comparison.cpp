#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/judge/mesh/judge.h"
#include "core/judge/mesh/tet_shape.h"
#include "core/judge/mesh/vertex_links.h"

namespace palpate::judge {
namespace {

/// The bit patterns of a vertex's coordinates.
using PointBits = std::array<std::uint64_t, 3>;

/// An oriented face, turned so that its least point comes first.
using FaceBits = std::array<PointBits, 3>;

PointBits bits_of(const Vec3& p) {
  return {std::bit_cast<std::uint64_t>(p.x), std::bit_cast<std::uint64_t>(p.y),
          std::bit_cast<std::uint64_t>(p.z)};
}

/// The boundary faces as sorted bit patterns.
std::vector<FaceBits> boundary_bits(const TetMesh& mesh) {
  std::vector<FaceBits> faces;
  for_each_boundary_face(mesh, [&](const Triangle& t) {
    FaceBits bits{bits_of(mesh.points[t[0]]), bits_of(mesh.points[t[1]]), bits_of(mesh.points[t[2]])};
    std::rotate(bits.begin(), std::min_element(bits.begin(), bits.end()), bits.end());
    faces.push_back(bits);
  });
  std::sort(faces.begin(), faces.end());
  return faces;
}

/// Adds how many faces only one of two sorted lists has; equal faces are matched one to one.
void compare_boundaries(const std::vector<FaceBits>& output, const std::vector<FaceBits>& input,
                        Comparison& result) {
  auto o = output.begin();
  auto i = input.begin();
  while (o != output.end() && i != input.end()) {
    if (*o == *i) {
      ++o;
      ++i;
    } else if (*o < *i) {
      ++o;
      ++result.boundary_new_faces;
    } else {
      ++i;
      ++result.boundary_missing_faces;
    }
  }
  result.boundary_new_faces += static_cast<std::uint64_t>(output.end() - o);
  result.boundary_missing_faces += static_cast<std::uint64_t>(input.end() - i);
  result.boundary_changed_faces = result.boundary_new_faces + result.boundary_missing_faces;
}

double relative_drift(const TetMesh& output, const TetMesh& input) {
  const int exponent = std::max(length_exponent(output.points), length_exponent(input.points));
  const double before = sum_volumes(input, exponent);
  const double after = sum_volumes(output, exponent);
  if (before == after) return 0.0;
  const double largest = std::numeric_limits<double>::max();
  return before == 0.0 ? 1.0 : std::min(std::fabs(after - before) / std::fabs(before), largest);
}

}  // namespace

Comparison compare_with_input(const TetMesh& output, const TetMesh& input) {
  Comparison result;
  compare_boundaries(boundary_bits(output), boundary_bits(input), result);
  result.volume_drift_relative = relative_drift(output, input);
  const Counts after = count_elements(output);
  const Counts before = count_elements(input);
  result.euler_unchanged = after.euler == before.euler && after.boundary_euler == before.boundary_euler;
  result.components_unchanged =
      after.components == before.components && after.boundary_components == before.boundary_components;
  return result;
}

}  // namespace palpate::judge

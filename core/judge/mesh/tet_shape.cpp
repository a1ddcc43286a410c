#include "core/judge/mesh/tet_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/judge/mesh/compensated_sum.h"
#include "core/judge/mesh/exact_orientation.h"
#include "core/judge/mesh/vertex_links.h"

namespace palpate::judge {
namespace {

constexpr double kSmallSolidAngle = 1e-3;
constexpr int kSafeExponent = 150;      // of lengths whose fourth powers are far from overflow and underflow
constexpr int kSafeMeshExponent = 300;  // of lengths whose third powers are

/// Edge vectors of a tet in the order of kTetEdges, multiplied by 2^-exponent.
struct EdgeVectors {
  std::array<Vec3, 6> e;
  int exponent = 0;
};

double largest_component(const std::array<Vec3, 6>& vectors) {
  double largest = 0.0;
  for (const Vec3& v : vectors) {
    largest = std::max({largest, std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  }
  return largest;
}

std::array<Vec3, 6> differences(const std::array<Vec3, 4>& p) {
  std::array<Vec3, 6> e;
  for (std::size_t i = 0; i < e.size(); ++i) {
    e[i] = p[static_cast<std::size_t>(kTetEdges[i][1])] - p[static_cast<std::size_t>(kTetEdges[i][0])];
  }
  return e;
}

Vec3 scaled(const Vec3& v, int exponent) {
  return {std::scalbn(v.x, exponent), std::scalbn(v.y, exponent), std::scalbn(v.z, exponent)};
}

/// Requires finite points.
EdgeVectors edge_vectors(std::array<Vec3, 4> p) {
  EdgeVectors result{differences(p), 0};
  double largest = largest_component(result.e);
  if (!std::isfinite(largest)) {
    for (Vec3& v : p) v = scaled(v, -2);
    result = {differences(p), 2};
    largest = largest_component(result.e);
  }
  if (largest == 0.0) return result;
  const int shift = std::ilogb(largest);
  if (std::abs(shift) <= kSafeExponent) return result;
  for (Vec3& v : result.e) v = scaled(v, -shift);
  result.exponent += shift;
  return result;
}

double determinant(const EdgeVectors& edges) {
  return dot(cross(edges.e[0], edges.e[1]), edges.e[2]);
}

/// The edge between two local vertices, by its place in kTetEdges.
constexpr std::array<std::array<int, 4>, 4> kEdgeBetween{
    {{-1, 0, 1, 2}, {0, -1, 3, 4}, {1, 3, -1, 5}, {2, 4, 5, -1}}};

/// The two faces at each edge of kTetEdges: those opposite to the two vertices that it lacks.
constexpr std::array<std::array<int, 2>, 6> kFacesAtEdge{{{2, 3}, {1, 3}, {1, 2}, {0, 3}, {0, 2}, {0, 1}}};

struct Angles {
  std::array<double, 6> dihedral{};  // in the order of kTetEdges
  std::array<double, 6> length{};
};

/// The four faces' outward normals, twice as long as the areas.
std::array<Vec3, 4> outward_normals(const EdgeVectors& edges) {
  const auto& e = edges.e;
  return {cross(e[3], e[4]), cross(e[2], e[1]), cross(e[0], e[2]), cross(e[1], e[0])};
}

Angles measure_angles(const EdgeVectors& edges, double six_volumes) {
  const std::array<Vec3, 4> normals = outward_normals(edges);
  Angles angles;
  for (std::size_t i = 0; i < 6; ++i) {
    angles.length[i] = length(edges.e[i]);
    const double cosine_part = -dot(normals[static_cast<std::size_t>(kFacesAtEdge[i][0])],
                                    normals[static_cast<std::size_t>(kFacesAtEdge[i][1])]);
    angles.dihedral[i] = std::atan2(six_volumes * angles.length[i], cosine_part);
  }
  return angles;
}

/// tan(angle / 2) of the angle between two vectors of the given lengths; never cancels.
double half_angle_tangent(const Vec3& a, double a_length, const Vec3& b, double b_length) {
  const double across = length(cross(a, b));
  const double along = dot(a, b);
  const double lengths = a_length * b_length;
  if (along >= 0.0) return across / (lengths + along);
  return across > 0.0 ? (lengths - along) / across : std::numeric_limits<double>::max();
}

/// The solid angle at a vertex whose dihedral angles are least at edge `edge` (see the header).
double small_solid_angle(const EdgeVectors& edges, const Angles& angles, std::size_t vertex,
                         std::size_t edge) {
  std::array<std::size_t, 2> others{};
  std::size_t count = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    if (j == vertex) continue;
    const auto other = static_cast<std::size_t>(kEdgeBetween[vertex][j]);
    if (other != edge) others[count++] = other;
  }
  const auto outgoing = [&](std::size_t i) {
    return static_cast<std::size_t>(kTetEdges[i][0]) == vertex ? edges.e[i] : -1.0 * edges.e[i];
  };
  const double cosine = std::cos(angles.dihedral[edge]);
  const double sine = std::sin(angles.dihedral[edge]);
  double t = 1.0;
  for (const std::size_t other : others) {
    t *= half_angle_tangent(outgoing(edge), angles.length[edge], outgoing(other), angles.length[other]);
  }
  t = std::min(t, std::numeric_limits<double>::max());
  // Divided by t where t is large, so that t sin C does not overflow.
  const double tangent = t > 1.0 ? sine / (1.0 / t + cosine) : t * sine / (1.0 + t * cosine);
  return 2.0 * std::atan(tangent);
}

double solid_angle(const EdgeVectors& edges, const Angles& angles, std::size_t vertex) {
  double sum = 0.0;
  std::size_t least = 0;
  double least_angle = std::numeric_limits<double>::max();
  for (std::size_t j = 0; j < 4; ++j) {
    if (j == vertex) continue;
    const auto edge = static_cast<std::size_t>(kEdgeBetween[vertex][j]);
    sum += angles.dihedral[edge];
    if (angles.dihedral[edge] < least_angle) {
      least_angle = angles.dihedral[edge];
      least = edge;
    }
  }
  const double excess = sum - std::numbers::pi;
  return excess > kSmallSolidAngle ? excess : small_solid_angle(edges, angles, vertex, least);
}

/// Requires: a positive volume.
double mean_ratio(const EdgeVectors& edges, double volume) {
  double squares = 0.0;
  for (const Vec3& e : edges.e) squares += dot(e, e);
  const double root = std::cbrt(3.0 * volume);
  return 12.0 * root * root / squares;
}

/// Requires: a positive volume.
double radius_ratio(const EdgeVectors& edges, double volume) {
  const auto& [a, b, c, d, e, f] = edges.e;
  double area = 0.0;
  for (const Vec3& normal : outward_normals(edges)) area += 0.5 * length(normal);
  const double turned = length(dot(a, a) * cross(b, c) + dot(b, b) * cross(c, a) + dot(c, c) * cross(a, b));
  return turned > 0.0 ? std::min(1.0, 108.0 * (volume / area) * (volume / turned)) : 0.0;
}

}  // namespace

double ScaledVolume::in_units_of(int length_exponent) const {
  return exponent == 3 * length_exponent ? value : std::scalbn(value, exponent - 3 * length_exponent);
}

ScaledVolume measure_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  if (!is_finite(a) || !is_finite(b) || !is_finite(c) || !is_finite(d)) return {};
  const EdgeVectors edges = edge_vectors({a, b, c, d});
  return {determinant(edges) / 6.0, 3 * edges.exponent};
}

TetShape measure_tet(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  TetShape shape;
  shape.max_dihedral = std::numbers::pi;
  if (!is_finite(a) || !is_finite(b) || !is_finite(c) || !is_finite(d)) return shape;
  const EdgeVectors edges = edge_vectors({a, b, c, d});
  const int sign = exact_orientation(a, b, c, d);
  const double rounded = determinant(edges);
  const double six_volumes = sign > 0 ? std::max(rounded, 0.0) : (sign < 0 ? std::min(rounded, 0.0) : 0.0);
  shape.volume = {six_volumes / 6.0, 3 * edges.exponent};
  const Angles angles = measure_angles(edges, std::fabs(six_volumes));
  const auto [shortest, longest] = std::minmax_element(angles.length.begin(), angles.length.end());
  shape.edge_ratio = *longest > 0.0 ? *shortest / *longest : 0.0;
  if (sign <= 0) return shape;
  shape.is_positive = true;
  const auto [least, greatest] = std::minmax_element(angles.dihedral.begin(), angles.dihedral.end());
  shape.min_dihedral = *least;
  shape.max_dihedral = *greatest;
  shape.min_solid_angle = solid_angle(edges, angles, 0);
  for (std::size_t v = 1; v < 4; ++v) {
    shape.min_solid_angle = std::min(shape.min_solid_angle, solid_angle(edges, angles, v));
  }
  shape.mean_ratio = mean_ratio(edges, shape.volume.value);
  shape.radius_ratio = radius_ratio(edges, shape.volume.value);
  return shape;
}

int length_exponent(std::span<const Vec3> points) {
  double largest = 0.0;
  for (const Vec3& p : points) {
    if (is_finite(p)) largest = std::max({largest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  }
  const int exponent = largest > 0.0 ? std::ilogb(largest) : 0;
  return std::abs(exponent) > kSafeMeshExponent ? exponent : 0;
}

double sum_volumes(const TetMesh& mesh, int length_exponent) {
  CompensatedSum sum;
  const std::vector<Vec3>& p = mesh.points;
  for (const Tet& t : mesh.tets) {
    if (!has_valid_indices(t, p.size())) continue;
    sum.add(measure_volume(p[t[0]], p[t[1]], p[t[2]], p[t[3]]).in_units_of(length_exponent));
  }
  return sum.value();
}

double unscaled_volume(double value, int length_exponent) {
  constexpr double kLargest = std::numeric_limits<double>::max();
  return length_exponent == 0 ? value
                              : std::clamp(std::scalbn(value, 3 * length_exponent), -kLargest, kLargest);
}

}  // namespace palpate::judge

#include "core/mesh/shapes/body_surfaces.h"

#include <array>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"

namespace palpate {
namespace {

// Only + - * / and sqrt, which IEEE 754 rounds correctly: the bytes do not depend on the maths library.

/// 1 at 0, falling to 1/4 at `width` and to nothing far off.
double bump(double x, double width) {
  const double fall = 1.0 / (1.0 + (x / width) * (x / width));
  return fall * fall;
}

/// Takes a point of the unit sphere to the leaf, in mm.
///
///   notches     y > 0 is drawn in by a factor of x alone, which stays above 1/2
///   thickness   z is scaled by a positive factor of x
///   cup         z gets the height of a paraboloid: a shear
Vec3 spleen_point(const Vec3& p) {
  constexpr double kHalfLength = 56.0;
  constexpr double kHalfWidth = 35.0;
  constexpr double kHalfThickness = 8.0;
  constexpr double kCup = 0.008;  // 1/mm
  const double notch = 1.0 - 0.35 * bump(p.x - 0.15, 0.12) - 0.25 * bump(p.x + 0.4, 0.1);
  const double x = kHalfLength * p.x;
  const double y = kHalfWidth * p.y * (p.y > 0.0 ? notch : 1.0);
  const double z = kHalfThickness * (1.0 + 0.2 * p.x) * p.z;
  return {x, y, z + 0.5 * kCup * (x * x + 0.7 * y * y)};
}

/// Takes a point of a straight bag, in mm, to the bent one: sections grow along the axis, and the axis
/// becomes a parabola that they stay normal to. One-to-one while sections are narrower than the parabola's
/// radius of 80 mm.
Vec3 bent_bag_point(const Vec3& p) {
  constexpr double kHalfLength = 90.0;
  constexpr double kGrowth = 0.3;
  constexpr double kCurvature = 1.0 / 80.0;
  const double factor = 1.0 + kGrowth * p.x / kHalfLength;
  const double slope = kCurvature * p.x;
  const double normal = factor * p.y / std::sqrt(1.0 + slope * slope);
  return {p.x - slope * normal, 0.5 * slope * p.x + normal, factor * p.z};
}

Vec3 scaled(const Vec3& p, const Vec3& axes) {
  return {axes.x * p.x, axes.y * p.y, axes.z * p.z};
}

/// Distance of the lobed body's skin from its middle, in the direction of a unit vector, in mm.
double lobes_radius(const Vec3& p) {
  struct Lobe {
    Vec3 direction;  // of any length
    double height;   // mm
  };
  constexpr std::array<Lobe, 6> kLobes{{{{1.0, 0.2, 0.1}, 32.0},
                                        {{-0.9, 0.5, 0.2}, 28.0},
                                        {{0.1, -1.0, 0.3}, 30.0},
                                        {{-0.3, -0.4, -0.9}, 24.0},
                                        {{0.3, 0.7, -0.7}, 26.0},
                                        {{-0.1, 0.4, 1.0}, 22.0}}};
  double radius = 24.0;
  for (const Lobe& lobe : kLobes) {
    const double cosine = dot(p, lobe.direction) / length(lobe.direction);
    const double near = 0.5 * (1.0 + cosine);
    const double near_4 = near * near * near * near;
    radius += lobe.height * near_4 * near_4 * near_4;
  }
  return radius;
}

/// 6 n points of the unit circle: the sides of a regular hexagon divided, and put on the circle.
std::vector<std::array<double, 2>> circle_points(int sixth) {
  const double half_root = 0.5 * std::sqrt(3.0);
  const std::array<std::array<double, 2>, 7> corners{{{1.0, 0.0},
                                                      {0.5, half_root},
                                                      {-0.5, half_root},
                                                      {-1.0, 0.0},
                                                      {-0.5, -half_root},
                                                      {0.5, -half_root},
                                                      {1.0, 0.0}}};
  std::vector<std::array<double, 2>> points;
  for (std::size_t side = 0; side < 6; ++side) {
    for (int i = 0; i < sixth; ++i) {
      const double t = static_cast<double>(i) / sixth;
      const double x = (1.0 - t) * corners[side][0] + t * corners[side + 1][0];
      const double y = (1.0 - t) * corners[side][1] + t * corners[side + 1][1];
      const double size = std::sqrt(x * x + y * y);
      points.push_back({x / size, y / size});
    }
  }
  return points;
}

/// `along` and `around` are points of unit circles.
Vec3 ring_point(const std::array<double, 2>& along, const std::array<double, 2>& around) {
  constexpr double kRadius = 40.0;
  constexpr double kTube = 14.0;
  const double tube = kTube * (1.0 + 0.28 * along[0]);
  const double out = kRadius + tube * around[0];
  const double saddle = 8.0 * (along[0] * along[0] - along[1] * along[1]);
  return {out * along[0], out * along[1], tube * around[1] + saddle};
}

}  // namespace

SurfaceMesh build_spleen_surface(int frequency) {
  SurfaceMesh skin = build_geodesic_sphere(frequency);
  for (Vec3& p : skin.points) p = spleen_point(p);
  return skin;
}

SurfaceMesh build_stomach_surface(int frequency) {
  const SurfaceMesh sphere = build_geodesic_sphere(frequency);
  SurfaceMesh skin;
  const Vec3 outer{90.0, 40.0, 40.0};
  const Vec3 inner{66.0, 18.0, 18.0};
  for (const Vec3& p : sphere.points) skin.points.push_back(bent_bag_point(scaled(p, outer)));
  for (const Vec3& p : sphere.points) skin.points.push_back(bent_bag_point(scaled(p, inner)));
  skin.triangles = sphere.triangles;
  const auto first_inner = static_cast<Index>(sphere.points.size());
  for (const Triangle& t : sphere.triangles) {
    skin.triangles.push_back({first_inner + t[0], first_inner + t[2], first_inner + t[1]});
  }
  return skin;
}

SurfaceMesh build_lobes_surface(int frequency) {
  SurfaceMesh skin = build_geodesic_sphere(frequency);
  for (Vec3& p : skin.points) p = lobes_radius(p) * p;
  return skin;
}

SurfaceMesh build_ring_surface(int frequency) {
  if (frequency < 1 || frequency > 1000) {
    throw InputError("frequency of the ring", 0, "a whole number from 1 to 1000", std::to_string(frequency));
  }
  const auto along = circle_points(frequency);
  auto around = circle_points(frequency);
  for (std::size_t i = 0; 2 * i < around.size(); ++i) around[i] = around[2 * i];
  around.resize(around.size() / 2);
  SurfaceMesh skin;
  for (const auto& a : along) {
    for (const auto& b : around) skin.points.push_back(ring_point(a, b));
  }
  const auto columns = static_cast<Index>(around.size());
  const auto rows = static_cast<Index>(along.size());
  for (Index i = 0; i < rows; ++i) {
    for (Index j = 0; j < columns; ++j) {
      const Index a = i * columns + j;
      const Index b = (i + 1) % rows * columns + j;
      const Index c = (i + 1) % rows * columns + (j + 1) % columns;
      const Index d = i * columns + (j + 1) % columns;
      skin.triangles.push_back({a, b, c});
      skin.triangles.push_back({a, c, d});
    }
  }
  return skin;
}

}  // namespace palpate

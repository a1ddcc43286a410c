#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/judge/compensated_sum.h"
#include "core/judge/judge.h"
#include "core/judge/tet_shape.h"
#include "core/judge/vertex_links.h"

namespace palpate::judge {
namespace {

constexpr double kIdealSolidAngle = 0.55;  // thesis 2.3.5; a regular tet has 0.551286 sr
constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

/// What the qualities follow from, one entry a tet.
struct Shapes {
  std::vector<double> shape_factor;  ///< q1 q2; 0 for a tet that is not positive
  std::vector<double> volume;        ///< signed, in units of 2^(3 length exponent)
  std::vector<double> min_dihedral;  ///< radians
  double max_dihedral = 0.0;
};

Shapes measure_shapes(const TetMesh& mesh, int length_exponent) {
  const std::size_t n = mesh.tets.size();
  const std::vector<Vec3>& p = mesh.points;
  Shapes shapes{std::vector<double>(n), std::vector<double>(n), std::vector<double>(n), 0.0};
  for (std::size_t i = 0; i < n; ++i) {
    const Tet& t = mesh.tets[i];
    require(has_valid_indices(t, p.size()), "measure_quality: a tet with invalid indices");
    const TetShape shape = measure_tet(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
    shapes.shape_factor[i] =
        shape.is_positive ? shape.min_solid_angle / kIdealSolidAngle * shape.edge_ratio : 0.0;
    shapes.volume[i] = shape.volume.in_units_of(length_exponent);
    shapes.min_dihedral[i] = shape.min_dihedral;
    shapes.max_dihedral = std::max(shapes.max_dihedral, shape.max_dihedral);
  }
  return shapes;
}

/// q = cbrt(q1 q2 min(1, V / ideal)); 0 if the ideal volume is not positive.
double quality(double shape_factor, double volume, double ideal_volume) {
  if (!(ideal_volume > 0.0) || !(volume > 0.0)) return 0.0;
  return std::cbrt(shape_factor * std::min(1.0, volume / ideal_volume));
}

double percent(std::uint64_t part, std::size_t whole) {
  return 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

/// Nearest rank: the ceil(n / 100)-th smallest. Reorders `values`, which are not empty.
double first_percentile(std::vector<double>& values) {
  const std::size_t rank = (values.size() + 99) / 100;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(rank - 1);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace

Quality measure_quality(const TetMesh& mesh, double ideal_volume) {
  require(std::isfinite(ideal_volume) && ideal_volume >= 0.0, "measure_quality: a bad ideal volume");
  Quality result;
  const std::size_t n = mesh.tets.size();
  if (n == 0) return result;
  const int exponent = length_exponent(mesh.points);
  Shapes shapes = measure_shapes(mesh, exponent);
  CompensatedSum volume;
  for (const double v : shapes.volume) volume.add(v);
  const double own_ideal = volume.value() / static_cast<double>(n);
  result.volume = unscaled_volume(volume.value(), exponent);
  result.ideal_volume = ideal_volume > 0.0 ? ideal_volume : unscaled_volume(own_ideal, exponent);
  const double ideal = ideal_volume > 0.0 ? std::scalbn(ideal_volume, -3 * exponent) : own_ideal;

  CompensatedSum sum;
  result.min_quality = quality(shapes.shape_factor[0], shapes.volume[0], ideal);
  std::uint64_t above_0_5 = 0;
  std::uint64_t above_0_6 = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double q = quality(shapes.shape_factor[i], shapes.volume[i], ideal);
    sum.add(q);
    result.min_quality = std::min(result.min_quality, q);
    ++result.histogram[std::min<std::size_t>(static_cast<std::size_t>(10.0 * q), 9)];
    if (q > 0.5) ++above_0_5;
    if (q > 0.6) ++above_0_6;
  }
  result.mean_quality = sum.value() / static_cast<double>(n);
  result.percent_above_0_5 = percent(above_0_5, n);
  result.percent_above_0_6 = percent(above_0_6, n);
  result.p1_dihedral_deg = kDegreesPerRadian * first_percentile(shapes.min_dihedral);
  result.min_dihedral_deg =
      kDegreesPerRadian * *std::min_element(shapes.min_dihedral.begin(), shapes.min_dihedral.end());
  result.max_dihedral_deg = kDegreesPerRadian * shapes.max_dihedral;
  return result;
}

}  // namespace palpate::judge

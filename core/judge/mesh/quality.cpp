#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/judge/mesh/compensated_sum.h"
#include "core/judge/mesh/judge.h"
#include "core/judge/mesh/tet_shape.h"
#include "core/judge/mesh/vertex_links.h"

namespace palpate::judge {
namespace {

constexpr double kIdealSolidAngle = 0.55;  // thesis 2.3.5; a regular tet has 0.551286 sr
constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

/// What the qualities follow from, one entry a tet.
struct Shapes {
  std::vector<double> shape_factor;  ///< q1 q2; 0 for a tet that is not positive
  std::vector<double> volume;        ///< signed, in units of 2^(3 length exponent)
  std::vector<double> min_dihedral;  ///< radians
  std::vector<double> max_dihedral;  ///< radians
  std::vector<double> mean_ratio;
  std::vector<double> radius_ratio;
  std::vector<double> edge_ratio;  ///< 0 for a tet that is not positive
};

Shapes measure_shapes(const TetMesh& mesh, int length_exponent) {
  const std::size_t n = mesh.tets.size();
  const std::vector<Vec3>& p = mesh.points;
  const std::vector<double> none(n);
  Shapes shapes{none, none, none, none, none, none, none};
  for (std::size_t i = 0; i < n; ++i) {
    const Tet& t = mesh.tets[i];
    require(has_valid_indices(t, p.size()), "measure_quality: a tet with invalid indices");
    const TetShape shape = measure_tet(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
    shapes.shape_factor[i] =
        shape.is_positive ? shape.min_solid_angle / kIdealSolidAngle * shape.edge_ratio : 0.0;
    shapes.volume[i] = shape.volume.in_units_of(length_exponent);
    shapes.min_dihedral[i] = shape.min_dihedral;
    shapes.max_dihedral[i] = shape.max_dihedral;
    shapes.mean_ratio[i] = shape.mean_ratio;
    shapes.radius_ratio[i] = shape.radius_ratio;
    shapes.edge_ratio[i] = shape.is_positive ? shape.edge_ratio : 0.0;
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

/// Nearest rank: the ceil(share n / 100)-th smallest. Reorders `values`, which are not empty.
double percentile(std::vector<double>& values, std::size_t share) {
  const std::size_t rank = (share * values.size() + 99) / 100;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(rank - 1);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// Reorders `values`, which are not empty.
Spread spread_of(std::vector<double>& values) {
  CompensatedSum sum;
  for (const double value : values) sum.add(value);
  return {sum.value() / static_cast<double>(values.size()), percentile(values, 5), percentile(values, 1),
          *std::min_element(values.begin(), values.end())};
}

/// The figures that don't hang on an ideal volume. Reorders the angles and ratios.
void add_angles_and_ratios(Shapes& shapes, Quality& result) {
  const Spread least = spread_of(shapes.min_dihedral);
  result.min_dihedral_deg = kDegreesPerRadian * least.least;
  result.p1_dihedral_deg = kDegreesPerRadian * least.p1;
  result.p5_dihedral_deg = kDegreesPerRadian * least.p5;
  result.max_dihedral_deg =
      kDegreesPerRadian * *std::max_element(shapes.max_dihedral.begin(), shapes.max_dihedral.end());
  result.p99_max_dihedral_deg = kDegreesPerRadian * percentile(shapes.max_dihedral, 99);
  result.p95_max_dihedral_deg = kDegreesPerRadian * percentile(shapes.max_dihedral, 95);
  result.mean_ratio = spread_of(shapes.mean_ratio);
  result.radius_ratio = spread_of(shapes.radius_ratio);
  result.edge_ratio = spread_of(shapes.edge_ratio);
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
  add_angles_and_ratios(shapes, result);
  return result;
}

}  // namespace palpate::judge

#include "core/springs/identification/thesis_rows.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

#include "core/base/error.h"
#include "core/springs/network/network.h"

namespace palpate::springs {
namespace {

constexpr std::size_t kAllRows = kThesisRows + 1;

/// cos and sin of 2 alpha, 4 alpha and beta to 4 beta.
struct Angles {
  double cos2a, sin2a, cos4a, sin4a;
  double cos1b, sin1b, cos2b, sin2b, cos3b, sin3b, cos4b, sin4b;
};

Angles angles_of(const Vec3& e) {
  const double s = std::hypot(e.x, e.y);
  Angles t{};
  t.cos2a = e.z * e.z - s * s;
  t.sin2a = 2.0 * s * e.z;
  t.cos4a = t.cos2a * t.cos2a - t.sin2a * t.sin2a;
  t.sin4a = 2.0 * t.sin2a * t.cos2a;
  t.cos1b = s > 0.0 ? e.x / s : 1.0;
  t.sin1b = s > 0.0 ? e.y / s : 0.0;
  t.cos2b = t.cos1b * t.cos1b - t.sin1b * t.sin1b;
  t.sin2b = 2.0 * t.sin1b * t.cos1b;
  t.cos3b = t.cos2b * t.cos1b - t.sin2b * t.sin1b;
  t.sin3b = t.sin2b * t.cos1b + t.cos2b * t.sin1b;
  t.cos4b = t.cos2b * t.cos2b - t.sin2b * t.sin2b;
  t.sin4b = 2.0 * t.sin2b * t.cos2b;
  return t;
}

/// The 18 rows of both ends of each spring.
struct ThesisSystem {
  std::size_t vertices = 0;
  const std::vector<Edge>* springs = nullptr;
  std::vector<std::array<double, kAllRows>> at_first;   ///< rows of the spring's first vertex
  std::vector<std::array<double, kAllRows>> at_second;  ///< of its second, seen from there

  void apply(std::span<const double> x, std::span<double> y) const {
    std::fill(y.begin(), y.end(), 0.0);
    for (std::size_t s = 0; s < springs->size(); ++s) {
      double* first = y.data() + kAllRows * (*springs)[s][0];
      double* second = y.data() + kAllRows * (*springs)[s][1];
      for (std::size_t r = 0; r < kAllRows; ++r) {
        first[r] += at_first[s][r] * x[s];
        second[r] += at_second[s][r] * x[s];
      }
    }
  }
  void apply_transposed(std::span<const double> y, std::span<double> x) const {
    for (std::size_t s = 0; s < springs->size(); ++s) {
      const double* first = y.data() + kAllRows * (*springs)[s][0];
      const double* second = y.data() + kAllRows * (*springs)[s][1];
      double sum = 0.0;
      for (std::size_t r = 0; r < kAllRows; ++r)
        sum += at_first[s][r] * first[r] + at_second[s][r] * second[r];
      x[s] = sum;
    }
  }
};

std::array<double, kAllRows> all_rows(const Vec3& direction, const ThesisOptions& options) {
  const std::array<double, kThesisRows> rows = thesis_row_coefficients(direction, options.rows);
  std::array<double, kAllRows> all{};
  std::copy(rows.begin(), rows.end(), all.begin());
  all[kThesisRows] = options.stiffness_row_weight;
  return all;
}

ThesisSystem build_system(const TetMesh& mesh, const SpringNetwork& network, const ThesisOptions& options) {
  ThesisSystem system;
  system.vertices = mesh.points.size();
  system.springs = &network.springs;
  system.at_first.reserve(network.springs.size());
  system.at_second.reserve(network.springs.size());
  for (const Vec3& e : build_spring_directions(mesh, network)) {
    system.at_first.push_back(all_rows(e, options));
    system.at_second.push_back(all_rows(-1.0 * e, options));
  }
  return system;
}

LinearMap map_of(const ThesisSystem& system) {
  LinearMap map;
  map.rows = kAllRows * system.vertices;
  map.columns = system.springs->size();
  map.apply = [&system](std::span<const double> x, std::span<double> y) { system.apply(x, y); };
  map.apply_transposed = [&system](std::span<const double> y, std::span<double> x) {
    system.apply_transposed(y, x);
  };
  map.column_norms_sq.resize(map.columns);
  for (std::size_t s = 0; s < map.columns; ++s) {
    map.column_norms_sq[s] = std::inner_product(system.at_first[s].begin(), system.at_first[s].end(),
                                                system.at_first[s].begin(), 0.0) +
                             std::inner_product(system.at_second[s].begin(), system.at_second[s].end(),
                                                system.at_second[s].begin(), 0.0);
  }
  return map;
}

/// Puts B.18 - B.23, as printed, in the place of B.1 and B.4 - B.8.
void substitute(const Angles& t, std::array<double, kThesisRows>& row) {
  row[0] = 25.0 + 84.0 * t.cos2a - 45.0 * t.cos4a;
  row[3] = 21.0 + 68.0 * t.cos2a - 25.0 * t.cos4a;
  row[4] = 5.0 * t.sin4a * t.sin2b - 26.0 * t.sin2a * t.sin1b;
  row[5] = 5.0 * t.sin4a * t.cos2b - 26.0 * t.sin2a * t.cos1b;
  row[6] = (9.0 - 4.0 * t.cos2a - 5.0 * t.cos4a) * t.cos2b;
  row[7] = (9.0 - 4.0 * t.cos2a - 5.0 * t.cos4a) * t.sin2b;
}

}  // namespace

std::array<double, kThesisRows> thesis_row_coefficients(const Vec3& direction, ThesisRows rows,
                                                        double lambda1) {
  require(rows != ThesisRows::kSubstituted || lambda1 == kThesisLambda1,
          "thesis_row_coefficients: B.18 - B.23 are for lambda1 = -1/4");
  const Angles t = angles_of(direction);
  const bool printed = rows != ThesisRows::kCorrected;
  const double l = lambda1;
  const double b2 = (20.0 * l - 4.0) * t.cos2a + (1.0 - 17.0 * l) + 3.0 * (1.0 - l) * t.cos4a;
  const double b3_printed =
      (20.0 * l - 4.0) * t.sin2a * t.cos2b + (1.0 - 17.0 * l) * t.cos2b + 3.0 * (1.0 - l) * t.cos4a * t.sin2b;
  const double b4_sign = rows == ThesisRows::kPrinted ? 1.0 : -1.0;
  const double b5 = (18.0 * l - 2.0) * t.sin2a;
  const double b5_fine = (1.0 - l) * t.sin4a;
  const double b7 = (5.0 * l - 1.0) - 4.0 * l * t.cos2a + (1.0 - l) * t.cos4a;
  const double b9 = 9.0 - 12.0 * t.cos2a + 3.0 * t.cos4a;
  const double b14 = 2.0 * t.sin2a + (printed ? -7.0 : 7.0) * t.sin4a;
  const double b16 = 3.0 + 4.0 * t.cos2a - 7.0 * t.cos4a;
  std::array<double, kThesisRows> row{
      69.0 + 251.0 * l + (4.0 - 68.0 * l) * t.cos2a + 9.0 * (l - 1.0) * t.cos4a,
      b2 * t.cos2b,
      printed ? b3_printed : b2 * t.sin2b,
      (1.0 - 17.0 * l) + (4.0 - 52.0 * l) * t.cos2a + b4_sign * 5.0 * (1.0 - l) * t.cos4a,
      b5 * t.sin1b + b5_fine * (printed ? t.sin2b : t.sin1b),
      b5 * t.cos1b + b5_fine * (printed ? t.cos2b : t.cos1b),
      b7 * t.cos2b,
      b7 * t.sin2b,
      b9 * t.cos4b,
      b9 * t.sin4b,
      2.0 * t.sin2a * t.sin3b - t.sin4a * (printed ? t.sin4b : t.sin3b),
      2.0 * t.sin2a * t.cos3b - t.sin4a * (printed ? t.cos4b : t.cos3b),
      35.0 * t.cos4a + 20.0 * t.cos2a + 9.0,
      b14 * t.sin1b,
      b14 * t.cos1b,
      b16 * t.cos2b,
      b16 * t.sin2b};
  if (rows == ThesisRows::kSubstituted) substitute(t, row);
  return row;
}

namespace {

/// Mean over the springs of the squared length of their columns in the 17 rows.
double mean_column_length_sq(const LinearMap& map, double stiffness_row_weight) {
  const double sum = std::accumulate(map.column_norms_sq.begin(), map.column_norms_sq.end(), 0.0);
  return sum / static_cast<double>(map.columns) - 2.0 * stiffness_row_weight * stiffness_row_weight;
}

}  // namespace

NonnegativeReport identify_thesis(const TetMesh& mesh, double young_modulus_pa, const ThesisOptions& options,
                                  SpringNetwork& network) {
  require(young_modulus_pa > 0.0, "identify_thesis: the modulus must be positive");
  require(options.stiffness_row_weight > 0.0, "identify_thesis: the row weight must be positive");
  require(options.ridge_relative >= 0.0, "identify_thesis: the ridge must not be negative");
  const std::vector<double> volumes = build_influence_volumes(mesh);
  const double mean =
      std::accumulate(volumes.begin(), volumes.end(), 0.0) / static_cast<double>(volumes.size());
  const ThesisSystem system = build_system(mesh, network, options);
  std::vector<double> rhs(kAllRows * volumes.size(), 0.0);
  for (std::size_t v = 0; v < volumes.size(); ++v)
    rhs[kAllRows * v + kThesisRows] = options.stiffness_row_weight * 12.0 * volumes[v] / mean;
  std::vector<double> x(network.springs.size(), 0.0);
  const LinearMap map = map_of(system);
  NonnegativeOptions solve = options.solve;
  if (options.ridge_relative > 0.0)
    solve.ridge += options.ridge_relative * mean_column_length_sq(map, options.stiffness_row_weight);
  const NonnegativeReport report = solve_nonnegative(map, rhs, x, solve);
  for (std::size_t s = 0; s < x.size(); ++s) {
    const double u = network.rest_length_m[s];
    network.stiffness_n_per_m[s] = x[s] * young_modulus_pa * mean / (u * u);
  }
  return report;
}

}  // namespace palpate::springs

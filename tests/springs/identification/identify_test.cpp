#include "core/springs/identification/identify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/springs/identification/isotropy_rows.h"
#include "core/springs/network/network.h"
#include "tests/support/lattices.h"
#include "tests/support/small_meshes.h"

namespace palpate::springs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr Material kMaterial{10000.0, 0.25, 1000.0};

/// Turned about z, x and z again by unequal angles.
TetMesh rotated(TetMesh mesh) {
  const auto turn = [](double& a, double& b, double angle) {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const double old = a;
    a = c * old - s * b;
    b = s * old + c * b;
  };
  for (Vec3& p : mesh.points) {
    turn(p.x, p.y, 0.7);
    turn(p.y, p.z, 1.1);
    turn(p.x, p.y, -0.4);
  }
  return mesh;
}

/// |k - l| / |k| in the 2-norm.
double relative_change(const SpringNetwork& a, const SpringNetwork& b) {
  double difference = 0.0;
  double size = 0.0;
  for (std::size_t s = 0; s < a.springs.size(); ++s) {
    difference += std::pow(a.stiffness_n_per_m[s] - b.stiffness_n_per_m[s], 2);
    size += std::pow(a.stiffness_n_per_m[s], 2);
  }
  return std::sqrt(difference / size);
}

double change_by_rotation(SpringMethod method, const IdentifyOptions& options = {}) {
  const TetMesh mesh = build_kuhn_cube(4, 0.3, 12);
  IdentifyReport report;
  const SpringNetwork still = identify_springs(mesh, kMaterial, method, options, report);
  const SpringNetwork turned = identify_springs(rotated(mesh), kMaterial, method, options, report);
  return relative_change(still, turned);
}

TEST(Identify, RotatingTheMeshChangesNothingButTheThesisRows) {
  IdentifyOptions tight;
  tight.tolerance = 1e-13;
  for (const std::string& name : spring_method_names()) {
    const SpringMethod method = parse_spring_method(name);
    if (name.rfind("thesis", 0) == 0) continue;
    EXPECT_LT(change_by_rotation(method, tight), 1e-12) << name;
  }
  for (const double weight : {1.0, 10.0}) {
    tight.stiffness_row_weight = weight;
    EXPECT_GT(change_by_rotation(SpringMethod::kThesisCorrected, tight), 0.2) << weight;
    EXPECT_GT(change_by_rotation(SpringMethod::kThesisPrinted, tight), 0.2) << weight;
  }
}

TEST(Identify, SameBytesEachTime) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 2);
  for (const std::string& name : spring_method_names()) {
    IdentifyReport report;
    const SpringMethod method = parse_spring_method(name);
    EXPECT_EQ(spring_method_name(method), name);
    EXPECT_EQ(identify_springs(mesh, kMaterial, method, {}, report),
              identify_springs(mesh, kMaterial, method, {}, report));
    EXPECT_EQ(report.method, method);
    EXPECT_TRUE(report.converged) << name;
    EXPECT_LE(report.kkt_relative, 1e-10) << name;
  }
}

/// Components of the mean elastic tensor around a vertex, 1/(2 V) sum of k U^2 e(x)e(x)e(x)e over its springs
/// (each is shared by two vertices), and its master sum.
struct Tensor {
  double xxxx = 0.0;
  double yyyy = 0.0;
  double xxyy = 0.0;
  double xyxy = 0.0;
  double xxxy = 0.0;
  double sum = 0.0;  ///< sum of k U^2 / (2 V)
};

Tensor tensor_at(const LatticeNetwork& lattice, Index vertex, double volume) {
  Tensor c;
  for (std::size_t s = 0; s < lattice.network.springs.size(); ++s) {
    const auto [a, b] = lattice.network.springs[s];
    if (a != vertex && b != vertex) continue;
    const Vec3 d = lattice.points[b] - lattice.points[a];
    const double w = lattice.network.stiffness_n_per_m[s] * length_sq(d) / (2.0 * volume);
    const Vec3 e = (1.0 / length(d)) * d;
    c.xxxx += w * e.x * e.x * e.x * e.x;
    c.yyyy += w * e.y * e.y * e.y * e.y;
    c.xxyy += w * e.x * e.x * e.y * e.y;
    c.xyxy += w * e.x * e.y * e.x * e.y;
    c.xxxy += w * e.x * e.x * e.x * e.y;
    c.sum += w;
  }
  return c;
}

TEST(Identify, MasterIdentityOfAnIsotropicNetwork) {
  // lambda = mu = sum k l^2 / (15 V), and sum k l^2 = 6 E V: so lambda = mu = 0.4 E, Poisson's ratio 1/4.
  const double young = 5000.0;
  const double h = 0.01;
  const LatticeBlock block{{3, 3, 3}, h, young};
  const std::vector<Tensor> tensors{tensor_at(build_bcc_network(block), 21, 0.5 * h * h * h),
                                    tensor_at(build_hexahedral_network(block, 0.0), 21, h * h * h),
                                    tensor_at(build_hexahedral_network(block, 0.5), 21, h * h * h)};
  for (const Tensor& c : tensors) {
    EXPECT_NEAR(c.sum / (6.0 * young), 1.0, 1e-13);
    EXPECT_NEAR(c.xxyy / (c.sum / 15.0), 1.0, 1e-13);            // lambda
    EXPECT_NEAR(c.xyxy / (c.sum / 15.0), 1.0, 1e-13);            // mu
    EXPECT_NEAR(c.xxxx, c.xxyy + 2.0 * c.xyxy, 1e-12 * c.xxxx);  // lambda + 2 mu
    EXPECT_NEAR(c.yyyy, c.xxxx, 1e-12 * c.xxxx);
    EXPECT_NEAR(c.xxxy, 0.0, 1e-12 * c.xxxx);
    const double e = c.xyxy * (3.0 * c.xxyy + 2.0 * c.xyxy) / (c.xxyy + c.xyxy);
    const double nu = 0.5 * c.xxyy / (c.xxyy + c.xyxy);
    EXPECT_NEAR(e / young, 1.0, 1e-13);
    EXPECT_NEAR(nu, 0.25, 1e-13);
  }
}

TEST(Identify, InUniformDilationTheMasterIdentityIsTheEnergyOfTheSolid) {
  // 1/2 sum k (U e)^2 = 1/2 9 K V e^2 with K = E / 1.5: sum k U^2 = 6 E V, whatever the directions are.
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 5);
  const double bulk = kMaterial.lambda_pa() + 2.0 / 3.0 * kMaterial.mu_pa();
  for (const SpringMethod method : {SpringMethod::kUniform, SpringMethod::kVanGelder}) {
    IdentifyReport report;
    const SpringNetwork network = identify_springs(mesh, kMaterial, method, {}, report);
    double energy = 0.0;
    for (std::size_t s = 0; s < network.springs.size(); ++s)
      energy += 0.5 * network.stiffness_n_per_m[s] * std::pow(1e-3 * network.rest_length_m[s], 2);
    EXPECT_NEAR(energy / (0.5 * 9.0 * bulk * total_volume(mesh) * 1e-6), 1.0, 1e-12);
  }
}

/// The springs of the BCC lattice with period n, seen from each of its 2 n^3 vertices: all of it is inside.
struct PeriodicBcc {
  struct End {
    Index vertex;
    Index spring;
    Vec3 direction;
    double rest_length;
  };
  Index vertices = 0;
  Index springs = 0;
  std::vector<End> ends;
};

PeriodicBcc build_periodic_bcc(int n, double h) {
  PeriodicBcc lattice;
  lattice.vertices = static_cast<Index>(2 * n * n * n);
  const auto number = [&](int i, int j, int l, int kind) {
    const auto wrap = [&](int x) { return (x + n) % n; };
    return static_cast<Index>(2 * (wrap(i) + n * (wrap(j) + n * wrap(l))) + kind);
  };
  const auto add = [&](Index a, Index b, const Vec3& d) {
    const double u = length(d);
    lattice.ends.push_back({a, lattice.springs, (1.0 / u) * d, u});
    lattice.ends.push_back({b, lattice.springs, (-1.0 / u) * d, u});
    ++lattice.springs;
  };
  for (int cell = 0; cell < n * n * n; ++cell) {
    const int i = cell % n;
    const int j = cell / n % n;
    const int l = cell / n / n;
    for (const int kind : {0, 1}) {
      add(number(i, j, l, kind), number(i + 1, j, l, kind), {h, 0, 0});
      add(number(i, j, l, kind), number(i, j + 1, l, kind), {0, h, 0});
      add(number(i, j, l, kind), number(i, j, l + 1, kind), {0, 0, h});
    }
    for (int corner = 0; corner < 8; ++corner) {
      const int x = corner & 1;
      const int y = (corner >> 1) & 1;
      const int z = corner >> 2;
      add(number(i, j, l, 1), number(i + x, j + y, l + z, 0), {h * (x - 0.5), h * (y - 0.5), h * (z - 0.5)});
    }
  }
  return lattice;
}

/// Stiffness of each spring by the isotropy rows, and the patch rows if asked, from a start at zero.
std::vector<double> solve_periodic_bcc(const PeriodicBcc& lattice, double h, double young, bool patch) {
  const std::size_t rows = kIsotropyRows + (patch ? kPatchRows : 0);
  std::vector<std::vector<double>> columns;  // of each end, in k h^2
  for (const PeriodicBcc::End& end : lattice.ends) {
    const double u = end.rest_length / h;
    std::vector<double> column;
    for (const double value : isotropy_coefficients(end.direction)) column.push_back(u * u * value);
    if (patch) {
      for (const double value : patch_coefficients(end.direction)) column.push_back(u * value);
    }
    columns.push_back(column);
  }
  LinearMap map;
  map.rows = rows * lattice.vertices;
  map.columns = lattice.springs;
  map.apply = [&](std::span<const double> x, std::span<double> y) {
    std::fill(y.begin(), y.end(), 0.0);
    for (std::size_t e = 0; e < columns.size(); ++e) {
      for (std::size_t r = 0; r < rows; ++r)
        y[rows * lattice.ends[e].vertex + r] += columns[e][r] * x[lattice.ends[e].spring];
    }
  };
  map.apply_transposed = [&](std::span<const double> y, std::span<double> x) {
    std::fill(x.begin(), x.end(), 0.0);
    for (std::size_t e = 0; e < columns.size(); ++e) {
      for (std::size_t r = 0; r < rows; ++r)
        x[lattice.ends[e].spring] += columns[e][r] * y[rows * lattice.ends[e].vertex + r];
    }
  };
  map.column_norms_sq.assign(map.columns, 0.0);
  for (std::size_t e = 0; e < columns.size(); ++e) {
    for (const double value : columns[e]) map.column_norms_sq[lattice.ends[e].spring] += value * value;
  }
  const double target = 12.0 * young * 0.5 * h;  // 12 E V / h^2, V = h^3 / 2
  std::vector<double> rhs(map.rows, 0.0);
  for (std::size_t v = 0; v < lattice.vertices; ++v) {
    for (std::size_t r = 0; r < kIsotropyRows; ++r) rhs[rows * v + r] = target * isotropy_means()[r];
  }
  std::vector<double> k(map.columns, 0.0);
  NonnegativeOptions options;
  options.tolerance = 1e-13;
  EXPECT_TRUE(solve_nonnegative(map, rhs, k, options).converged);
  return k;
}

TEST(Identify, BccConstantsComeOutInsideTheLattice) {
  const double h = 0.25;
  const double young = 8.0;
  const PeriodicBcc lattice = build_periodic_bcc(3, h);
  for (const bool patch : {false, true}) {
    const std::vector<double> k = solve_periodic_bcc(lattice, h, young, patch);
    for (const PeriodicBcc::End& end : lattice.ends) {
      const double expected = (end.rest_length < 0.95 * h ? 0.6 : 0.4) * young * h;
      EXPECT_NEAR(k[end.spring] / expected, 1.0, 1e-10) << patch;
    }
  }
}

/// Largest relative deviation from 0.6 E h and 0.4 E h over springs at least `depth` from the bar's surface.
double bcc_deviation(int cells, double depth, SpringMethod method) {
  const TetMesh mesh = build_bcc_bar(cells);
  const double h = 1.0 / cells;
  IdentifyReport report;
  const SpringNetwork network = identify_springs(mesh, {1.0, 0.25, 0.0}, method, {}, report);
  const auto distance = [](const Vec3& p) { return std::min({p.x, 4 - p.x, p.y, 1 - p.y, p.z, 1 - p.z}); };
  double worst = 0.0;
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    const auto [a, b] = network.springs[s];
    if (std::min(distance(mesh.points[a]), distance(mesh.points[b])) < depth - 1e-9) continue;
    const double expected = (network.rest_length_m[s] < 0.95 * h ? 0.6 : 0.4) * h;
    worst = std::max(worst, std::abs(network.stiffness_n_per_m[s] / expected - 1.0));
  }
  return worst;
}

TEST(Identify, TheSurfaceOfABccBarIsFeltLessAndLessInside) {
  // The surface's rows cannot all be met; what that does to the constants dies away by half and more a half
  // cell.
  double last = 1.0;
  for (const double half_cells : {1.0, 2.0, 3.0, 4.0}) {
    const double deviation = bcc_deviation(4, 0.125 * half_cells, SpringMethod::kIsotropyPatch);
    EXPECT_LT(deviation, 0.5 * last) << half_cells;
    last = deviation;
  }
}

TEST(Identify, TheThesisWeightsMakeTheNetworkTooSoft) {
  // The homogeneous rows have coefficients up to 35, the stiffness row has 1.
  const TetMesh mesh = build_kuhn_cube(5, 0.3, 3);
  IdentifyOptions options;
  IdentifyReport report;
  identify_springs(mesh, kMaterial, SpringMethod::kThesisCorrected, options, report);
  EXPECT_LT(report.stiffness_ratio_mean, 0.5);
  EXPECT_THAT(report.warnings, testing::Contains(HasSubstr("times as stiff as the solid")));
  options.stiffness_row_weight = 100.0;
  identify_springs(mesh, kMaterial, SpringMethod::kThesisCorrected, options, report);
  EXPECT_NEAR(report.stiffness_ratio_mean, 1.0, 0.05);
}

TEST(Identify, WarnsOfARatioThatSpringsCannotHave) {
  IdentifyReport report;
  identify_springs(build_bar(1), {10000.0, 0.45, 0.0}, SpringMethod::kVanGelder, {}, report);
  EXPECT_THAT(
      report.warnings,
      ElementsAre("springs alone give Poisson's ratio 0.25, not 0.45; with a volume model for the rest, "
                  "identify for E = 2.5 mu = 8621 Pa and 0.25"));
  identify_springs(build_bar(1), kMaterial, SpringMethod::kVanGelder, {}, report);
  EXPECT_THAT(report.warnings, testing::Not(testing::Contains(HasSubstr("Poisson"))));
}

TEST(Identify, DegenerateVerticesAreNamedAndTheConstantsFinite) {
  // One tet alone, and a cube whose corner tets end in vertices of one tet.
  for (const TetMesh& mesh : {testing_support::make_corner_tet(), testing_support::make_two_tets()}) {
    for (const std::string& name : spring_method_names()) {
      IdentifyReport report;
      const SpringNetwork network = identify_springs(mesh, kMaterial, parse_spring_method(name), {}, report);
      for (const double k : network.stiffness_n_per_m) {
        EXPECT_TRUE(std::isfinite(k)) << name;
        EXPECT_GE(k, 0.0) << name;
      }
      const std::size_t degenerate = mesh.tets.size() == 1 ? 4 : 2;
      EXPECT_EQ(report.degenerate_vertices.size(), degenerate);
      EXPECT_THAT(report.warnings, testing::Contains(HasSubstr(std::to_string(degenerate) +
                                                               " vertices rest on too few directions")));
      EXPECT_THAT(report.warnings,
                  testing::Contains(HasSubstr(": " + std::to_string(report.degenerate_vertices[0]) + ", " +
                                              std::to_string(report.degenerate_vertices[1]))));
    }
  }
}

void expect_refusal(const Material& material, const std::string& message) {
  IdentifyReport report;
  try {
    identify_springs(build_bar(1), material, SpringMethod::kUniform, {}, report);
    FAIL() << "accepted: " << message;
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(), message);
  }
}

TEST(Identify, MaterialsOutOfRangeAreRefused) {
  expect_refusal({0.0, 0.25, 0.0}, "young_modulus_pa: expected a finite number above 0, found 0");
  expect_refusal({-3.5, 0.25, 0.0}, "young_modulus_pa: expected a finite number above 0, found -3.5");
  const double infinity = std::numeric_limits<double>::infinity();
  expect_refusal({infinity, 0.25, 0.0}, "young_modulus_pa: expected a finite number above 0, found inf");
  expect_refusal({1.0, 0.5, 0.0}, "poisson_ratio: expected a number above -1 and below 0.5, found 0.5");
  expect_refusal({1.0, -1.0, 0.0}, "poisson_ratio: expected a number above -1 and below 0.5, found -1");
  expect_refusal({1.0, std::nan(""), 0.0},
                 "poisson_ratio: expected a number above -1 and below 0.5, found nan");
  expect_refusal({1.0, 0.25, -1.0}, "density_kg_m3: expected a finite number of at least 0, found -1");
}

TEST(Identify, OptionsOutOfRangeAreRefused) {
  const auto refuse = [](SpringMethod method, IdentifyOptions options) {
    IdentifyReport report;
    EXPECT_THROW(identify_springs(build_bar(1), kMaterial, method, options, report), InputError);
  };
  refuse(SpringMethod::kUniform, {.uniform_stiffness_n_per_m = 0.0});
  refuse(SpringMethod::kThesisPrinted, {.stiffness_row_weight = -1.0});
  refuse(SpringMethod::kIsotropyPatch, {.patch_length = 0.0});
  refuse(SpringMethod::kIsotropy, {.tolerance = std::nan("")});
  EXPECT_THROW(parse_spring_method("isotropic"), InputError);
}

TEST(Identify, AMeshThatBreaksTheContractIsAFaultOfTheCaller) {
  IdentifyReport report;
  TetMesh lonely = build_bar(1);
  lonely.points.push_back({9, 9, 9});
  EXPECT_THROW(identify_springs(lonely, kMaterial, SpringMethod::kUniform, {}, report), ContractError);
  EXPECT_THROW(identify_springs({}, kMaterial, SpringMethod::kUniform, {}, report), ContractError);
}

}  // namespace
}  // namespace palpate::springs

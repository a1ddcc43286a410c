#include "core/springs/identification/isotropy_rows.h"
#include "core/springs/identification/isotropy_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "core/springs/identification/isotropy_system.h"
#include "tests/support/dense_nonnegative.h"
#include "tests/support/small_meshes.h"

namespace {

using namespace palpate;
using namespace palpate::springs;
using palpate::springs::testing_support::DenseMatrix;

Vec3 random_direction(SplitMix64& random) {
  while (true) {
    const Vec3 v{2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0};
    const double size = length(v);
    if (size > 0.1 && size <= 1.0) return (1.0 / size) * v;
  }
}

template <std::size_t N>
double inner(const std::array<double, N>& a, const std::array<double, N>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < N; ++i) sum += a[i] * b[i];
  return sum;
}

SpringNetwork edge_network(const TetMesh& mesh) {
  SpringNetwork network;
  network.springs = build_edges(mesh);
  for (const auto& [a, b] : network.springs)
    network.rest_length_m.push_back(length(mesh.points[a] - mesh.points[b]));
  network.stiffness_n_per_m.assign(network.springs.size(), 0.0);
  return network;
}

TetMesh scaled(TetMesh mesh, double factor) {
  for (Vec3& point : mesh.points) point = factor * point;
  return mesh;
}

SpringNetwork identified(const TetMesh& mesh, double young, bool patch, IsotropyReport* report = nullptr) {
  SpringNetwork network = edge_network(mesh);
  IsotropyOptions options;
  options.patch = patch;
  const IsotropyReport own = identify_isotropy(mesh, young, options, network);
  if (report != nullptr) *report = own;
  return network;
}

double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

/// The rows as a dense matrix, column by column from their action.
DenseMatrix dense_rows(const IsotropySystem& system) {
  DenseMatrix matrix{system.target.size(), system.springs, {}};
  matrix.entry.resize(matrix.rows * matrix.columns);
  std::vector<double> unit(system.springs, 0.0);
  std::vector<double> image(matrix.rows);
  for (std::size_t c = 0; c < matrix.columns; ++c) {
    unit[c] = 1.0;
    apply_isotropy_rows(system, unit, image);
    unit[c] = 0.0;
    for (std::size_t r = 0; r < matrix.rows; ++r) matrix.entry[r * matrix.columns + c] = image[r];
  }
  return matrix;
}

TEST(IsotropyRows, InnerProductsArePowersOfTheCosine) {
  SplitMix64 random(1);
  for (int i = 0; i < 100; ++i) {
    const Vec3 e = random_direction(random);
    const Vec3 f = random_direction(random);
    const double c = dot(e, f);
    EXPECT_NEAR(inner(isotropy_coefficients(e), isotropy_coefficients(f)), c * c * c * c, 1e-14);
    EXPECT_NEAR(inner(patch_coefficients(e), patch_coefficients(f)), c * c * c, 1e-14);
    EXPECT_NEAR(inner(isotropy_coefficients(e), isotropy_means()), 0.2, 1e-15);
    const Vec3 area{random.uniform(), -random.uniform(), random.uniform()};
    EXPECT_NEAR(inner(patch_coefficients(e), patch_target(area)), 3.0 * dot(e, area), 1e-14);
  }
}

TEST(IsotropyRows, MeansAreThoseOfTheIcosahedron) {
  // Its 12 corners are a spherical 5-design: they average polynomials of degree 4 as the sphere does.
  const SurfaceMesh icosahedron = build_geodesic_sphere(1);
  ASSERT_EQ(icosahedron.points.size(), 12U);
  std::array<double, kIsotropyRows> mean{};
  for (const Vec3& corner : icosahedron.points) {
    const auto rows = isotropy_coefficients((1.0 / length(corner)) * corner);
    for (std::size_t r = 0; r < rows.size(); ++r) mean[r] += rows[r] / 12.0;
  }
  const auto expected = isotropy_means();
  for (std::size_t r = 0; r < mean.size(); ++r) EXPECT_NEAR(mean[r], expected[r], 1e-15) << "row " << r;
}

TEST(IsotropyRows, ActionsAreThoseOfOneMatrix) {
  const TetMesh mesh = scaled(build_kuhn_cube(2, 0.3, 3), 0.01);
  const SpringNetwork network = edge_network(mesh);
  for (const bool patch : {false, true}) {
    IsotropyOptions options;
    options.patch = patch;
    options.patch_length = 0.7;
    const IsotropySystem system = build_isotropy_system(mesh, network, 1e4, options);
    const DenseMatrix matrix = dense_rows(system);
    const NormalEquations equations = isotropy_normal_equations(system);
    SplitMix64 random(4);
    std::vector<double> w(system.springs);
    for (double& value : w) value = random.uniform();
    std::vector<double> image(system.target.size());
    std::vector<double> y(system.springs);
    std::vector<double> back(system.springs);
    apply_isotropy_rows(system, w, image);
    apply_isotropy_rows_transposed(system, image, back);
    equations.apply(w, y);
    std::vector<float> w_single(w.begin(), w.end());
    std::vector<float> y_single(system.springs);
    equations.apply_single(w_single, y_single);
    for (std::size_t c = 0; c < system.springs; ++c) {
      double product = 0.0;
      double linear = 0.0;
      double diagonal = 0.0;
      for (std::size_t r = 0; r < matrix.rows; ++r) {
        product += matrix.at(r, c) * image[r];
        linear += matrix.at(r, c) * system.target[r];
        diagonal += matrix.at(r, c) * matrix.at(r, c);
      }
      EXPECT_NEAR(back[c], product, 1e-12);
      EXPECT_NEAR(y[c], product, 1e-12);
      EXPECT_NEAR(y_single[c], product, 1e-4);
      EXPECT_NEAR(equations.linear[c], linear, 1e-14);
      EXPECT_NEAR(equations.diagonal[c], diagonal, 1e-13);
    }
  }
}

TEST(IsotropyRows, RightHandSideInClosedForm) {
  // A^T b = 12/5 E (V_a + V_b) by the isotropy rows alone.
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 9);
  const SpringNetwork network = edge_network(mesh);
  const NormalEquations equations =
      isotropy_normal_equations(build_isotropy_system(mesh, network, 3.0, IsotropyOptions{}));
  std::vector<double> volume(mesh.points.size(), 0.0);
  for (const auto& [a, b, c, d] : mesh.tets)
    for (const Index v : {a, b, c, d})
      volume[v] += signed_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]) / 4.0;
  for (std::size_t s = 0; s < network.springs.size(); ++s)
    EXPECT_NEAR(equations.linear[s],
                2.4 * 3.0 * (volume[network.springs[s][0]] + volume[network.springs[s][1]]), 1e-13);
}

TEST(IsotropyRows, BccConstantsMeetAllRowsInside) {
  // Spacing h: 0.6 E h on half diagonals, 0.4 E h on axes.
  const TetMesh mesh = build_bcc_bar(3);
  const double h = 1.0 / 3.0;
  const double young = 7.0;
  const SpringNetwork network = edge_network(mesh);
  IsotropyOptions options;
  options.patch = true;
  const IsotropySystem system = build_isotropy_system(mesh, network, young, options);
  std::vector<double> w(network.springs.size());
  for (std::size_t s = 0; s < w.size(); ++s) {
    const double u = network.rest_length_m[s];
    w[s] = (std::abs(u - h) < 1e-9 ? 0.4 : 0.6) * young * h * u * u;
  }
  std::vector<double> rows(system.target.size());
  apply_isotropy_rows(system, w, rows);
  int inside = 0;
  for (std::size_t place = 0; place < system.vertex.size(); ++place) {
    const Vec3 p = mesh.points[system.vertex[place]];
    const double low = std::min({p.x, p.y, p.z});
    const double high = std::max({p.x - 3.0, p.y, p.z});
    if (low < 0.99 * h || high > 1.0 - 0.99 * h) continue;
    ++inside;
    for (std::size_t r = 0; r < 25; ++r)
      EXPECT_NEAR(rows[25 * place + r], system.target[25 * place + r], 1e-13) << "row " << r;
  }
  EXPECT_GT(inside, 10);
}

TEST(IdentifyIsotropy, IsTheMinimumThatActiveSetsFind) {
  for (const bool patch : {false, true}) {
    TetMesh mesh = build_kuhn_cube(2, 0.35, 21);
    for (Vec3& point : mesh.points) point.z *= 0.3;
    IsotropyReport report;
    const SpringNetwork network = identified(mesh, 5.0, patch, &report);
    EXPECT_TRUE(report.solve.converged);
    IsotropyOptions options;
    options.patch = patch;
    const IsotropySystem system = build_isotropy_system(mesh, network, 5.0, options);
    const DenseMatrix matrix = dense_rows(system);
    const std::vector<double> truth =
        palpate::springs::testing_support::minimum_by_active_sets(matrix, system.target);
    std::vector<double> w(truth.size());
    for (std::size_t s = 0; s < w.size(); ++s)
      w[s] = network.stiffness_n_per_m[s] * network.rest_length_m[s] * network.rest_length_m[s];
    EXPECT_LE(palpate::springs::testing_support::dense_kkt(matrix, system.target, w), 1.01e-10);
    for (std::size_t s = 0; s < w.size(); ++s) EXPECT_NEAR(w[s], truth[s], 1e-8 * largest(truth));
    double norm = 0.0;
    for (const double value : system.target) norm += value * value;
    EXPECT_NEAR(report.residual_relative,
                std::sqrt(palpate::springs::testing_support::objective(matrix, system.target, w) / norm),
                1e-12);
    if (!patch) {
      EXPECT_GT(report.solve.zeros, 0U);  // the bound matters
    }
  }
}

TEST(IdentifyIsotropy, TurningTheMeshChangesNothing) {
  const TetMesh mesh = build_kuhn_cube(4, 0.4, 5);
  const double c = std::cos(1.0);
  const double s = std::sin(1.0);
  TetMesh turned = mesh;
  for (Vec3& p : turned.points) {
    const Vec3 once{c * p.x - s * p.y, s * p.x + c * p.y, p.z};
    p = {once.x + 3.0, c * once.y - s * once.z - 1.0, s * once.y + c * once.z};
  }
  for (const bool patch : {false, true}) {
    // Solved to rounding: at 1e-10 two answers may differ by as much.
    IsotropyOptions options;
    options.patch = patch;
    options.solve.tolerance = 2e-15;
    options.solve.max_iterations = 60;
    SpringNetwork first = edge_network(mesh);
    SpringNetwork second = edge_network(turned);
    EXPECT_LT(identify_isotropy(mesh, 1e4, options, first).solve.kkt_relative, 1e-14);
    EXPECT_LT(identify_isotropy(turned, 1e4, options, second).solve.kkt_relative, 1e-14);
    double difference = 0.0;
    for (std::size_t i = 0; i < first.springs.size(); ++i)
      difference = std::max(difference, std::abs(first.stiffness_n_per_m[i] - second.stiffness_n_per_m[i]));
    EXPECT_LT(difference, 1e-12 * largest(first.stiffness_n_per_m)) << "patch " << patch;
  }
}

TEST(IdentifyIsotropy, UnitsScale) {
  // k ~ E L: powers of two give the same bits.
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 6);
  for (const bool patch : {false, true}) {
    const SpringNetwork one = identified(mesh, 1.0, patch);
    const SpringNetwork other = identified(scaled(mesh, 0x1.0p-7), 0x1.0p13, patch);
    for (std::size_t s = 0; s < one.springs.size(); ++s)
      EXPECT_EQ(64.0 * one.stiffness_n_per_m[s], other.stiffness_n_per_m[s]);
  }
}

TEST(IdentifyIsotropy, NumbersOfVerticesDoNotMatter) {
  // The rows go along a curve in space, so another numbering of the same points changes rounding alone.
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 6);
  const auto count = static_cast<Index>(mesh.points.size());
  TetMesh reversed = mesh;
  std::reverse(reversed.points.begin(), reversed.points.end());
  for (Tet& tet : reversed.tets)
    for (Index& v : tet) v = count - 1 - v;
  const SpringNetwork one = identified(mesh, 1.0, true);
  const SpringNetwork other = identified(reversed, 1.0, true);
  for (std::size_t s = 0; s < one.springs.size(); ++s) {
    const Edge edge{count - 1 - one.springs[s][1], count - 1 - one.springs[s][0]};
    const auto at = std::lower_bound(other.springs.begin(), other.springs.end(), edge);
    ASSERT_EQ(*at, edge);
    EXPECT_NEAR(one.stiffness_n_per_m[s], other.stiffness_n_per_m[at - other.springs.begin()], 1e-8);
  }
}

TEST(IdentifyIsotropy, OneTetAndFlatFansEndFinite) {
  for (const bool patch : {false, true}) {
    for (const double flat : {1.0, 1e-3, 1e-6, 1e-12}) {
      TetMesh mesh = palpate::testing_support::make_two_tets();
      for (Vec3& point : mesh.points) point.z *= flat;
      IsotropyReport report;
      const SpringNetwork network = identified(mesh, 1e4, patch, &report);
      EXPECT_TRUE(report.solve.converged) << "flat " << flat;
      for (const double k : network.stiffness_n_per_m) {
        EXPECT_TRUE(std::isfinite(k));
        EXPECT_GE(k, 0.0);
      }
    }
  }
}

/// A fan of tets around the axis from (0, 0, 0) to (0, 0, 1): both ends have count + 1 springs.
TetMesh make_hub(Index count) {
  TetMesh mesh;
  mesh.points = {{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}};
  for (Index i = 0; i < count; ++i) {
    const double angle = 2.0 * 3.141592653589793 * i / count;
    mesh.points.push_back({std::cos(angle), std::sin(angle), 0.5 + 0.1 * std::cos(3.0 * angle)});
  }
  for (Index i = 0; i < count; ++i) mesh.tets.push_back({0, 1, 2 + i, 2 + (i + 1) % count});
  for (Tet& tet : mesh.tets)
    if (signed_volume(mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]) < 0)
      std::swap(tet[0], tet[1]);
  return mesh;
}

TEST(IdentifyIsotropy, HubsOfManySpringsTakeTheirRows) {
  // More springs at a vertex than a stored block holds, and just as many as it holds.
  for (const Index count : {63U, 64U, 200U}) {
    const TetMesh mesh = make_hub(count);
    IsotropyReport report;
    const SpringNetwork network = identified(mesh, 100.0, true, &report);
    EXPECT_TRUE(report.solve.converged) << count;
    IsotropyOptions options;
    options.patch = true;
    const IsotropySystem system = build_isotropy_system(mesh, network, 100.0, options);
    EXPECT_LT(system.blocks.size(), std::size_t{64} * 2 * network.springs.size());
    std::vector<double> w(network.springs.size());
    for (std::size_t s = 0; s < w.size(); ++s)
      w[s] = network.stiffness_n_per_m[s] * network.rest_length_m[s] * network.rest_length_m[s];
    EXPECT_LE(palpate::springs::testing_support::dense_kkt(dense_rows(system), system.target, w), 1.01e-10);
  }
}

TEST(IdentifyIsotropy, RefusesANetworkOfAnotherMesh) {
  const TetMesh mesh = palpate::testing_support::make_corner_tet();
  SpringNetwork network = edge_network(mesh);
  EXPECT_THROW(identify_isotropy(mesh, 0.0, {}, network), ContractError);
  network.rest_length_m[0] = 0.0;
  EXPECT_THROW(identify_isotropy(mesh, 1.0, {}, network), ContractError);
  network = edge_network(mesh);
  network.springs.back()[1] = 4;
  EXPECT_THROW(identify_isotropy(mesh, 1.0, {}, network), ContractError);
}

}  // namespace

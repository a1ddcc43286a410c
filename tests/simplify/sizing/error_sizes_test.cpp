#include "core/simplify/sizing/error_sizes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/small_meshes.h"

namespace palpate::simplify {
namespace {

constexpr double kLambda = 3000.0;
constexpr double kMu = 2000.0;

template <typename Field>
std::vector<Vec3> sampled(const TetMesh& mesh, const Field& field) {
  std::vector<Vec3> values;
  values.reserve(mesh.points.size());
  for (const Vec3& p : mesh.points) values.push_back(field(p));
  return values;
}

double volume_of(const TetMesh& mesh, const Tet& t) {
  return signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
}

TEST(ErrorSizes, AUniformStrainHasNoError) {
  const TetMesh mesh = build_kuhn_cube(4, 0.2, 5);
  const auto u = sampled(mesh, [](const Vec3& p) {
    return Vec3{0.01 * p.x + 0.02 * p.y, 0.03 * p.z, -0.01 * p.x};
  });
  const std::vector<double> errors = estimate_tet_errors(mesh, kLambda, kMu, u);
  const double energy = 0.5 * (kLambda + 2.0 * kMu) * 0.03 * 0.03;
  for (const double e : errors) EXPECT_LE(e, 1e-20 * energy);
  for (const double size : sizes_of_errors(mesh, std::vector<double>(mesh.tets.size(), 0.0), 0.2, 0.0))
    EXPECT_EQ(size, 1.0);
}

/// u_x = x^2 / 2 has the strain x; linear functions on cells of length h have a + h / 2 in [a, a + h], and
/// the mean of two such is x at an inner vertex. The difference is +-h / 2 at the corners of a tet, three and
/// one or two and two: 1/2 (lambda + 2 mu) V h^2 / 10, or half of that.
TEST(ErrorSizes, AQuadraticFieldHasItsOwnErrorInside) {
  constexpr int kCells = 6;
  const double h = 1.0 / kCells;
  TetMesh mesh = build_kuhn_cube(kCells, 0.0, 0);
  const auto u = sampled(mesh, [](const Vec3& p) { return Vec3{0.5 * p.x * p.x, 0.0, 0.0}; });
  const std::vector<double> errors = estimate_tet_errors(mesh, kLambda, kMu, u);
  const std::vector<std::uint8_t> on_boundary = build_boundary_vertex_flags(mesh);
  std::size_t inside = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    if (std::any_of(tet.begin(), tet.end(), [&](Index v) { return on_boundary[v] != 0; })) continue;
    double low = 1.0;
    for (const Index v : tet) low = std::min(low, mesh.points[v].x);
    const auto at_low =
        std::count_if(tet.begin(), tet.end(), [&](Index v) { return mesh.points[v].x < low + 0.5 * h; });
    const double share = at_low == 2 ? 0.05 : 0.1;
    const double expected = 0.5 * (kLambda + 2.0 * kMu) * volume_of(mesh, tet) * h * h * share;
    EXPECT_NEAR(errors[t], expected, 1e-9 * expected);
    ++inside;
  }
  EXPECT_EQ(inside, 6U * 4 * 4 * 4);
}

TEST(ErrorSizes, TheErrorHasTheSameEnergyInAnyFrame) {
  TetMesh mesh = build_kuhn_cube(3, 0.2, 9);
  const auto field = [](const Vec3& p) { return Vec3{p.x * p.y, p.z * p.z, 0.3 * p.x * p.x}; };
  std::vector<Vec3> u = sampled(mesh, field);
  const std::vector<double> before = estimate_tet_errors(mesh, kLambda, kMu, u);
  const auto turned = [](const Vec3& p) { return Vec3{0.6 * p.x - 0.8 * p.y, 0.8 * p.x + 0.6 * p.y, p.z}; };
  for (Vec3& p : mesh.points) p = turned(p);
  for (Vec3& value : u) value = turned(value);
  const std::vector<double> after = estimate_tet_errors(mesh, kLambda, kMu, u);
  for (std::size_t t = 0; t < before.size(); ++t)
    EXPECT_NEAR(after[t], before[t], 1e-10 * (1e-12 + before[t]));
}

TEST(ErrorSizes, AreTheFifthRootOfTheDensityDownToTheLeast) {
  const TetMesh mesh = testing_support::make_kuhn_block(8, 2, 2);
  std::vector<double> errors(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    double x = 0.0;
    for (const Index v : mesh.tets[t]) x += 0.25 * mesh.points[v].x;
    const double volume = volume_of(mesh, mesh.tets[t]);
    errors[t] = (x > 4.0 ? 32.0 : 1.0) * volume * std::cbrt(volume) * std::cbrt(volume);
  }
  const std::vector<double> sizes = sizes_of_errors(mesh, errors, 0.1, 0.0);
  const std::vector<double> bounded = sizes_of_errors(mesh, errors, 0.7, 0.0);
  const std::vector<double> spread = sizes_of_errors(mesh, errors, 0.1, 3.0);
  for (std::size_t v = 0; v < sizes.size(); ++v) {
    const double x = mesh.points[v].x;
    if (x != 4.0) {
      EXPECT_NEAR(sizes[v], x > 4.0 ? 0.5 : 1.0, 1e-12);
    }
    EXPECT_NEAR(bounded[v], std::max(0.7, sizes[v]), 1e-12);
    EXPECT_GE(spread[v], 0.5 - 1e-12);
    EXPECT_LE(spread[v], 1.0);
  }
  // What was spread is no step any more.
  const auto at = [&](double x) {
    for (std::size_t v = 0; v < sizes.size(); ++v) {
      if (mesh.points[v].x == x && mesh.points[v].y == 1.0 && mesh.points[v].z == 1.0) return spread[v];
    }
    return 0.0;
  };
  EXPECT_GT(at(3.0), at(4.0));
  EXPECT_GT(at(4.0), at(5.0));
  EXPECT_LT(at(3.0), at(1.0));
}

TEST(ErrorSizes, GrowthIsTheDistanceToWhatIsSmall) {
  const TetMesh mesh = testing_support::make_kuhn_block(6, 3, 3);
  std::vector<double> sizes(mesh.points.size(), 1.0);
  for (std::size_t v = 0; v < sizes.size(); ++v) {
    if (mesh.points[v].x == 0.0) sizes[v] = 0.2;
  }
  limit_growth(mesh, 0.3, 2.0, sizes);  // 0.15 a unit of length
  for (std::size_t v = 0; v < sizes.size(); ++v)
    EXPECT_NEAR(sizes[v], std::min(1.0, 0.2 + 0.15 * mesh.points[v].x), 1e-12);
}

TEST(ErrorSizes, FitsTheFarLengthToTheCount) {
  const TetMesh mesh = build_kuhn_cube(8, 0.1, 2);
  std::vector<double> even(mesh.points.size(), 0.5);
  const std::uint64_t tets = mesh.tets.size() / 20;
  const double far = fit_sizes(mesh, tets, even);
  // 0.1 (far / 2)^3 tets = volume, as long as no tet of the mesh is larger than wanted.
  EXPECT_NEAR(far, 2.0 * std::cbrt(1.0 / (0.1 * static_cast<double>(tets))), 1e-9);
  EXPECT_EQ(even, std::vector<double>(mesh.points.size(), 0.5));
  // Sizes that the mesh does not have are raised to those it has, and the far length falls short of nothing.
  std::vector<double> fine(mesh.points.size(), 1.0);
  for (std::size_t v = 0; v < fine.size(); ++v) {
    if (mesh.points[v].x < 0.5) fine[v] = 0.01;
  }
  const double wide = fit_sizes(mesh, 3 * mesh.tets.size() / 4, fine);
  for (const double size : fine) EXPECT_GT(size * wide, 0.5 / 8.0);
}

TEST(ErrorSizes, RefuseNonsense) {
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> errors(mesh.tets.size(), 1.0);
  for (const double least : {0.0, -0.5, 1.5, nan})
    EXPECT_THROW(sizes_of_errors(mesh, errors, least, 0.0), InputError);
  for (const double spread : {-1.0, nan})
    EXPECT_THROW(sizes_of_errors(mesh, errors, 0.5, spread), InputError);
  std::vector<double> sizes(mesh.points.size(), 1.0);
  for (const double growth : {0.0, -1.0, nan})
    EXPECT_THROW(limit_growth(mesh, growth, 1.0, sizes), InputError);
  EXPECT_THROW(limit_growth(mesh, 0.5, nan, sizes), InputError);
  EXPECT_THROW(fit_sizes(mesh, 0, sizes), InputError);
  EXPECT_THROW(fit_sizes(mesh, mesh.tets.size(), sizes), InputError);
  sizes[3] = nan;
  EXPECT_THROW(fit_sizes(mesh, 5, sizes), InputError);
}

}  // namespace
}  // namespace palpate::simplify

// Halved edges: the same body, finer where it is wanted, and the same problem on it.
#include "core/mesh/subdivision/bisection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"

namespace palpate {
namespace {

/// Fine at the floor.
double size_at(const Vec3& p) {
  return 0.2 + p.z;
}

double least_volume(const TetMesh& mesh) {
  double least = INFINITY;
  for (const Tet& t : mesh.tets)
    least = std::min(
        least, signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]));
  return least;
}

double area(const TetMesh& mesh, const std::vector<Triangle>& faces, const std::vector<double>& weight) {
  double sum = 0.0;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Vec3& a = mesh.points[faces[f][0]];
    sum += weight[f] * 0.5 * length(cross(mesh.points[faces[f][1]] - a, mesh.points[faces[f][2]] - a));
  }
  return sum;
}

std::set<Triangle> turned(const std::vector<Triangle>& faces) {
  std::set<Triangle> out;
  for (Triangle face : faces) {
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    out.insert(face);
  }
  return out;
}

TEST(Bisection, KeepsTheBodyAndIsFineWhereItIsWanted) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  const BisectedMesh finer = bisect_edges(mesh, 400, size_at);
  EXPECT_GE(finer.mesh.points.size(), 400U);
  EXPECT_EQ(finer.mesh.points.size(), mesh.points.size() + finer.halved.size());
  EXPECT_NEAR(total_volume(finer.mesh), total_volume(mesh), 1e-13);
  EXPECT_GT(least_volume(finer.mesh), 0.0);
  const std::vector<Triangle> skin = build_boundary(finer.mesh);  // throws where faces don't match
  const std::vector<double> ones(skin.size(), 1.0);
  EXPECT_NEAR(area(finer.mesh, skin, ones), 6.0, 1e-12);
  for (std::size_t i = 0; i < finer.halved.size(); ++i) {
    const std::size_t middle = mesh.points.size() + i;
    const auto [a, b] = finer.halved[i];
    ASSERT_LT(std::max(a, b), middle);
    EXPECT_EQ(finer.mesh.points[middle], 0.5 * (finer.mesh.points[a] + finer.mesh.points[b]));
  }
  double low = 0.0;
  double high = 0.0;
  std::size_t lows = 0;
  std::size_t highs = 0;
  for (const auto& [a, b] : build_edges(finer.mesh)) {
    const Vec3 middle = 0.5 * (finer.mesh.points[a] + finer.mesh.points[b]);
    const double size = length(finer.mesh.points[b] - finer.mesh.points[a]);
    if (middle.z < 0.2) low += size, ++lows;
    if (middle.z > 0.8) high += size, ++highs;
  }
  EXPECT_LT(low / static_cast<double>(lows), 0.6 * high / static_cast<double>(highs));
}

TEST(Bisection, IsTheSameEachTimeAndStopsWhereNothingIsWanted) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  EXPECT_EQ(bisect_edges(mesh, 100, size_at).mesh, bisect_edges(mesh, 100, size_at).mesh);
  EXPECT_EQ(bisect_edges(mesh, mesh.points.size(), size_at).mesh, mesh);
  EXPECT_EQ(bisect_edges(mesh, 100, [](const Vec3&) { return INFINITY; }).mesh, mesh);
}

TEST(Bisection, AProblemIsHandedDownToTheSamePlaces) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  BoundaryProblem problem;
  problem.material = {1e4, 0.3, 1000.0};
  problem.supports.resize(1);
  problem.held.resize(1);
  for (const Triangle& face : build_boundary(mesh)) {
    const Vec3 middle = (1.0 / 3.0) * (mesh.points[face[0]] + mesh.points[face[1]] + mesh.points[face[2]]);
    if (middle.z < 1e-9) {
      problem.supports[0].patch.faces.push_back(face);
      problem.supports[0].patch.weight.push_back(0.25 + 0.5 * middle.x);
    } else if (middle.x < 1e-9) {
      problem.held[0].faces.push_back(face);
    }
  }
  const BisectedMesh finer = bisect_edges(mesh, 300, size_at);
  const BoundaryProblem down = bisect_problem(problem, mesh.points.size(), finer.halved);
  const FacePatch& before = problem.supports[0].patch;
  const FacePatch& after = down.supports[0].patch;
  ASSERT_GT(after.faces.size(), before.faces.size());
  EXPECT_NEAR(area(finer.mesh, after.faces, after.weight), area(mesh, before.faces, before.weight), 1e-13);
  const std::set<Triangle> skin = turned(build_boundary(finer.mesh));
  const auto all_on_skin = [&](const std::vector<Triangle>& faces) {
    const std::set<Triangle> wanted = turned(faces);
    return wanted.size() == faces.size() &&
           std::includes(skin.begin(), skin.end(), wanted.begin(), wanted.end());
  };
  EXPECT_TRUE(all_on_skin(after.faces));
  EXPECT_TRUE(all_on_skin(down.held[0].faces));
  EXPECT_FALSE(all_on_skin(before.faces)) << "faces that were not halved are no faces any more";
}

TEST(Bisection, RefusesFieldsThatVary) {
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 1);
  BoundaryProblem problem;
  problem.held_field_m.resize(3);
  EXPECT_THROW(bisect_problem(problem, mesh.points.size(), {}), InputError);
}

}  // namespace
}  // namespace palpate

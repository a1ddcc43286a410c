// The known answers themselves: each fulfils the equations that its problem states, by differences and
// quadrature of the test's own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"
#include "core/mesh/topology.h"
#include "reference/closed_form/known_cases.h"
#include "reference/closed_form/solutions.h"
#include "reference/closed_form/structured_mesh.h"

namespace palpate::reference {
namespace {

using Field = std::function<Vec3(const Vec3&)>;

Vec3 axis(int i) {
  return {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0};
}

/// Gradient by central differences of fourth order: rows are components, columns directions.
Matrix3 gradient(const Field& u, const Vec3& x, double h) {
  std::array<Vec3, 3> columns;
  for (int j = 0; j < 3; ++j) {
    const Vec3 step = h * axis(j);
    columns[static_cast<std::size_t>(j)] =
        (1.0 / (12.0 * h)) * (8.0 * (u(x + step) - u(x - step)) - (u(x + 2.0 * step) - u(x - 2.0 * step)));
  }
  Matrix3 rows;
  for (std::size_t i = 0; i < 3; ++i)
    rows[i] = {component(columns[0], i), component(columns[1], i), component(columns[2], i)};
  return rows;
}

Matrix3 stress(const Field& u, const Material& material, const Vec3& x, double h) {
  const Matrix3 g = gradient(u, x, h);
  const double trace = g[0].x + g[1].y + g[2].z;
  const double lambda = material.lambda_pa();
  const double mu = material.mu_pa();
  Matrix3 s{Vec3{2 * mu * g[0].x, mu * (g[0].y + g[1].x), mu * (g[0].z + g[2].x)},
            {mu * (g[1].x + g[0].y), 2 * mu * g[1].y, mu * (g[1].z + g[2].y)},
            {mu * (g[2].x + g[0].z), mu * (g[2].y + g[1].z), 2 * mu * g[2].z}};
  s[0].x += lambda * trace;
  s[1].y += lambda * trace;
  s[2].z += lambda * trace;
  return s;
}

/// div sigma, by differences of the stress.
Vec3 stress_divergence(const Field& u, const Material& material, const Vec3& x, double h) {
  Vec3 sum;
  for (std::size_t j = 0; j < 3; ++j) {
    const Field column = [&](const Vec3& at) {
      const Matrix3 s = stress(u, material, at, h);
      return Vec3{component(s[0], j), component(s[1], j), component(s[2], j)};
    };
    const Matrix3 g = gradient(column, x, h);
    sum = sum + Vec3{component(g[0], j), component(g[1], j), component(g[2], j)};
  }
  return sum;
}

Vec3 times(const Matrix3& m, const Vec3& v) {
  return {dot(m[0], v), dot(m[1], v), dot(m[2], v)};
}

Vec3 unit_normal(const TetMesh& mesh, const Triangle& t) {
  const auto& p = mesh.points;
  const Vec3 n = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
  return (1.0 / length(n)) * n;
}

double area(const TetMesh& mesh, const std::vector<Triangle>& faces) {
  double sum = 0.0;
  for (const Triangle& t : faces) {
    sum += 0.5 * length(cross(mesh.points[t[1]] - mesh.points[t[0]], mesh.points[t[2]] - mesh.points[t[0]]));
  }
  return sum;
}

Vec3 centroid(const TetMesh& mesh, const Tet& t) {
  return 0.25 * (mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]] + mesh.points[t[3]]);
}

bool is_small_strain(const KnownCase& known) {
  return known.problem.strain == StrainSize::kSmall && known.displacement;
}

TEST(ClosedForm, MeshesAreBallsOfPositiveTetsForEveryCase) {
  for (const KnownCaseInfo& info : list_known_cases()) {
    for (const int cells : {2, 4}) {
      SCOPED_TRACE(info.name + " " + std::to_string(cells));
      const TetMesh mesh = build_known_case(info.name, cells).mesh;
      const auto& p = mesh.points;
      for (const Tet& t : mesh.tets) ASSERT_EQ(orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]), 1);
      const std::size_t plus = p.size() + build_faces(mesh).size();
      EXPECT_EQ(plus - build_edges(mesh).size() - mesh.tets.size(), 1U);
      std::set<Index> used;
      for (const Tet& t : mesh.tets) used.insert(t.begin(), t.end());
      EXPECT_EQ(used.size(), p.size());
    }
  }
}

TEST(ClosedForm, TheAnswerIsInEquilibriumWithItsBodyForce) {
  for (const KnownCaseInfo& info : list_known_cases()) {
    const KnownCase known = build_known_case(info.name, 2);
    if (!is_small_strain(known) || !known.problem.body_force_n_m3.empty()) continue;
    SCOPED_TRACE(info.name);
    const double size = length(bounding_box(known.mesh.points).high);
    const Material& material = known.problem.material;
    const Vec3 weight = material.density_kg_m3 * known.problem.gravity_m_s2;
    for (const Tet& t : known.mesh.tets) {
      const Vec3 x = centroid(known.mesh, t);
      const Vec3 gap = stress_divergence(known.displacement, material, x, 2e-3 * size) + weight;
      // E |u| / size^2 is the scale of div sigma. The steps are 1/150 of the least radius r, so the
      // differences err by some (h / r)^4 of it times sixth derivatives of 1 / r^2, 7! / r^8.
      const double scale = material.young_modulus_pa * length(known.displacement(x)) / (size * size);
      ASSERT_LT(length(gap), 3e-4 * scale);
    }
  }
}

TEST(ClosedForm, TheManufacturedBodyForceIsMinusTheDivergenceOfItsStress) {
  const KnownCase known = build_known_case("manufactured", 2);
  ASSERT_EQ(known.problem.body_force_n_m3.size(), known.mesh.points.size() + build_edges(known.mesh).size());
  double largest = 0.0;
  for (const Vec3& f : known.problem.body_force_n_m3) largest = std::max(largest, length(f));
  for (std::size_t v = 0; v < known.mesh.points.size(); ++v) {
    const Vec3 divergence =
        stress_divergence(known.displacement, known.problem.material, known.mesh.points[v], 5e-3);
    ASSERT_LT(length(divergence + known.problem.body_force_n_m3[v]), 1e-6 * largest);
  }
}

TEST(ClosedForm, TheAnswerFulfilsItsBoundaryConditions) {
  for (const KnownCaseInfo& info : list_known_cases()) {
    const KnownCase known = build_known_case(info.name, 4);
    if (!known.displacement) continue;
    SCOPED_TRACE(info.name);
    const BoundaryProblem& problem = known.problem;
    for (const HeldFaces& held : problem.held) {
      ASSERT_FALSE(held.faces.empty());
      for (const Triangle& face : held.faces) {
        for (const Index v : face) {
          const Vec3 told = problem.held_field_m.empty() ? held.by_m : held.by_m + problem.held_field_m[v];
          for (std::size_t i = 0; i < 3; ++i) {
            if (!held.axes[i]) continue;
            ASSERT_NEAR(component(known.displacement(known.mesh.points[v]), i), component(told, i), 1e-15);
          }
        }
      }
    }
    if (problem.strain != StrainSize::kSmall) continue;
    // Stress times normal: what tractions and pads say on their faces, and nothing tangential or free
    // elsewhere.
    std::set<Triangle> loaded;
    const double size = length(bounding_box(known.mesh.points).high);
    const auto check = [&](const Triangle& face, const std::function<Vec3(const Vec3&, const Vec3&)>& told) {
      loaded.insert(face);
      for (const Index v : face) {
        const Vec3 x = known.mesh.points[v];
        const Vec3 n = info.name == "thick_sphere" ? (-1.0 / length(x)) * x : unit_normal(known.mesh, face);
        const Vec3 t = times(stress(known.displacement, problem.material, x, 1e-3 * size), n);
        ASSERT_LT(length(t - told(x, n)), 1e-6 * length(told(x, n)));
      }
    };
    for (const Traction& traction : problem.tractions) {
      ASSERT_FALSE(traction.patch.faces.empty());
      for (const Triangle& face : traction.patch.faces) {
        check(face,
              [&](const Vec3&, const Vec3& n) { return traction.traction_pa - traction.pressure_pa * n; });
      }
    }
    for (const ElasticSupport& support : problem.supports) {
      for (const Triangle& face : support.patch.faces) {
        check(face, [&](const Vec3& x, const Vec3&) {
          return support.stiffness_pa_per_m * (support.by_m - known.displacement(x));
        });
      }
    }
  }
}

TEST(ClosedForm, TheRestOfTheBoundaryIsFree) {
  for (const char* name : {"bar_tension", "bar_pads", "bar_own_weight", "thick_sphere"}) {
    SCOPED_TRACE(name);
    const KnownCase known = build_known_case(name, 4);
    std::set<Triangle> named;
    for (const auto& held : known.problem.held) named.insert(held.faces.begin(), held.faces.end());
    for (const auto& s : known.problem.supports) named.insert(s.patch.faces.begin(), s.patch.faces.end());
    for (const auto& t : known.problem.tractions) named.insert(t.patch.faces.begin(), t.patch.faces.end());
    const double size = length(bounding_box(known.mesh.points).high);
    std::size_t free = 0;
    for (const Triangle& face : build_boundary(known.mesh)) {
      if (named.count(face) > 0) continue;
      ++free;
      const Vec3 x = known.mesh.points[face[0]];
      const Vec3 n =
          std::string(name) == "thick_sphere" ? (1.0 / length(x)) * x : unit_normal(known.mesh, face);
      const Vec3 t = times(stress(known.displacement, known.problem.material, x, 1e-3 * size), n);
      ASSERT_LT(length(t), 1e-5 * known.problem.material.young_modulus_pa * 0.01);
    }
    EXPECT_GT(free, 0U);
  }
}

TEST(ClosedForm, LoadedFacesHaveTheirArea) {
  const KnownCase bar = build_known_case("bar_tension", 3);
  EXPECT_NEAR(area(bar.mesh, bar.problem.tractions[0].patch.faces), 1e-4, 1e-18);
  const KnownCase sphere = build_known_case("thick_sphere", 16);
  // An eighth of 4 pi a^2; facets miss O(h^2) of it.
  const double eighth = 4.0 * 3.14159265358979 * 0.05 * 0.05 / 8.0;
  EXPECT_NEAR(area(sphere.mesh, sphere.problem.tractions[0].patch.faces), eighth, 0.01 * eighth);
  const KnownCase membrane = build_known_case("elliptic_membrane", 8);
  EXPECT_EQ(membrane.problem.tractions[0].patch.faces.size(), 2U * 16U);
  EXPECT_EQ(membrane.problem.held[0].faces.size(), 2U * 8U);  // x = 0: the edge AB
  EXPECT_EQ(membrane.problem.held[1].faces.size(), 2U * 8U);  // y = 0: the edge CD
  EXPECT_EQ(membrane.problem.held[2].faces.size(), 2U * 8U * 16U);
}

TEST(ClosedForm, ValuesStandAtTheirPoints) {
  const KnownCase membrane = build_known_case("elliptic_membrane", 8);
  EXPECT_EQ(membrane.mesh.points[membrane.value->vertex], (Vec3{2.0, 0.0, 0.0}));
  EXPECT_EQ(membrane.value->value, 92.7e6);
  const KnownCase beam = build_known_case("cantilever", 4);
  EXPECT_LT(length(beam.mesh.points[beam.value->vertex] - Vec3{0.1, 0.005, 0.005}), 1e-12);
}

TEST(ClosedForm, TimoshenkoGoesOverIntoEulerAndShearAlone) {
  const Material material{10000.0, 0.25, 0.0};
  // A thousand times as long as thick: shear is 1e-6 of it. F L^3 / (3 E I) with I = s^4 / 12.
  const double slender = timoshenko_deflection(material, 1.0, 1e-3, 1e-9);
  EXPECT_NEAR(slender, 1e-9 * 12.0 / (3.0 * 10000.0 * 1e-12), 2e-6 * slender);
  // A thousandth as long: F L / (kappa G A), kappa = 12.5 / 14.75.
  const double stubby = timoshenko_deflection(material, 1e-3, 1.0, 1.0);
  EXPECT_NEAR(stubby, 1e-3 / (12.5 / 14.75 * 4000.0), 3e-6 * stubby);
}

TEST(ClosedForm, NeoHookeanStretchIsInEquilibriumByItsEnergy) {
  const Material material{10000.0, 0.3, 0.0};
  const double lambda = material.lambda_pa();
  const double mu = material.mu_pa();
  const auto energy = [&](double s, double t) {
    const double j = std::log(s * t * t);
    return 0.5 * mu * (s * s + 2 * t * t - 3) - mu * j + 0.5 * lambda * j * j;
  };
  for (const double stretch : {0.6, 0.9, 1.0, 1.1, 1.3, 2.0}) {
    const UniaxialStretch found = stretch_neo_hookean(material, stretch);
    const double h = 1e-5;
    EXPECT_NEAR((energy(stretch, found.across + h) - energy(stretch, found.across - h)) / (2 * h), 0.0, 1e-4);
    EXPECT_NEAR((energy(stretch + h, found.across) - energy(stretch - h, found.across)) / (2 * h),
                found.traction_pa, 1e-4);
  }
  const UniaxialStretch small = stretch_neo_hookean(material, 1.0 + 1e-6);
  EXPECT_NEAR(small.across, 1.0 - 0.3e-6, 1e-11);
  EXPECT_NEAR(small.traction_pa, 10000.0 * 1e-6, 1e-7);
  EXPECT_THROW(stretch_neo_hookean(material, 0.0), ContractError);
}

TEST(ClosedForm, RefusesUnknownCasesAndCellsThatACaseCannotHave) {
  EXPECT_THROW(build_known_case("patch", 2), InputError);
  for (const KnownCaseInfo& info : list_known_cases()) {
    EXPECT_THROW(build_known_case(info.name, 0), InputError) << info.name;
    EXPECT_THROW(build_known_case(info.name, -4), InputError) << info.name;
  }
  EXPECT_THROW(build_known_case("manufactured", 6), InputError);
  EXPECT_THROW(build_known_case("cantilever", 3), InputError);
  EXPECT_THROW(build_shell_octant(2, 2, 1.0, 1.0), InputError);
  EXPECT_THROW(build_mapped_block({1, 1, 1},
                                  [](const Vec3& x) {
                                    return Vec3{x.y, x.x, x.z};
                                  }),
               ContractError);
}

}  // namespace
}  // namespace palpate::reference

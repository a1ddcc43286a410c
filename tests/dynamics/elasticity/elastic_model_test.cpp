#include "core/dynamics/elasticity/elastic_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/dynamics/elasticity/tangent.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/small_meshes.h"

namespace palpate::dynamics {
namespace {

using testing_support::field_norm;
using testing_support::make_edge_springs;
using testing_support::make_random_field;

constexpr Material kMaterial{1000.0, 0.4, 1000.0};

/// Every model that this folder builds, on a small mesh, by name.
struct Named {
  std::string name;
  ElasticModel model;
};

std::vector<Named> all_models(const TetMesh& mesh, StrainSize strain) {
  std::vector<Named> out;
  const std::vector<StrainLaw> laws = strain == StrainSize::kSmall
                                          ? std::vector{StrainLaw::kCorotated}
                                          : std::vector{StrainLaw::kCorotated, StrainLaw::kNeoHookean};
  for (const StrainLaw law : laws) {
    for (const VolumeModel volume : {VolumeModel::kNone, VolumeModel::kThesis, VolumeModel::kTet,
                                     VolumeModel::kNodeAverage, VolumeModel::kNodeSmoothed}) {
      const Material fitted = spring_material(kMaterial, volume);
      out.push_back({std::string(volume_model_name(volume)) + " " + strain_law_name(law),
                     build_spring_model(mesh, make_edge_springs(mesh, fitted.young_modulus_pa), kMaterial,
                                        {volume, strain, law, 0.7})
                         .model});
    }
    for (const StrainDomain domain : {StrainDomain::kNode, StrainDomain::kEdge, StrainDomain::kFace}) {
      out.push_back({std::string("springs and ") + strain_domain_name(domain) + " " + strain_law_name(law),
                     build_spring_model(mesh, make_edge_springs(mesh, 2.5 * kMaterial.mu_pa()), kMaterial,
                                        {VolumeModel::kNodeSmoothed, strain, law, 0.5, domain})
                         .model});
      out.push_back(
          {std::string("blend ") + strain_domain_name(domain) + " " + strain_law_name(law),
           build_blend_model(mesh, kMaterial, {strain, law, 0.6, domain, StrainDomain::kTet}).model});
    }
  }
  if (strain == StrainSize::kSmall) {
    BlendOptions stabilised;
    stabilised.stabilise = 0.2;
    out.push_back({"stabilised blend", build_blend_model(mesh, kMaterial, stabilised).model});
  }
  return out;
}

std::vector<Vec3> forces(const ElasticModel& model, const std::vector<Vec3>& u) {
  std::vector<Vec3> f(u.size());
  add_elastic_forces(model, u, f);
  return f;
}

std::vector<Vec3> moved(const std::vector<Vec3>& u, double s, const std::vector<Vec3>& direction) {
  std::vector<Vec3> out(u);
  for (std::size_t v = 0; v < u.size(); ++v) out[v] = u[v] + s * direction[v];
  return out;
}

TEST(ElasticModel, ForcesAreMinusTheDerivativeOfTheEnergy) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 3);
  const std::vector<Vec3> u = make_random_field(mesh.points.size(), 0.05, 1);
  const std::vector<Vec3> direction = make_random_field(mesh.points.size(), 1.0, 2);
  const double step = 1e-6;
  for (const StrainSize strain : {StrainSize::kSmall, StrainSize::kLarge}) {
    for (Named& each : all_models(mesh, strain)) {
      each.model.volume_force.reset();  // it has no energy
      const double slope = (elastic_energy(each.model, moved(u, step, direction)) -
                            elastic_energy(each.model, moved(u, -step, direction))) /
                           (2.0 * step);
      double work = 0.0;
      const std::vector<Vec3> f = forces(each.model, u);
      for (std::size_t v = 0; v < u.size(); ++v) work += dot(f[v], direction[v]);
      EXPECT_NEAR(slope, -work, 1e-7 * std::max(std::abs(work), field_norm(f))) << each.name;
    }
  }
}

TEST(ElasticModel, TheTangentIsMinusTheDerivativeOfTheForces) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 3);
  const std::vector<Vec3> u = make_random_field(mesh.points.size(), 0.05, 1);
  const std::vector<Vec3> direction = make_random_field(mesh.points.size(), 1.0, 2);
  const double step = 1e-6;
  for (const StrainSize strain : {StrainSize::kSmall, StrainSize::kLarge}) {
    for (Named& each : all_models(mesh, strain)) {
      each.model.volume_force.reset();  // tested on its own
      BlockMatrix matrix = build_tangent_pattern(each.model, {});
      add_tangent(each.model, u, TangentKind::kExact, matrix);
      std::vector<Vec3> exact(u.size());
      multiply(matrix, direction, exact);
      const std::vector<Vec3> more = forces(each.model, moved(u, step, direction));
      const std::vector<Vec3> less = forces(each.model, moved(u, -step, direction));
      std::vector<Vec3> off(u.size());
      for (std::size_t v = 0; v < u.size(); ++v) off[v] = exact[v] + (0.5 / step) * (more[v] - less[v]);
      EXPECT_LT(field_norm(off), 1e-7 * field_norm(exact)) << each.name;
    }
  }
}

TEST(ElasticModel, InnerForcesKeepMomentum) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 3);
  const std::vector<Vec3> u = make_random_field(mesh.points.size(), 0.05, 7);
  for (const StrainSize strain : {StrainSize::kSmall, StrainSize::kLarge}) {
    for (const Named& each : all_models(mesh, strain)) {
      const std::vector<Vec3> f = forces(each.model, u);
      Vec3 sum;
      Vec3 turn;
      for (std::size_t v = 0; v < u.size(); ++v) {
        sum = sum + f[v];
        turn = turn + cross(mesh.points[v] + u[v], f[v]);
      }
      const double size = field_norm(f);
      if (each.model.volume_force) {
        EXPECT_GT(length(sum), 1e-6 * size) << "the thesis's force pushes the body as a whole";
        continue;
      }
      EXPECT_LT(length(sum), 1e-13 * size) << each.name;
      // At small strain moments balance about the rest shape only.
      if (strain == StrainSize::kLarge) {
        EXPECT_LT(length(turn), 1e-13 * size) << each.name;
      }
    }
  }
}

TEST(ElasticModel, ARigidMotionGivesNoForceAtLargeStrain) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 3);
  const Mat3 turn = testing_support::make_rotation({0.0, 0.6, 0.8}, 2.0);
  const std::vector<Vec3> u =
      testing_support::make_affine_field(mesh.points, turn - kIdentity, {3.0, -1.0, 2.0});
  for (const Named& each : all_models(mesh, StrainSize::kLarge)) {
    EXPECT_LT(field_norm(forces(each.model, u)), 1e-11) << each.name;  // of forces of about 1e3 x strain
  }
  for (const Named& each : all_models(mesh, StrainSize::kSmall)) {
    if (!each.model.volume_force) {
      EXPECT_GT(field_norm(forces(each.model, u)), 10.0) << each.name;
    }
  }
}

TEST(ElasticModel, ADilatationHasTheEnergyOfTheMasterIdentity) {
  // sum k l^2 = 6 E V: a strain eps along every direction costs 1/2 eps^2 sum k l^2 = 3 E V eps^2, as 9/2 K
  // does with the bulk modulus K = 2 E / 3 of nu = 1/4.
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 8);
  const double eps = 1e-3;
  const std::vector<Vec3> u = testing_support::make_affine_field(mesh.points, eps * kIdentity, {});
  ElasticModel springs{mesh.points, make_edge_springs(mesh, 1000.0), true, {}, {}};
  const double expected = 3.0 * 1000.0 * total_volume(mesh) * eps * eps;
  EXPECT_NEAR(elastic_energy(springs, u), expected, 1e-12 * expected);
  springs.springs_are_linear = false;  // a stretch without rotation is the same
  EXPECT_NEAR(elastic_energy(springs, u), expected, 1e-12 * expected);
  // With the volume energy at nu = 0.45, K is the material's own.
  const Material soft{1000.0, 0.45, 1000.0};
  for (const VolumeModel volume :
       {VolumeModel::kTet, VolumeModel::kNodeAverage, VolumeModel::kNodeSmoothed}) {
    const Material fitted = spring_material(soft, volume);
    const BuiltModel built =
        build_spring_model(mesh, make_edge_springs(mesh, fitted.young_modulus_pa), soft, {volume});
    const double bulk = soft.lambda_pa() + 2.0 / 3.0 * soft.mu_pa();
    EXPECT_NEAR(elastic_energy(built.model, u), 4.5 * bulk * eps * eps * total_volume(mesh), 1e-12);
    SpringModelOptions with_edges{volume};
    with_edges.shear = StrainDomain::kEdge;
    const BuiltModel edges =
        build_spring_model(mesh, make_edge_springs(mesh, fitted.young_modulus_pa), soft, with_edges);
    EXPECT_NEAR(elastic_energy(edges.model, u), 4.5 * bulk * eps * eps * total_volume(mesh), 1e-12);
  }
}

TEST(ElasticModel, ABodyCentredLatticeHasLamesStress) {
  // k = 0.6 E h on half diagonals and 0.4 E h on axes: the virial stress of an inner vertex is that of an
  // isotropic solid with lambda = mu = 0.4 E under any strain.
  const int cells = 4;
  const double h = 1.0 / cells;
  const TetMesh mesh = build_bcc_bar(cells);
  const double young = 100.0;
  const Mat3 strain{{0.1, 0.03, -0.02, 0.03, -0.2, 0.05, -0.02, 0.05, 0.15}};
  SpringNetwork net;
  for (const Edge& edge : build_edges(mesh)) {
    const double l = length(mesh.points[edge[1]] - mesh.points[edge[0]]);
    const bool is_axis = std::abs(l - h) < 1e-9;
    net.springs.push_back(edge);
    net.rest_length_m.push_back(l);
    net.stiffness_n_per_m.push_back((is_axis ? 0.4 : 0.6) * young * h);
  }
  const ElasticModel model{mesh.points, net, true, {}, {}};
  const std::vector<Vec3> u = testing_support::make_affine_field(mesh.points, strain, {});
  const std::vector<Vec3> f = forces(model, u);
  int inner = 0;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    const Vec3& p = mesh.points[v];
    const double room = std::min({p.x, 4.0 - p.x, p.y, 1.0 - p.y, p.z, 1.0 - p.z});
    if (room < 1.2 * h) continue;
    ++inner;
    EXPECT_LT(length(f[v]), 1e-12 * young);
    Mat3 virial;
    for (std::size_t s = 0; s < net.springs.size(); ++s) {
      if (net.springs[s][0] != v && net.springs[s][1] != v) continue;
      const Vec3 d = mesh.points[net.springs[s][1]] - mesh.points[net.springs[s][0]];
      const double pull = net.stiffness_n_per_m[s] * dot(d, strain * d) / length_sq(d);
      virial += pull * outer(d, d);
    }
    const Mat3 stress_there = (1.0 / (h * h * h)) * virial;  // 1/2 the sum over a volume of h^3 / 2
    const Mat3 lame = (0.8 * young) * strain + (0.4 * young * trace(strain)) * kIdentity;
    const Mat3 off = stress_there - lame;
    EXPECT_LT(std::sqrt(contract(off, off)), 1e-11 * young);
  }
  EXPECT_GT(inner, 20);
}

TEST(ElasticModel, ASpringOfLengthZeroIsCounted) {
  const TetMesh mesh = testing_support::make_regular_tet();
  ElasticModel model{mesh.points, make_edge_springs(mesh, 10.0), false, {}, {}};
  std::vector<Vec3> u(4);
  std::vector<Vec3> f(4);
  EXPECT_EQ(add_elastic_forces(model, u, f), 0U);
  u[1] = mesh.points[0] - mesh.points[1];
  f.assign(4, {});
  EXPECT_EQ(add_elastic_forces(model, u, f), 1U);
  for (const Vec3& each : f) EXPECT_TRUE(is_finite(each));
}

TEST(ElasticModel, ASingleStretchedSpringPullsByHookesLaw) {
  ElasticModel model{{{0, 0, 0}, {2, 0, 0}}, {{{0, 1}}, {2.0}, {5.0}}, false, {}, {}};
  const std::vector<Vec3> u{{0, 0, 0}, {-2, 3, 0}};  // turned by a right angle and stretched by 1
  const std::vector<Vec3> f = forces(model, u);
  EXPECT_EQ(f[0], (Vec3{0, 5, 0}));
  EXPECT_EQ(f[1], (Vec3{0, -5, 0}));
  EXPECT_DOUBLE_EQ(elastic_energy(model, u), 2.5);
  // A displacement of one part in 10^12 keeps its digits.
  const std::vector<Vec3> tiny{{0, 0, 0}, {2e-12, 0, 0}};
  EXPECT_NEAR(forces(model, tiny)[0].x, 1e-11, 1e-25);
}

}  // namespace
}  // namespace palpate::dynamics

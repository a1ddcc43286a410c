#include "core/dynamics/elasticity/loads.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/base/error.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/small_meshes.h"

namespace palpate::dynamics {
namespace {

using testing_support::find_faces_at;

FacePatch whole(std::vector<Triangle> faces) {
  FacePatch patch{std::move(faces), {}};
  patch.weight.assign(patch.faces.size(), 1.0);
  return patch;
}

std::string message_of(const TetMesh& mesh, const BoundaryProblem& problem) {
  try {
    require_no_rigid_motion(mesh, build_loads(mesh, problem));
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

Vec3 sum_of(const std::vector<Vec3>& field) {
  Vec3 sum;
  for (const Vec3& f : field) sum = sum + f;
  return sum;
}

TEST(Loads, TotalsAreThoseOfTheIntegrals) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  BoundaryProblem gravity;
  gravity.material = {1.0, 0.25, 1000.0};
  gravity.gravity_m_s2 = {1.0, 2.0, -3.0};
  const Vec3 weight = sum_of(build_loads(mesh, gravity).force_n);
  EXPECT_LT(length(weight - Vec3{1000.0, 2000.0, -3000.0}), 1e-9);

  BoundaryProblem traction;
  traction.tractions.push_back({whole(find_faces_at(mesh, 0, 1.0)), {3.0, 4.0, 5.0}, 2.0});
  for (double& w : traction.tractions[0].patch.weight) w = 0.5;
  // Half of the face's area is loaded; the pressure acts against the outward normal x.
  EXPECT_LT(length(sum_of(build_loads(mesh, traction).force_n) - Vec3{0.5, 2.0, 2.5}), 1e-12);

  BoundaryProblem pressure;
  pressure.tractions.push_back({whole(build_boundary(mesh)), {}, 7.0});
  EXPECT_LT(length(sum_of(build_loads(mesh, pressure).force_n)), 1e-13)
      << "a uniform pressure has no resultant";
}

TEST(Loads, SupportForcesAreMinusTheDerivativeOfTheirEnergy) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  BoundaryProblem problem;
  problem.supports.push_back({whole(find_faces_at(mesh, 0, 1.0)), 30.0, {0.1, 0.2, 0.3}});
  problem.nodal_forces.push_back({3, {1.0, 2.0, 3.0}});
  const Loads loads = build_loads(mesh, problem);
  const std::vector<Vec3> u = testing_support::make_random_field(mesh.points.size(), 0.1, 4);
  const std::vector<Vec3> direction = testing_support::make_random_field(mesh.points.size(), 1.0, 5);
  std::vector<Vec3> force(u.size());
  add_load_forces(loads, u, 0.7, force);
  const auto energy = [&](double s) {
    std::vector<Vec3> there(u);
    for (std::size_t v = 0; v < u.size(); ++v) there[v] = u[v] + s * direction[v];
    return load_energy(loads, there, 0.7);
  };
  double work = 0.0;
  for (std::size_t v = 0; v < u.size(); ++v) work += dot(force[v], direction[v]);
  EXPECT_NEAR((energy(1e-3) - energy(-1e-3)) / 2e-3, -work, 1e-10);  // a quadratic: differences are exact
  // Moved as a whole by `by`, a support is at ease: all its energy is kappa / 2 |u - by|^2 x area.
  const std::vector<Vec3> still(u.size());
  BoundaryProblem bed;
  bed.supports = problem.supports;
  EXPECT_NEAR(load_energy(build_loads(mesh, bed), still, 1.0), 0.5 * 30.0 * 0.14, 1e-12);
}

TEST(Loads, RigidMotionsThatAreLeftFreeAreNamed) {
  const TetMesh mesh = build_bar(2);
  BoundaryProblem problem;
  EXPECT_NE(message_of(mesh, problem).find("left free"), std::string::npos);

  problem.held.push_back({find_faces_at(mesh, 0, 0.0), {true, false, false}, {}});
  problem.held.push_back({find_faces_at(mesh, 1, 0.0), {false, true, false}, {}});
  EXPECT_NE(message_of(mesh, problem).find("a translation along (0, 0, 1)"), std::string::npos)
      << message_of(mesh, problem);
  problem.held.push_back({find_faces_at(mesh, 2, 0.0), {false, false, true}, {}});
  EXPECT_EQ(message_of(mesh, problem), "");

  // Three vertices on a line leave the turn about it.
  BoundaryProblem hinge;
  const TetMesh tet = testing_support::make_corner_tet();
  hinge.held.push_back({{{0, 2, 1}}, {false, false, true}, {}});
  hinge.held.push_back({{{0, 1, 3}}, {false, true, false}, {}});
  const std::string free = message_of(tet, hinge);
  EXPECT_NE(free.find("a translation along (1, 0, 0)"), std::string::npos) << free;

  BoundaryProblem bed;
  bed.supports.push_back({whole(find_faces_at(mesh, 2, 0.0)), 1.0, {}});
  EXPECT_EQ(message_of(mesh, bed), "") << "an elastic bed holds all six motions";
  bed.supports[0].stiffness_pa_per_m = 0.0;
  EXPECT_NE(message_of(mesh, bed), "");
}

TEST(Loads, BadInputIsRefused) {
  const TetMesh mesh = testing_support::make_corner_tet();
  const auto refused = [&](const BoundaryProblem& problem) {
    EXPECT_THROW(build_loads(mesh, problem), InputError);
  };
  BoundaryProblem contradiction;
  contradiction.held.push_back({{{0, 2, 1}}, {true, true, true}, {}});
  contradiction.held.push_back({{{0, 1, 3}}, {false, false, true}, {0.0, 0.0, 0.1}});
  refused(contradiction);
  BoundaryProblem vertex;
  vertex.nodal_forces.push_back({4, {}});
  refused(vertex);
  BoundaryProblem weight;
  weight.tractions.push_back({{{{0, 2, 1}}, {1.5}}, {}, 1.0});
  refused(weight);
  weight.tractions[0].patch.weight = {};
  refused(weight);
  BoundaryProblem support;
  support.supports.push_back({whole({{0, 2, 1}}), -1.0, {}});
  refused(support);
  BoundaryProblem face;
  face.supports.push_back({whole({{0, 2, 9}}), 1.0, {}});
  refused(face);
}

TEST(VolumeModels, RatiosThatAModelCannotRepresentAreRefused) {
  const TetMesh mesh = build_kuhn_cube(2, 0.1, 5);
  const SpringNetwork net = testing_support::make_edge_springs(mesh, 1000.0);
  const auto build = [&](double young, double nu, VolumeModel volume, double theta) {
    return build_spring_model(mesh, net, {young, nu, 1.0},
                              {volume, StrainSize::kSmall, StrainLaw::kCorotated, theta});
  };
  EXPECT_THROW(build(1000.0, 0.5, VolumeModel::kNone, 0.7), InputError);
  EXPECT_THROW(build(1000.0, -1.0, VolumeModel::kNone, 0.7), InputError);
  EXPECT_THROW(build(0.0, 0.3, VolumeModel::kNone, 0.7), InputError);
  EXPECT_THROW(build(std::numeric_limits<double>::infinity(), 0.3, VolumeModel::kNone, 0.7), InputError);
  EXPECT_THROW(build(1000.0, 0.2, VolumeModel::kTet, 0.7), InputError);
  EXPECT_THROW(build(1000.0, 0.2, VolumeModel::kNodeAverage, 0.7), InputError);
  EXPECT_NO_THROW(build(1000.0, 0.25, VolumeModel::kTet, 0.7));
  EXPECT_THROW(build(1000.0, 0.3, VolumeModel::kNodeSmoothed, 1.1), InputError);
  EXPECT_THROW(build_blend_model(mesh, {1000.0, 0.3, 1.0}, {StrainSize::kSmall, StrainLaw::kCorotated, -0.1}),
               InputError);
  EXPECT_THROW(build_blend_model(mesh, {1000.0, 0.3, 1.0}, {StrainSize::kLarge, StrainLaw::kLinear}),
               InputError);
}

TEST(VolumeModels, AStableThetaTakesTheLowestRatios) {
  const TetMesh mesh = build_kuhn_cube(2, 0.1, 5);
  for (const double nu : {-0.9, -0.5, 0.0, 0.1}) {
    const Material material{1000.0, nu, 1.0};
    const BuiltModel built =
        build_spring_model(mesh, testing_support::make_edge_springs(mesh, 2.5 * material.mu_pa()), material,
                           {VolumeModel::kNodeSmoothed, StrainSize::kSmall, StrainLaw::kCorotated, 0.1});
    EXPECT_GT(built.theta, 0.1);
    EXPECT_EQ(built.warnings.size(), 1U);
    const Moduli& nodes = built.model.strain_terms.at(0).moduli;
    EXPECT_GE(3.0 * nodes.lambda_pa + 2.0 * nodes.mu_pa, -1e-9);
    const BuiltModel blend =
        build_blend_model(mesh, material, {StrainSize::kSmall, StrainLaw::kCorotated, 0.1});
    const Moduli& smoothed = blend.model.strain_terms.at(0).moduli;
    EXPECT_GE(3.0 * smoothed.lambda_pa + 2.0 * smoothed.mu_pa, -1e-9);
    // No random displacement has a negative energy.
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const std::vector<Vec3> u = testing_support::make_random_field(mesh.points.size(), 1e-3, seed);
      EXPECT_GT(elastic_energy(built.model, u), 0.0) << "nu " << nu << ", seed " << seed;
      EXPECT_GT(elastic_energy(blend.model, u), 0.0) << "nu " << nu << ", seed " << seed;
    }
  }
  EXPECT_EQ(build_blend_model(mesh, {1000.0, 0.1, 1.0}, {}).theta, BlendOptions{}.theta);
  // With the shear on edges, the dilatation at nodes has to be definite by itself.
  const SpringNetwork net = testing_support::make_edge_springs(mesh, 1000.0);
  SpringModelOptions edges{VolumeModel::kNodeSmoothed};
  edges.shear = StrainDomain::kEdge;
  edges.theta = 0.1;
  const BuiltModel at_edges = build_spring_model(mesh, net, {1000.0, 0.1, 1.0}, edges);
  EXPECT_NEAR(at_edges.theta, 0.75, 1e-12);  // lambda / mu = 2 nu / (1 - 2 nu) = 1/4
  EXPECT_NEAR(at_edges.model.strain_terms.at(0).moduli.lambda_pa, 0.0, 1e-9);
  EXPECT_THROW(build_spring_model(mesh, net, {1000.0, -0.1, 1.0}, edges), InputError);
}

TEST(VolumeModels, NamesAreReadBack) {
  for (const VolumeModel model : {VolumeModel::kNone, VolumeModel::kThesis, VolumeModel::kTet,
                                  VolumeModel::kNodeAverage, VolumeModel::kNodeSmoothed})
    EXPECT_EQ(parse_volume_model(volume_model_name(model)), model);
  EXPECT_THROW(parse_volume_model("pressure"), InputError);
}

}  // namespace
}  // namespace palpate::dynamics

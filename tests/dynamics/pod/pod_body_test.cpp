// Reduced bodies at large strain: basis, cubature, derivatives, training loads met, what is refused.
#include "core/dynamics/pod/pod_body.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/dynamics/pod/training_loads.h"
#include "core/dynamics/statics/static_equilibrium.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

FacePatch faces_at(const TetMesh& mesh, double z) {
  FacePatch patch{find_faces_at(mesh, 2, z), {}};
  patch.weight.assign(patch.faces.size(), 1.0);
  return patch;
}

/// A cube on an elastic bed, pressed and sheared from above by a pad, with the full model's answers to loads
/// that were drawn around it.
struct Trained {
  explicit Trained(std::size_t loads_wanted) : mesh(build_kuhn_cube(3, 0.2, 5)) {
    problem.material = {1000.0, 0.4, 1000.0};
    problem.strain = StrainSize::kLarge;
    problem.supports.push_back({faces_at(mesh, 0.0), 5e3, {}});
    problem.supports.push_back({faces_at(mesh, 1.0), 5e3, {0.1, 0.0, -0.2}});
    BlendOptions options;
    options.strain = StrainSize::kLarge;
    options.theta = 0.0;
    options.rest = StrainDomain::kEdge;
    model = build_blend_model(mesh, problem.material, options).model;
    SplitMix64 random(3);
    for (std::size_t k = 0; k < loads_wanted; ++k) {
      loads.push_back(build_loads(mesh, draw_training_load(problem, random)));
      snapshots.push_back(solve(loads.back()));
    }
    asked = build_loads(mesh, problem);
  }

  std::vector<Vec3> solve(const Loads& at) const {
    const StaticSolution found = solve_static(mesh, model, at, {});
    EXPECT_EQ(found.report.outcome, StaticOutcome::kConverged);
    return found.displacement_m;
  }

  TetMesh mesh;
  BoundaryProblem problem;
  ElasticModel model;
  std::vector<Loads> loads;
  std::vector<std::vector<Vec3>> snapshots;
  Loads asked;
};

double distance_relative(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  return field_distance(a, b) / field_norm(b);
}

TEST(SnapshotBasis, SpansItsSnapshotsAndNoMore) {
  const std::vector<Vec3> a = make_random_field(20, 1.0, 1);
  const std::vector<Vec3> b = make_random_field(20, 1.0, 2);
  std::vector<Vec3> both = a;
  for (std::size_t v = 0; v < both.size(); ++v) both[v] = 2.0 * a[v] - 3.0 * b[v];
  const SnapshotBasis basis = find_snapshot_basis(std::vector{a, b, both}, 10, 0.0);
  EXPECT_EQ(basis.shapes.cols(), 2);  // the third is a sum of the others
  EXPECT_LT(left_out_of(basis, both), 1e-14);
  EXPECT_GT(left_out_of(basis, make_random_field(20, 1.0, 3)), 0.5);
  EXPECT_LT(distance_relative(displacement_of(basis, coordinates_of(basis, a)), a), 1e-14);
  // One shape leaves out what the singular values say.
  const SnapshotBasis one = find_snapshot_basis(std::vector{a, b, both}, 1, 0.0);
  double left = 0.0;
  for (const auto& u : {a, b, both}) left += std::pow(left_out_of(one, u) * field_norm(u), 2);
  EXPECT_NEAR(std::sqrt(left), one.singular_values[1], 1e-12);
}

TEST(SnapshotBasis, ABrokenOneIsRejected) {
  const SnapshotBasis good =
      find_snapshot_basis(std::vector<std::vector<Vec3>>(1, make_random_field(8, 1.0, 1)), 1, 0.0);
  std::vector<std::uint8_t> held(8);
  EXPECT_NO_THROW(require_basis(good, held));
  EXPECT_THROW(require_basis(good, std::vector<std::uint8_t>(7)), InputError);
  SnapshotBasis broken = good;
  broken.shapes *= 1.001;
  EXPECT_THROW(require_basis(broken, held), InputError);
  broken = good;
  broken.shapes(3, 0) = std::nan("");
  EXPECT_THROW(require_basis(broken, held), InputError);
  held[2] = 2;  // y of vertex 2, which the shape moves
  EXPECT_THROW(require_basis(good, held), InputError);
  EXPECT_THROW(find_snapshot_basis({}, 1, 0.0), InputError);
  EXPECT_THROW(find_snapshot_basis(std::vector<std::vector<Vec3>>(1, std::vector<Vec3>(4)), 1, 0.0),
               InputError);
}

TEST(Cubature, NonnegativeLeastSquaresMeetTheirConditions) {
  SplitMix64 random(9);
  for (int k = 0; k < 20; ++k) {
    Eigen::MatrixXd a(12, 30);
    for (double& each : a.reshaped()) each = 2.0 * random.uniform() - 1.0;
    Eigen::VectorXd b(12);
    for (double& each : b) each = 2.0 * random.uniform() - 1.0;
    const std::vector<double> x = solve_nonnegative(a, b, 0.0);
    const Eigen::Map<const Eigen::VectorXd> found(x.data(), 30);
    // At the least squares over x >= 0 the slope is zero where x > 0 and not negative elsewhere.
    const Eigen::VectorXd slope = a.transpose() * (a * found - b);
    for (Eigen::Index i = 0; i < 30; ++i) {
      EXPECT_GE(found[i], 0.0);
      if (found[i] > 0.0) {
        EXPECT_NEAR(slope[i], 0.0, 1e-10);
      }
      EXPECT_GE(slope[i], -1e-10);
    }
  }
}

TEST(PodBody, ATrainingLoadIsMetToTheTruncation) {
  const Trained body(6);
  const SnapshotBasis whole = find_snapshot_basis(body.snapshots, 6, 0.0);
  const PodBody exact(body.model, whole, take_all_domains(body.model), body.asked);
  for (std::size_t k = 0; k < body.loads.size(); ++k) {
    const PodAnswer answer = exact.solve(body.loads[k], {1e-12, 100});
    ASSERT_TRUE(answer.converged);
    // The full solution, which is in the basis, is found to 1e-9 of its forces.
    EXPECT_LT(distance_relative(displacement_of(whole, answer.q), body.snapshots[k]), 1e-6);
  }
  const SnapshotBasis some = find_snapshot_basis(body.snapshots, 3, 0.0);
  const PodBody truncated(body.model, some, take_all_domains(body.model), body.asked);
  for (std::size_t k = 0; k < body.loads.size(); ++k) {
    const double left = left_out_of(some, body.snapshots[k]);
    const double off =
        distance_relative(displacement_of(some, truncated.solve(body.loads[k], {}).q), body.snapshots[k]);
    EXPECT_GE(off, left - 1e-12);  // the projection is the nearest there is
    EXPECT_LT(off, 10.0 * left);   // Cea: by the ratio of stiff to soft, whose root is some ten here
  }
}

TEST(PodBody, CubatureMeetsItsTrainingForces) {
  const Trained body(6);
  const SnapshotBasis basis = find_snapshot_basis(body.snapshots, 6, 0.0);
  for (const double tolerance : {1e-1, 1e-2, 1e-4}) {
    const Cubature cubature = fit_cubature(body.model, basis, body.snapshots, tolerance);
    EXPECT_LE(cubature.residual_relative, tolerance);
    EXPECT_LE(cubature.domains.size(), 36U);  // no more than there are forces to be met
    const PodBody all(body.model, basis, take_all_domains(body.model), body.asked);
    const PodBody few(body.model, basis, cubature, body.asked);
    double off = 0.0;
    for (const auto& u : body.snapshots) {
      const Eigen::VectorXd q = coordinates_of(basis, u);
      off += (few.gradient(q) - all.gradient(q)).squaredNorm() / all.gradient(q).squaredNorm();
    }
    EXPECT_NEAR(std::sqrt(off / 6.0), cubature.residual_relative, 1e-10);
    Cubature broken = cubature;
    for (WeighedDomain& each : broken.domains) each.weight = 1.0;
    const PodBody wrong(body.model, basis, broken, body.asked);
    const Eigen::VectorXd q = coordinates_of(basis, body.snapshots[0]);
    EXPECT_GT((wrong.gradient(q) - all.gradient(q)).norm(), 0.5 * all.gradient(q).norm());
  }
}

TEST(PodBody, GradientAndTangentAreDerivatives) {
  const Trained body(4);
  const SnapshotBasis basis = find_snapshot_basis(body.snapshots, 4, 0.0);
  const PodBody pod(body.model, basis, fit_cubature(body.model, basis, body.snapshots, 1e-3), body.asked);
  const Eigen::VectorXd q = 0.7 * coordinates_of(basis, body.snapshots[1]);
  const Eigen::VectorXd slope = pod.gradient(q);
  const Eigen::MatrixXd curve = pod.tangent(q, false);
  const double step = 1e-5;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    Eigen::VectorXd more = q;
    Eigen::VectorXd less = q;
    more[i] += step;
    less[i] -= step;
    EXPECT_NEAR((pod.energy(more) - pod.energy(less)) / (2.0 * step), slope[i], 1e-7 * slope.norm());
    const Eigen::VectorXd column = (pod.gradient(more) - pod.gradient(less)) / (2.0 * step);
    EXPECT_LT((column - curve.col(i)).norm(), 1e-7 * curve.norm());
  }
}

TEST(PodBody, UnseenLoadsAreMetAndUnseenSupportsRefused) {
  const Trained body(10);
  const SnapshotBasis basis = find_snapshot_basis(body.snapshots, 10, 0.0);
  const PodBody pod(body.model, basis, fit_cubature(body.model, basis, body.snapshots, 1e-3), body.asked);
  const PodAnswer answer = pod.solve(body.asked, {});
  ASSERT_TRUE(answer.converged);
  // It was drawn around, never seen: with ten snapshots within some percent.
  EXPECT_LT(distance_relative(displacement_of(basis, answer.q), body.solve(body.asked)), 0.05);

  BoundaryProblem other = body.problem;
  other.supports[0].stiffness_pa_per_m *= 2.0;
  EXPECT_THROW(pod.solve(build_loads(body.mesh, other), {}), InputError);
  other = body.problem;
  other.supports.pop_back();
  EXPECT_THROW(pod.solve(build_loads(body.mesh, other), {}), InputError);
  other = body.problem;
  other.held.push_back({find_faces_at(body.mesh, 0, 0.0), {true, true, true}, {}});
  EXPECT_THROW(pod.solve(build_loads(body.mesh, other), {}), InputError);
}

TEST(TrainingLoads, KeepPlacesAndAreRefusedWhereNothingLoads) {
  const Trained body(0);
  SplitMix64 random(1);
  for (int k = 0; k < 20; ++k) {
    const BoundaryProblem drawn = draw_training_load(body.problem, random);
    const double share = length(drawn.supports[1].by_m) / length(body.problem.supports[1].by_m);
    EXPECT_GE(share, 0.2);
    EXPECT_LE(share, 1.2);
    const double cosine = dot(drawn.supports[1].by_m, body.problem.supports[1].by_m) /
                          (share * length_sq(body.problem.supports[1].by_m));
    EXPECT_GE(cosine, std::sqrt(0.5) - 1e-12);
    EXPECT_EQ(length(drawn.supports[0].by_m), 0.0);
  }
  BoundaryProblem still = body.problem;
  still.supports.pop_back();
  EXPECT_THROW(draw_training_load(still, random), InputError);
}

}  // namespace
}  // namespace palpate::dynamics

// A body under a finger: what a pad takes hold of, what it does in every engine, and how the body comes back.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "live/body/live_answer.h"
#include "live/body/live_body.h"
#include "live/body/pad.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/live_cases.h"

namespace palpate::live {
namespace {

using testing_support::field_distance;
using testing_support::field_norm;
using testing_support::linear_tets;
using testing_support::make_live_cube;
using testing_support::top_vertex;

constexpr double kPadPaPerM = 5e6;
constexpr double kRadiusM = 0.015;

double area_of(const TetMesh& mesh, const FacePatch& patch) {
  double sum = 0.0;
  for (std::size_t f = 0; f < patch.faces.size(); ++f) {
    const auto [a, b, c] = patch.faces[f];
    sum += 0.5 * patch.weight[f] *
           length(cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]));
  }
  return sum;
}

/// Presses the top's middle down by 3 mm, and waits until little moves.
void press_to_rest(LiveBody& body, const TetMesh& mesh) {
  body.press(top_vertex(mesh), kRadiusM, kPadPaPerM);
  body.aim({0.0, 0.0, -0.003}, 0.1);
  const double step_s = 0.9 * body.predict_step(kPadPaPerM).step_s;
  for (int k = 0; k < 40; ++k) ASSERT_TRUE(body.step(step_s, static_cast<std::uint64_t>(0.05 / step_s)));
}

TEST(LivePad, OfManyFacesHasTheAreaOfItsDisc) {
  const BodySetup setup = make_live_cube(16);
  const std::vector<Triangle> skin = build_boundary(setup.mesh);
  const FacePatch patch = find_pad(setup.mesh.points, skin, {0.03, 0.03, 0.06}, {0.0, 0.0, 1.0}, kRadiusM);
  const double disc = 3.14159265358979 * kRadiusM * kRadiusM;
  EXPECT_NEAR(area_of(setup.mesh, patch), disc, 0.01 * disc);  // 64 parts a face, some 100 faces
}

TEST(LivePad, HoldsNothingThatLooksAway) {
  const BodySetup setup = make_live_cube(4);
  const std::vector<Triangle> skin = build_boundary(setup.mesh);
  const Vec3 up{0.0, 0.0, 1.0};
  const FacePatch patch =
      find_pad(setup.mesh.points, skin, {0.03, 0.03, 0.06}, up, 0.2);  // larger than the body
  for (const auto& [a, b, c] : patch.faces) {
    const std::vector<Vec3>& p = setup.mesh.points;
    EXPECT_GT(dot(cross(p[b] - p[a], p[c] - p[a]), up), 0.0);
  }
  EXPECT_NEAR(area_of(setup.mesh, patch), 0.06 * 0.06, 1e-12);
}

TEST(LivePad, OfARadiusBelowAFaceTakesTheNearestFace) {
  const BodySetup setup = make_live_cube(2);
  const std::vector<Triangle> skin = build_boundary(setup.mesh);
  const FacePatch patch = find_pad(setup.mesh.points, skin, {0.03, 0.03, 0.06}, {0.0, 0.0, 1.0}, 1e-6);
  EXPECT_EQ(patch.faces.size(), 1u);
  EXPECT_EQ(patch.weight, std::vector<double>{1.0});
}

TEST(LiveBody, PressedMovesWithTheFingerAndComesBackOnceItIsLetGo) {
  const BodySetup setup = make_live_cube(4);
  for (const bool is_smoothed : {false, true}) {
    ModelChoice choice;
    choice.is_smoothed = is_smoothed;
    choice.spring.strain = choice.blend.strain = StrainSize::kLarge;
    LiveBody body(setup, choice);
    EXPECT_EQ(body.stepper().engine, is_smoothed ? "tets" : "springs");
    press_to_rest(body, setup.mesh);
    const Index top = top_vertex(setup.mesh);
    EXPECT_LT(body.state().displacement_m[top].z, -0.002);
    EXPECT_LT(body.report().pad_force_n.z, -0.01);
    body.release();
    ASSERT_TRUE(
        body.step(1e-4, 20000));  // 2 s: exp(-30 x 2) of the slowest overdamped mode is below rounding
    // In single precision a vertex stands still once it moves by less than half a last bit of its place in a
    // step: 1 nm in 0.1 ms. Its drag, 60 m v, then holds it off by 60 v / omega^2, with omega = 40 / s of the
    // slowest mode.
    EXPECT_LT(body.report().largest_m, 60.0 * 1e-5 / (40.0 * 40.0) * 5.0);
    EXPECT_EQ(length(body.report().pad_force_n), 0.0);
  }
}

TEST(LiveBody, SlidingToWhereItIsChangesNothingAndElsewhereMovesTheDent) {
  for (const auto kind :
       {dynamics::IntegratorKind::kSymplecticEuler, dynamics::IntegratorKind::kVelocityVerlet}) {
    const BodySetup setup = make_live_cube(6);
    ModelChoice choice = linear_tets();
    choice.integrator = kind;
    LiveBody still(setup, choice);
    LiveBody sliding(setup, choice);
    const double step_s = 0.9 * still.predict_step(kPadPaPerM).step_s;
    for (LiveBody* body : {&still, &sliding}) press_to_rest(*body, setup.mesh);
    sliding.slide(top_vertex(setup.mesh), kRadiusM, kPadPaPerM);
    for (LiveBody* body : {&still, &sliding}) ASSERT_TRUE(body->step(step_s, 50));
    for (std::size_t v = 0; v < setup.mesh.points.size();
         ++v) {  // Verlet begins anew, with forces of this moment
      const Vec3 apart = sliding.state().displacement_m[v] - still.state().displacement_m[v];
      EXPECT_LT(length_sq(apart), 1e-24) << "a picometre";
    }

    Index corner = 0;  // of the top, farthest from its middle
    double farthest_sq = 0.0;
    for (Index v = 0; v < setup.mesh.points.size(); ++v) {
      const Vec3 away = setup.mesh.points[v] - setup.mesh.points[top_vertex(setup.mesh)];
      if (away.z == 0.0 && length_sq(away) > farthest_sq) {
        farthest_sq = length_sq(away);
        corner = v;
      }
    }
    sliding.slide(corner, kRadiusM, kPadPaPerM);
    EXPECT_EQ(sliding.pad_by_m(), still.pad_by_m());
    for (int k = 0; k < 40; ++k) ASSERT_TRUE(sliding.step(step_s, static_cast<std::uint64_t>(0.05 / step_s)));
    EXPECT_LT(sliding.state().displacement_m[corner].z, -0.001);
    EXPECT_GT(sliding.state().displacement_m[top_vertex(setup.mesh)].z,
              0.5 * still.state().displacement_m[top_vertex(setup.mesh)].z);
  }
}

TEST(LiveBody, SlidesOnlyWithAPadOnTheSkin) {
  const BodySetup setup = make_live_cube(3);
  LiveBody body(setup, linear_tets());
  EXPECT_THROW(body.slide(top_vertex(setup.mesh), kRadiusM, kPadPaPerM), InputError);
  body.press(top_vertex(setup.mesh), kRadiusM, kPadPaPerM);
  body.release();
  EXPECT_THROW(body.slide(top_vertex(setup.mesh), kRadiusM, kPadPaPerM), InputError);
}

TEST(LiveBody, AtRestTheFingerBalancesTheSupports) {
  const BodySetup setup = make_live_cube(4);
  LiveBody body(setup, linear_tets());
  press_to_rest(body, setup.mesh);
  Vec3 support;
  for (const dynamics::SupportFace& face : body.model().loads.front().loads.supports) {
    for (const Index v : face.face)
      support = support - (4.0 * face.coefficient_n_per_m) * body.state().displacement_m[v];
  }
  const Vec3 pad = body.report().pad_force_n;
  EXPECT_GT(length(pad), 0.05);
  EXPECT_LT(length(pad + support), 1e-3 * length(pad));
}

/// The fast engines' pad and the supports of the general forces are the same thing.
TEST(LiveBody, TheFastEnginesFeelThePadAsTheGeneralForcesDo) {
  const BodySetup setup = make_live_cube(4);
  for (const bool is_smoothed : {false, true}) {
    ModelChoice fast;
    fast.is_smoothed = is_smoothed;
    fast.spring.strain = fast.blend.strain = StrainSize::kLarge;
    LiveBody body(setup, fast);
    ModelChoice slow = fast;
    slow.integrator = dynamics::IntegratorKind::kVelocityVerlet;
    LiveBody general(setup, slow);
    EXPECT_EQ(general.stepper().engine, "general");
    EXPECT_EQ(general.stepper().why_general, "velocity_verlet");
    press_to_rest(body, setup.mesh);
    press_to_rest(general, setup.mesh);
    const std::vector<Vec3> u = body.state().displacement_m;
    // Both at rest, so the integrators agree; what is left is single precision and the last of the motion.
    EXPECT_LT(field_distance(u, general.state().displacement_m), 1e-3 * field_norm(u));
    EXPECT_LT(length(body.report().pad_force_n - general.report().pad_force_n),
              2e-3 * length(general.report().pad_force_n));
    body.press(top_vertex(setup.mesh), 2.0 * kRadiusM, kPadPaPerM);  // another pad, in the place of the first
    EXPECT_EQ(length(body.pad_by_m()), 0.0);
  }
}

TEST(LiveBody, BreaksWithAStepThatIsTooLongAndSaysWhere) {
  const BodySetup setup = make_live_cube(4);
  LiveBody body(setup, linear_tets());  // whose growth nothing ends
  const double bound_s = body.predict_step(0.0).step_s;
  body.press(top_vertex(setup.mesh), kRadiusM, kPadPaPerM);
  body.aim({0.0, 0.0, -0.003}, 0.1);
  EXPECT_FALSE(body.step(1.5 * bound_s, 100000));
  const LiveReport report = body.report();
  EXPECT_TRUE(report.is_broken);
  ASSERT_LT(report.vertex, setup.mesh.points.size());
  EXPECT_FALSE(body.step(0.1 * bound_s, 1));  // it stays broken ...
  body.reset();
  EXPECT_TRUE(body.step(0.9 * bound_s, 100));  // ... until it is put back
  EXPECT_EQ(body.report().largest_m, 0.0);
}

TEST(LiveBody, TheBoundHoldsForAFingerAnywhere) {
  const BodySetup setup = make_live_cube(3);
  const LiveBody body(setup, linear_tets());
  const double without_s = body.predict_step(0.0).step_s;
  const double with_s = body.predict_step(kPadPaPerM).step_s;
  EXPECT_LT(with_s, without_s);
  LiveBody pressed(setup, linear_tets());
  for (const Index v : {Index{0}, top_vertex(setup.mesh)}) {
    pressed.press(v, 0.05, kPadPaPerM);
    EXPECT_LE(with_s,
              predict_stable_step(pressed.model(), dynamics::IntegratorKind::kSymplecticEuler).step_s *
                  (1.0 + 1e-3));
  }
}

TEST(LiveBody, RefusesWhatMakesNoSense) {
  BodySetup setup = make_live_cube(2);
  LiveBody body(setup, ModelChoice{});
  const auto inner = static_cast<Index>(13);  // the middle of 3 x 3 x 3 vertices
  EXPECT_THROW(body.press(inner, kRadiusM, kPadPaPerM), InputError);
  EXPECT_THROW(body.press(0, 0.0, kPadPaPerM), InputError);
  EXPECT_THROW(body.press(0, kRadiusM, std::numeric_limits<double>::quiet_NaN()), InputError);
  EXPECT_THROW(body.step(0.0, 1), InputError);
  setup.springs = {};
  EXPECT_THROW(LiveBody(setup, ModelChoice{}), InputError);
  EXPECT_NO_THROW(LiveBody(setup, linear_tets()));
}

/// The table of linear elements is those elements: the body of linear tets comes to rest at its answer.
TEST(LiveAnswer, IsWhereABodyOfTheSameElementsComesToRest) {
  const BodySetup setup = make_live_cube(4);
  LiveBody body(setup, linear_tets());
  press_to_rest(body, setup.mesh);
  dynamics::ComplianceOptions options;
  options.element_order = 1;
  options.poisson_ratio = setup.holding.material.poisson_ratio;
  dynamics::ComplianceSetup made;
  dynamics::ComplianceTable table =
      build_compliance_table(setup.mesh, options, dynamics::factor_simplicial, made);
  table.field.resize(9 * table.nodes.size() * table.nodes.size());  // the skin's rows are enough
  LiveAnswer answer(setup.mesh, to_single(table), setup.holding);
  EXPECT_EQ(length(answer.pad_force({0.0, 0.0, -0.003})), 0.0);  // nothing presses yet
  answer.press(body.pad(), kPadPaPerM);
  const std::vector<Vec3> u = answer.displacement({0.0, 0.0, -0.003});
  std::vector<Vec3> moved;
  for (const Index v : answer.vertices()) moved.push_back(body.state().displacement_m[v]);
  EXPECT_LT(field_distance(u, moved), 2e-3 * field_norm(u));
  EXPECT_LT(length(answer.pad_force({0.0, 0.0, -0.003}) - body.report().pad_force_n),
            2e-3 * length(body.report().pad_force_n));
  // It is linear, and a pad that is let go leaves nothing.
  EXPECT_LT(field_distance(answer.displacement({0.0, 0.0, 0.003}), u), 2.0001 * field_norm(u));
  answer.release();
  EXPECT_EQ(field_norm(answer.displacement({0.0, 0.0, -0.003})), 0.0);
}

}  // namespace
}  // namespace palpate::live

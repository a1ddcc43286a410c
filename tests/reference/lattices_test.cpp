// lattice.* and moving_lattice.* as the runner starts them: patches, bars and rods that are known, bad
// options, and what they refuse.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "core/judge/displacement/displacement.h"
#include "core/mesh/topology.h"
#include "experiments/contestants/contestant_run.h"
#include "reference/closed_form/known_cases.h"
#include "reference/closed_form/structured_mesh.h"
#include "reference/door/deform_problem.h"
#include "reference/door/motion_problem.h"
#include "tests/support/moving_contestant.h"
#include "tests/support/rod.h"

namespace palpate::reference {
namespace {

using experiments::ContestantAnswer;
using nlohmann::json;
using test::column;
using test::Rod;
using testing::HasSubstr;

constexpr std::array<const char*, 2> kKinds{"hexahedral", "bcc"};

/// A bar between pads that is pressed on its sides so that it moves along x alone: u = (a + e x, 0, 0).
KnownCase build_pressed_bar(double poisson_ratio) {
  constexpr double kLength = 0.04;
  constexpr double kWidth = 0.01;
  constexpr double kStrain = 0.02;
  constexpr double kPads = 1e6;
  KnownCase known;
  known.mesh = build_mapped_block({7, 3, 2}, [](const Vec3& p) {
    return Vec3{kLength * p.x, kWidth * p.y, kWidth * p.z};
  });
  const Material material{1e4, poisson_ratio, 1000.0};
  known.problem.material = material;
  const auto patch = [&](auto&& holds) {
    std::vector<Triangle> faces = select_boundary(known.mesh, holds);
    std::vector<double> weight(faces.size(), 1.0);
    return FacePatch{std::move(faces), std::move(weight)};
  };
  const auto is = [](double a, double b) { return std::fabs(a - b) < 1e-12; };
  // A pad moves the far end; the near one gives way by the same stress.
  const double stress = (material.lambda_pa() + 2.0 * material.mu_pa()) * kStrain;
  const double across = material.lambda_pa() * kStrain;
  const double near = stress / kPads;
  known.problem.supports = {{patch([&](const Vec3& p) { return is(p.x, 0.0); }), kPads, {}},
                            {patch([&](const Vec3& p) { return is(p.x, kLength); }),
                             kPads,
                             {2.0 * near + kStrain * kLength, 0, 0}}};
  for (const double side : {0.0, kWidth}) {
    const double sign = side > 0.0 ? 1.0 : -1.0;
    known.problem.tractions.push_back(
        {patch([&](const Vec3& p) { return is(p.y, side); }), {0, sign * across, 0}, 0.0});
    known.problem.tractions.push_back({patch([&](const Vec3& p) { return is(p.z, side); }), {}, -across});
  }
  known.displacement = [near](const Vec3& x) { return Vec3{near + kStrain * x.x, 0, 0}; };
  return known;
}

class LatticeContestant : public test::MovingContestant {
 protected:
  ContestantAnswer ask(const std::string& kind, const KnownCase& known,
                       const json& options = json::object()) {
    return starter_.run("lattice." + kind, known.mesh, problem_to_json(known.problem), options);
  }

  std::vector<Vec3> displacement(const KnownCase& known, const ContestantAnswer& answer) {
    EXPECT_EQ(answer.outcome, "ok") << answer.message;
    if (answer.outcome != "ok") return {};
    EXPECT_EQ(answer.report.at("outcome"), "converged");
    return read_displacement(answer.output, known.mesh.points.size(), build_edges(known.mesh).size());
  }

  static std::vector<Vec3> exact(const KnownCase& known) {
    std::vector<Vec3> truth;
    for (const Vec3& x : known.mesh.points) truth.push_back(known.displacement(x));
    return truth;
  }

  /// The judge's relative L2 error.
  static double judged(const KnownCase& known, std::vector<Vec3> u) {
    u.resize(known.mesh.points.size());
    const Material& material = known.problem.material;
    return judge::compare_displacement(known.mesh, u, exact(known), material.lambda_pa(), material.mu_pa())
        .relative_l2;
  }
};

// The patch test: whole cells fill the bar, its mesh has other vertices than the lattice.
TEST_F(LatticeContestant, HaveAUniformStrainThroughSupportsTractionsAndPads) {
  for (const char* kind : kKinds) {
    for (const double ratio : {0.25, 0.45}) {
      const KnownCase known = build_pressed_bar(ratio);
      const ContestantAnswer answer = ask(kind, known, {{"spacing_m", 0.005}, {"volume", "cell"}});
      const std::vector<Vec3> u = displacement(known, answer);
      ASSERT_EQ(u.size(), known.mesh.points.size());
      EXPECT_LT(judged(known, u), 1e-10) << kind << " " << ratio;
      EXPECT_EQ(answer.report.at("cut_cells"), 0);
      const Material& m = known.problem.material;
      const double energy = 0.5 * (m.lambda_pa() + 2.0 * m.mu_pa()) * 0.02 * 0.02 * 4e-6;
      EXPECT_NEAR(answer.report.at("energy_j").get<double>(), energy, 1e-9 * energy);
      const double force = (m.lambda_pa() + 2.0 * m.mu_pa()) * 0.02 * 1e-4;
      EXPECT_NEAR(answer.report.at("support_forces_n")[1][0].get<double>(), force, 1e-9 * force);
      EXPECT_NEAR(answer.report.at("support_forces_n")[0][0].get<double>(), -force, 1e-9 * force);
    }
  }
}

TEST_F(LatticeContestant, TheJudgeRejectsBrokenAnswersToThePatch) {
  const KnownCase known = build_pressed_bar(0.45);
  // Springs alone have another Poisson's ratio; cells that stick out make the bar thicker; a moved field.
  EXPECT_GT(judged(known, displacement(known, ask("hexahedral", known, {{"spacing_m", 0.005}}))), 0.01);
  const json sticking_out{{"spacing_m", 0.006}, {"volume", "cell"}, {"boundary", "keep"}};
  EXPECT_GT(judged(known, displacement(known, ask("hexahedral", known, sticking_out))), 0.01);
  const json good{{"spacing_m", 0.005}, {"volume", "cell"}};
  std::vector<Vec3> u = displacement(known, ask("hexahedral", known, good));
  for (Vec3& v : u) v = 1.001 * v;
  EXPECT_NEAR(judged(known, u), 1e-3, 1e-9);
}

// A bar that hangs from a flat hold: its end face sinks by g rho L^2 / (2 E) in the mean, by reciprocity with
// a bar that is pulled there, whose field is linear. So a lattice has it to rounding, and the penalty p E / h
// adds g rho L h / (p E).
TEST_F(LatticeContestant, AHangingBarSinksAsItsWeightSays) {
  KnownCase known = build_known_case("bar_own_weight", 6);
  known.problem.material.poisson_ratio = 0.25;
  known.problem.held[0].axes = {true, false, false};
  const auto on = [&](double Vec3::*axis, double at) {
    return select_boundary(known.mesh, [&](const Vec3& p) { return std::fabs(p.*axis - at) < 1e-12; });
  };
  known.problem.held.push_back({on(&Vec3::y, 0.0), {false, true, false}, {}});
  known.problem.held.push_back({on(&Vec3::z, 0.0), {false, false, true}, {}});
  const Material& m = known.problem.material;
  const double scale = m.density_kg_m3 * 9.81 / m.young_modulus_pa;
  for (const char* kind : kKinds) {
    for (const double penalty : {100.0, 1e4}) {
      const double spacing = 0.005;
      const std::vector<Vec3> u =
          displacement(known, ask(kind, known, {{"spacing_m", spacing}, {"held_stiffness", penalty}}));
      ASSERT_EQ(u.size(), known.mesh.points.size());
      double mean = 0.0;
      const std::vector<Triangle> end = on(&Vec3::x, 0.04);
      for (const Triangle& face : end) mean += (u[face[0]].x + u[face[1]].x + u[face[2]].x) / 3.0;
      mean /= static_cast<double>(end.size());
      const double without_penalty = scale * 0.5 * 0.04 * 0.04;
      const double expected = without_penalty + scale * 0.04 * spacing / penalty;
      EXPECT_NEAR(mean, expected, 1e-3 * expected) << kind;
      if (penalty == 100.0) {
        EXPECT_GT(std::fabs(mean - without_penalty), 1e-3 * expected);
      }
      RecordProperty(std::string(kind) + "_" + std::to_string(penalty),
                     std::to_string(mean / expected - 1.0));
    }
  }
}

TEST_F(LatticeContestant, HaveTheDeflectionOfACantilever) {
  for (const char* kind : kKinds) {
    double before = 1.0;
    for (const double spacing : {0.005, 0.0025}) {
      const KnownCase known = build_known_case("cantilever", 4);
      const std::vector<Vec3> u =
          displacement(known, ask(kind, known, {{"spacing_m", spacing}, {"held_stiffness", 1e4}}));
      ASSERT_EQ(u.size(), known.mesh.points.size());
      const double error = std::fabs(u[known.value->vertex].z / known.value->value - 1.0);
      RecordProperty(std::string(kind) + "_" + std::to_string(spacing), std::to_string(error));
      EXPECT_LT(error, 0.5 * before) << kind;
      before = error;
    }
  }
}

TEST_F(LatticeContestant, BoundaryOptionsOrderTheStiffnessOfABar) {
  // 2.5 cells across, 10 along: whole cells are too stiff, fewer too soft, weights in between.
  KnownCase known = build_pressed_bar(0.25);
  known.problem.supports.pop_back();
  known.problem.tractions.clear();
  known.problem.tractions.push_back({known.problem.supports[0].patch, {-1.0, 0, 0}, 0.0});
  const std::vector<Triangle> far =
      select_boundary(known.mesh, [](const Vec3& p) { return std::fabs(p.x - 0.04) < 1e-12; });
  known.problem.tractions = {{{far, std::vector<double>(far.size(), 1.0)}, {0, 0, 1.0}, 0.0}};
  const auto bend = [&](const char* kind, const char* boundary) {
    const json options{{"spacing_m", 0.004}, {"boundary", boundary}, {"fraction", 0.6}};
    json own = options;
    if (std::string(boundary) != "remove") own.erase("fraction");
    const std::vector<Vec3> u = displacement(known, ask(kind, known, own));
    double most = 0.0;
    for (const Vec3& v : u) most = std::max(most, v.z);
    return most;
  };
  for (const char* kind : kKinds) {
    EXPECT_LT(bend(kind, "keep"), bend(kind, "weight")) << kind;
    EXPECT_LT(bend(kind, "weight"), bend(kind, "remove")) << kind;
  }
}

TEST_F(LatticeContestant, WriteMidpointsWhenAsked) {
  const KnownCase known = build_pressed_bar(0.25);
  const std::size_t vertices = known.mesh.points.size();
  const std::size_t edges = build_edges(known.mesh).size();
  EXPECT_EQ(displacement(known, ask("bcc", known, {{"midpoints", true}})).size(), vertices + edges);
  EXPECT_EQ(displacement(known, ask("bcc", known)).size(), vertices);
}

TEST_F(LatticeContestant, RefuseWhatTheyCannotDo) {
  KnownCase known = build_pressed_bar(0.25);
  const auto refused = [&](const char* kind, const json& options) {
    const ContestantAnswer answer = ask(kind, known, options);
    EXPECT_EQ(answer.outcome, "bad_input") << options;
    return answer.message;
  };
  EXPECT_THAT(refused("hexahedral", {{"boundary", "cut"}}), HasSubstr("keep"));
  EXPECT_THAT(refused("hexahedral", {{"body_share", 1.0}}), HasSubstr("body_share"));
  EXPECT_THAT(refused("bcc", {{"body_share", 0.5}}), HasSubstr("body_share"));
  EXPECT_THAT(refused("hexahedral", {{"face_share", 0.5}}), HasSubstr("face_share"));
  EXPECT_THAT(refused("bcc", {{"spacing_m", 1e-6}}), HasSubstr("2^25"));
  EXPECT_THAT(refused("bcc", {{"spacing_m", 0.1}, {"boundary", "remove"}}), HasSubstr("none"));
  known.problem.material.poisson_ratio = 0.2;
  EXPECT_THAT(refused("hexahedral", {{"volume", "cell"}}), HasSubstr("below 0.25"));
  known.problem.supports.clear();
  EXPECT_THAT(refused("hexahedral", json::object()), HasSubstr("translation"));
}

TEST_F(LatticeContestant, RefuseLargeStrainAndSayWhatTheyLeaveOut) {
  KnownCase known = build_pressed_bar(0.45);
  const ContestantAnswer plain = ask("bcc", known);
  ASSERT_EQ(plain.outcome, "ok") << plain.message;
  ASSERT_EQ(plain.notes.size(), 1U);
  EXPECT_THAT(plain.notes[0], HasSubstr("volume: cell"));
  EXPECT_TRUE(ask("bcc", known, {{"volume", "cell"}}).notes.empty());
  known.problem.strain = StrainSize::kLarge;
  const ContestantAnswer large = ask("bcc", known);
  EXPECT_EQ(large.outcome, "bad_input");
  EXPECT_THAT(large.message, HasSubstr("linear here"));
}

TEST_F(LatticeContestant, TheSameRequestGivesTheSameBytes) {
  const KnownCase known = build_pressed_bar(0.25);
  const auto bytes = [&] {
    std::ifstream file(ask("bcc", known, {{"turn_deg", 10.0}}).output);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string first = bytes();
  EXPECT_FALSE(first.empty());
  EXPECT_EQ(first, bytes());
}

// Lumped masses make the frequencies of a rod too low by (k h)^2 / 24, k = pi / (2 L); what holds it gives by
// h / p.
TEST_F(LatticeContestant, FrequenciesOfARodHeldAtOneEnd) {
  for (const char* kind : kKinds) {
    Rod rod(8);
    rod.hold_left();
    rod.problem.frequencies = 3;
    rod.problem.duration_s = 1e-3;
    move(std::string("moving_lattice.") + kind, rod, {{"spacing_m", 0.00625}, {"held_stiffness", 1000.0}});
    const double exact = rod.wave_speed_m_s() / (4.0 * Rod::kLengthM);
    EXPECT_NEAR(report_.at("frequencies_hz")[0].get<double>() / exact, 1.0, 5e-3) << kind;
    EXPECT_EQ(report_.at("frequencies_hz").size(), 3U);
  }
}

TEST_F(LatticeContestant, ToolForceEndsAtTheStaticReaction) {
  for (const char* kind : kKinds) {
    const test::PushedRod rod;
    const double spacing = 0.0125;
    const double penalty = 1e5;
    const MotionHistory history = move(std::string("moving_lattice.") + kind, rod,
                                       {{"spacing_m", spacing}, {"held_stiffness", penalty}});
    // Three springs in a row, per area: the pad, the rod, and what holds it. The walls give way by some h /
    // (p W).
    const double expected = rod.pad_force_n(penalty * 1e4 / spacing);
    EXPECT_NEAR(column(history, "tool_1_fx_n").back(), expected, 3e-5 * std::fabs(expected)) << kind;
    EXPECT_LT(report_.at("time_step_s"), report_.at("stable_step_s"));
  }
}

// Without damping the energy of a body that was let go stays; loads that are gone do no work.
TEST_F(LatticeContestant, KeepTheEnergyOfARodThatIsLetGo) {
  for (const char* kind : kKinds) {
    Rod rod(8);
    rod.hold_left();
    MotionLoad pluck = rod.sine_force(1000.0);
    pluck.profile = {{0.0, 0.1}, {0.0, 1.0}, true};
    pluck.until_s = 0.1;
    rod.problem.loads = {pluck};
    rod.problem.duration_s = 0.4;
    const MotionHistory history =
        move(std::string("moving_lattice.") + kind, rod, {{"spacing_m", 0.00625}, {"safety", 0.3}});
    const std::vector<double> time = column(history, "time_s");
    const std::vector<double> total = column(history, "total_j");
    double least = 1e300;
    double most = 0.0;
    for (std::size_t k = 0; k < time.size(); ++k) {
      if (time[k] <= 0.1) continue;
      least = std::min(least, total[k]);
      most = std::max(most, total[k]);
    }
    EXPECT_GT(least, 0.0);
    EXPECT_LT(most / least - 1.0, 0.02) << kind;
    EXPECT_EQ(time.back(), 0.4);
  }
}

TEST_F(LatticeContestant, RefuseStepsBeyondTheBoundInMotion) {
  Rod rod(6);
  rod.hold_left();
  rod.problem.duration_s = 0.01;
  move("moving_lattice.bcc", rod);
  const double bound = report_.at("stable_step_s").get<double>();
  const ContestantAnswer answer = starter_.run("moving_lattice.bcc", rod.mesh, motion_to_json(rod.problem),
                                               {{"time_step_s", 1.01 * bound}});
  EXPECT_EQ(answer.outcome, "bad_input");
  EXPECT_THAT(answer.message, HasSubstr("at most the stable step"));
  move("moving_lattice.bcc", rod, {{"time_step_s", 0.99 * bound}});
  rod.problem.body.strain = StrainSize::kLarge;
  EXPECT_THAT(starter_.run("moving_lattice.bcc", rod.mesh, motion_to_json(rod.problem)).message,
              HasSubstr("linear here"));
}

}  // namespace
}  // namespace palpate::reference

#include "core/dynamics/tet_engine/tet_engine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/time_loop/body_stepper.h"
#include "core/dynamics/time_loop/plain_run.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/engine_comparison.h"
#include "tests/support/law_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

constexpr std::array kTurning{StrainLaw::kCorotated, StrainLaw::kNeoHookean, StrainLaw::kStableNeoHookean};
constexpr std::array kKinds{Continuum::kTets, Continuum::kEdgeNode};

/// A body and how it starts.
struct Thrown {
  MotionModel model;
  MotionState start;
};

/// A cube of 2744 vertices, two blocks, damped by strain and against the environment, held below and thrown
/// at random.
Thrown make_thrown(Continuum kind, StrainLaw law, double damping_s = 1e-3, int cells = 13) {
  const TetMesh mesh = build_kuhn_cube(cells, 0.2, 5);
  Thrown out{make_continuum(make_pressed_body(mesh, 1.0), mesh, kind, law), {}};
  out.model.loads.pop_back();
  out.model.strain_damping_s = damping_s;
  out.start = start_at_rest(out.model);
  out.start.velocity_m_s = make_random_field(mesh.points.size(), 0.05, 3);
  MotionForces forces(out.model, 1);
  forces.impose(0.0, out.start.displacement_m, out.start.velocity_m_s);
  return out;
}

Thrown make_free(Continuum kind, StrainLaw law, double damping_s) {
  const TetMesh mesh = build_kuhn_cube(13, 0.2, 5);
  Thrown out{make_continuum(make_free_body(mesh, damping_s), mesh, kind, law), {}};
  out.start = start_at_rest(out.model);
  return out;
}

/// The change of velocities in one step of 1 s: force over mass.
template <typename Real>
std::vector<Vec3> find_accelerations(const Thrown& body, const PlainOptions& options = {}) {
  TetEngine<Real> engine(body.model, options);
  engine.set_state(body.start);
  engine.step(1.0, 1);
  std::vector<Vec3> out = engine.state().velocity_m_s;
  for (std::size_t v = 0; v < out.size(); ++v) out[v] = out[v] - body.start.velocity_m_s[v];
  return out;
}

std::vector<Vec3> expected_accelerations(const Thrown& body) {
  MotionForces forces(body.model, 1);
  std::vector<Vec3> out(body.model.mass_kg.size());
  forces.evaluate(body.start.displacement_m, body.start.velocity_m_s, 0.0, out);
  for (std::size_t v = 0; v < out.size(); ++v)
    out[v] = forces.held_bits()[v] == 7 ? Vec3{} : (1.0 / body.model.mass_kg[v]) * out[v];
  return out;
}

TEST(TetEngine, ForcesAreThoseOfMotionForces) {
  for (const Continuum kind : kKinds) {
    for (const StrainLaw law : kLaws) {
      for (const double damping : {0.0, 0.01}) {
        Thrown body = make_thrown(kind, law, damping);
        body.start.displacement_m = make_random_field(body.model.mass_kg.size(), 0.004, 7);
        MotionForces(body.model, 1).impose(0.0, body.start.displacement_m, body.start.velocity_m_s);
        const std::vector<Vec3> expected = expected_accelerations(body);
        // Gradients of size 1/edge and the forces of some twenty domains, each to some forty roundings.
        const double size = field_norm(expected);
        EXPECT_LT(field_distance(find_accelerations<double>(body), expected), 1e-13 * size)
            << strain_law_name(law);
        EXPECT_LT(field_distance(find_accelerations<float>(body), expected), 1e-5 * size)
            << strain_law_name(law);
        // The oracle: a thousandth more of one modulus.
        Thrown wrong = body;
        wrong.model.elastic.strain_terms.back().moduli.mu_pa *= 1.001;
        EXPECT_GT(field_distance(find_accelerations<float>(wrong), expected), 1e-5 * size);
      }
    }
  }
}

TEST(TetEngine, IsSymplecticEulerOfTheSameBody) {
  const double step = 1e-3;
  for (const Continuum kind : kKinds) {
    for (const StrainLaw law : kLaws) {
      const Thrown body = make_thrown(kind, law);
      const MotionState expected = march(body.model, {}, body.start, 120 * step, 120);
      TetEngine<double> with_double(body.model, {});
      TetEngine<float> with_float(body.model, {2});
      const auto compare = [&](auto& engine, double tolerance) {
        engine.set_state(body.start);
        engine.step(step, 120);
        const MotionState got = engine.state();
        EXPECT_LT(field_distance(got.displacement_m, expected.displacement_m),
                  tolerance * field_norm(expected.displacement_m));
        EXPECT_LT(field_distance(got.velocity_m_s, expected.velocity_m_s),
                  tolerance * field_norm(expected.velocity_m_s));
        EXPECT_NEAR(got.time_s, expected.time_s, 1e-12);
      };
      // Displacements and velocities are rounded once a step, forces to 1e-5 and 1e-13 (above).
      compare(with_double, 120 * 1e-13);
      compare(with_float, 1e-4);
    }
  }
}

TEST(TetEngine, LinearDampingIsTakenWithTheStress) {
  // The same field of velocities as a displacement gives the damping's force, b times.
  Thrown damped = make_free(Continuum::kEdgeNode, StrainLaw::kLinear, 0.25);
  damped.start.velocity_m_s = make_random_field(damped.model.mass_kg.size(), 0.1, 4);
  Thrown moved = damped;
  moved.start.velocity_m_s = std::vector<Vec3>(moved.model.mass_kg.size());
  for (std::size_t v = 0; v < moved.model.mass_kg.size(); ++v)
    moved.start.displacement_m[v] = 0.25 * damped.start.velocity_m_s[v];
  const std::vector<Vec3> by_displacement = find_accelerations<double>(moved);
  EXPECT_LT(field_distance(find_accelerations<double>(damped), by_displacement),
            1e-13 * field_norm(by_displacement));
}

TEST(TetEngine, MomentumIsKept) {
  for (const Continuum kind : kKinds) {
    for (const StrainLaw law : kLaws) {
      Thrown body = make_free(kind, law, 1e-3);
      body.start.velocity_m_s = make_random_field(body.model.mass_kg.size(), 0.05, 3);
      const Vec3 before = measure_momentum(body.model, body.start);
      double size = 0.0;
      for (std::size_t v = 0; v < body.model.mass_kg.size(); ++v)
        size += body.model.mass_kg[v] * length(body.start.velocity_m_s[v]);
      TetEngine<double> engine(body.model, {});
      engine.set_state(body.start);
      engine.step(1e-3, 100);
      EXPECT_LT(length(measure_momentum(body.model, engine.state()) - before), 100 * 1e-15 * size);
      TetEngine<float> single(body.model, {});
      single.set_state(body.start);
      single.step(1e-3, 100);
      EXPECT_LT(length(measure_momentum(body.model, single.state()) - before), 100 * 6e-7 * size);
    }
  }
}

TEST(TetEngine, ARotationOfTheWholeBodyIsNotResisted) {
  const Mat3 turn = make_rotation({0.6, 0.0, 0.8}, 1.0);
  const Vec3 spin{0.3, -0.2, 0.5};
  for (const Continuum kind : kKinds) {
    for (const StrainLaw law : kTurning) {
      Thrown body = make_free(kind, law, 0.5);
      body.start.displacement_m =
          make_affine_field(body.model.elastic.rest, turn - kIdentity, {0.1, 0.2, 0.3});
      for (std::size_t v = 0; v < body.model.mass_kg.size(); ++v)
        body.start.velocity_m_s[v] = cross(spin, turn * body.model.elastic.rest[v]);
      // Beside it: the same with a strain of a thousandth, and a rate of as much.
      Thrown bent = body;
      for (std::size_t v = 0; v < body.model.mass_kg.size(); ++v) {
        bent.start.displacement_m[v].x *= 1.001 * (1.0 + body.model.elastic.rest[v].x);
        bent.start.velocity_m_s[v].y *= 1.001;
      }
      const double felt = field_norm(find_accelerations<double>(bent));
      EXPECT_LT(field_norm(find_accelerations<double>(body)), 1e-10 * felt);
      EXPECT_LT(field_norm(find_accelerations<float>(body)), 0.05 * felt);
    }
  }
}

TEST(TetEngine, AnAffineDisplacementGivesNoForceInside) {
  const Mat3 gradient{{0.02, 0.03, 0.0, -0.01, -0.04, 0.02, 0.05, 0.0, 0.01}};
  for (const Continuum kind : kKinds) {
    for (const StrainLaw law : kLaws) {
      Thrown body = make_free(kind, law, 0.0);
      const std::vector<Vec3>& rest = body.model.elastic.rest;
      body.start.displacement_m = make_affine_field(rest, gradient, {});
      const auto is_inside = [](const Vec3& x) {
        // Two layers of vertices: nodes and edges at the boundary see half of what is around them.
        return std::min({x.x, x.y, x.z}) > 0.2 && std::max({x.x, x.y, x.z}) < 0.8;
      };
      const std::vector<Vec3> a = find_accelerations<double>(body);
      double inside = 0.0;
      double outside = 0.0;
      for (std::size_t v = 0; v < a.size(); ++v)
        (is_inside(rest[v]) ? inside : outside) =
            std::max(is_inside(rest[v]) ? inside : outside, length(a[v]));
      EXPECT_LT(inside, 1e-11 * outside);
      // A vertex out of place is felt.
      body.start.displacement_m[rest.size() / 2].x += 1e-6;
      EXPECT_GT(field_norm(find_accelerations<double>(body)), 0.0);
    }
  }
}

template <typename Real>
std::uint64_t hash_after(const Thrown& body, const PlainOptions& options) {
  TetEngine<Real> engine(body.model, options);
  engine.set_state(body.start);
  engine.step(1e-3, 20);
  return hash_state(engine.state());
}

TEST(TetEngine, ThreadsAndInstructionSetsGiveTheSameBits) {
  for (const Continuum kind : kKinds) {
    for (const StrainLaw law : kLaws) {
      const Thrown body = make_thrown(kind, law);
      PlainOptions portable;
      portable.portable = true;
      EXPECT_EQ(hash_after<float>(body, {1}), hash_after<float>(body, {2}));
      EXPECT_EQ(hash_after<double>(body, {1}), hash_after<double>(body, {3}));
      EXPECT_EQ(hash_after<float>(body, {1}), hash_after<float>(body, portable));
      EXPECT_EQ(hash_after<double>(body, {1}), hash_after<double>(body, portable));
    }
  }
  const Thrown body = make_thrown(Continuum::kTets, StrainLaw::kCorotated);
  Thrown other = body;
  other.start.velocity_m_s.back().x += 1e-6;  // at the top, which is free
  EXPECT_NE(hash_after<float>(body, {1}), hash_after<float>(other, {1}));
}

/// A cube in the hands of a tool; both blocks have some of it.
MotionModel make_palpated(Continuum kind, StrainLaw law) {
  const TetMesh mesh = build_kuhn_cube(13, 0.2, 5);
  MotionModel model = make_continuum(make_pressed_body(mesh, 0.2), mesh, kind, law);
  model.strain_damping_s = 1e-3;
  add_palpation(mesh, model);
  return model;
}

/// The engine against the integrator, and what both cut.
template <typename Real>
void compare_engine(const MotionModel& model, const PlainOptions& options, double tolerance) {
  const auto [report, cut] = compare_with_integrator<TetEngine<Real>>(model, options, 150, tolerance);
  EXPECT_EQ(cut > 0, options.speed_limit_m_s > 0.0);
  if (sizeof(Real) == 8) {
    EXPECT_EQ(report.speeds_cut, cut);
  }
}

TEST(TetEngine, SupportsPadsToolsAndProfilesAreThoseOfTheIntegrator) {
  for (const StrainLaw law : kLaws) {
    const MotionModel model = make_palpated(Continuum::kTets, law);
    compare_engine<double>(model, {}, 1e-11);
    compare_engine<float>(model, {}, 1e-3);
  }
  compare_engine<double>(make_palpated(Continuum::kEdgeNode, StrainLaw::kCorotated), {2, 0.3}, 1e-11);
}

TEST(TetEngine, AWatchedRunReportsThePeakSpeedAndStopsWhereItEscapes) {
  const Thrown body = make_thrown(Continuum::kTets, StrainLaw::kCorotated);
  for (const int threads : {1, 2}) {
    PlainOptions watched{threads, 0.0, 100.0};
    TetEngine<double> engine(body.model, watched);
    engine.set_state(body.start);
    PlainReport report = engine.step(1e-3, 1);
    double fastest = 0.0;
    for (const Vec3& v : engine.state().velocity_m_s) fastest = std::max(fastest, length(v));
    EXPECT_DOUBLE_EQ(report.peak_speed_m_s, fastest);
    EXPECT_FALSE(report.diverged);
    report = engine.step(1.0, 500);
    EXPECT_TRUE(report.diverged);
    EXPECT_LT(report.steps, 500U);
  }
}

TEST(TetEngine, ARunAndAStepperReportWhatTheGeneralOnesReport) {
  const Thrown body = make_thrown(Continuum::kTets, StrainLaw::kCorotated, 1e-3, 4);
  const MotionRunOptions options{1e-3, 100, 1000.0, 30};
  Integrator integrator(body.model, {});
  MotionState general_end = body.start;
  MotionState end = body.start;
  const MotionReport general = run_motion(integrator, general_end, options);
  std::vector<std::uint64_t> seen;
  const MotionReport report =
      run_tet_motion(body.model, end, {options, 2, 0.0, false},
                     [&](std::uint64_t step, const MotionState&) { seen.push_back(step); });
  EXPECT_EQ(seen, (std::vector<std::uint64_t>{0, 30, 60, 90, 100}));
  EXPECT_EQ(report.outcome, general.outcome);
  EXPECT_EQ(report.steps, general.steps);
  EXPECT_EQ(report.state_hash, hash_state(end));
  EXPECT_NEAR(report.peak_speed_m_s, general.peak_speed_m_s, 1e-9);
  for (const Precision precision : {Precision::kDouble, Precision::kSingle}) {
    const auto stepper = make_tet_stepper(body.model, precision, 1);
    stepper->set_state(body.start);
    stepper->advance(1e-3, 100);
    const double tolerance = precision == Precision::kDouble ? 1e-12 : 1e-4;
    EXPECT_LT(field_distance(stepper->state().displacement_m, general_end.displacement_m),
              tolerance * field_norm(general_end.displacement_m));
    EXPECT_EQ(stepper->rounding(), precision == Precision::kDouble ? 1e-14 : 1e-6);
  }
  const MotionReport wild = run_tet_motion(body.model, end, {{0.5, 400, 1000.0, 1000}});
  EXPECT_EQ(wild.outcome, MotionOutcome::kDiverged);
  EXPECT_NE(wild.first_bad_vertex, kNoIndex);
  EXPECT_THROW(run_tet_motion(body.model, end, {{0.0, 1, 1000.0, 0}}), InputError);
}

TEST(TetEngine, ASmallDisplacementKeepsItsDigitsInSinglePrecision) {
  // A micrometre in a cube of 1 m: positions would be rounded to 6e-8 m, a sixteenth of it.
  for (const StrainLaw law : kLaws) {
    Thrown body = make_free(Continuum::kTets, law, 0.0);
    body.start.displacement_m = make_random_field(body.model.mass_kg.size(), 1e-6, 3);
    const std::vector<Vec3> expected = expected_accelerations(body);
    EXPECT_LT(field_distance(find_accelerations<float>(body), expected), 1e-5 * field_norm(expected));
  }
}

TEST(TetEngine, RefusesWhatItCannotTake) {
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 1);
  const MotionModel springs = make_free_body(mesh, 0.0);
  EXPECT_EQ(find_more_than_tets(springs), "springs");
  EXPECT_THROW(TetEngine<double>(springs, {}), InputError);
  EXPECT_EQ(find_more_than_tets(make_free_body(mesh, 0.0, VolumeModel::kNodeAverage)), "springs");
  MotionModel good = make_continuum(springs, mesh, Continuum::kTets, StrainLaw::kLinear);
  EXPECT_EQ(find_more_than_tets(good), "");
  MotionModel bad = good;
  bad.mass_kg[0] = 0.0;
  EXPECT_THROW(TetEngine<float>(bad, {}), InputError);
  bad = good;
  bad.elastic.strain_terms.clear();
  EXPECT_EQ(find_more_than_tets(bad), "no strain energy");
  bad = good;
  bad.elastic.volume_force = make_free_body(mesh, 0.0, VolumeModel::kThesis).elastic.volume_force;
  EXPECT_EQ(find_more_than_tets(bad), "a volume force");
  EXPECT_THROW(TetEngine<float>(bad, {}), InputError);
}

}  // namespace
}  // namespace palpate::dynamics

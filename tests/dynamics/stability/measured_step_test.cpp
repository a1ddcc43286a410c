#include "core/dynamics/stability/measured_step.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/error.h"
#include "core/dynamics/stability/stability.h"
#include "core/dynamics/stability/step_map.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;
using ::testing::HasSubstr;

constexpr std::array<IntegratorKind, 3> kDampedOrNot{
    IntegratorKind::kSymplecticEuler, IntegratorKind::kVelocityVerlet, IntegratorKind::kRungeKutta4};

/// A cube rounded to a ball, stretched and bent around a hilum.
TetMesh make_small_kidney() {
  TetMesh mesh = build_kuhn_cube(3, 0.2, 9);
  for (Vec3& p : mesh.points) {
    Vec3 c = 2.0 * p - Vec3{1.0, 1.0, 1.0};
    const double reach = std::max({std::abs(c.x), std::abs(c.y), std::abs(c.z)});
    if (length(c) > 0.0) c = (0.3 + 0.7 * reach / length(c)) * c;
    p = {0.055 * c.x, 0.0275 * c.y + 0.02 * c.x * c.x, 0.0225 * c.z};
  }
  return mesh;
}

/// Dampings: none; one that shares its vectors with the stiffness; ones that share none.
std::vector<MotionModel> make_damped(const TetMesh& mesh, VolumeModel volume) {
  std::vector<MotionModel> models;
  const MotionModel body = linearise(make_free_body(mesh, 0.0, volume));
  const double fastest =
      1.0 / predict_stable_step(body, IntegratorKind::kSymplecticEuler).step_s;  // half of omega
  const std::vector<double>& k = body.elastic.springs.stiffness_n_per_m;
  models.push_back(body);
  models.push_back(body);
  models.back().strain_damping_s = 0.3 / fastest;
  for (std::size_t s = 0; s < k.size(); ++s) models.back().spring_damping_n_s_per_m[s] = 0.3 / fastest * k[s];
  models.push_back(body);  // each third spring alone, and a drag
  for (std::size_t s = 0; s < k.size(); s += 3)
    models.back().spring_damping_n_s_per_m[s] = 0.5 / fastest * k[s];
  models.back().environment_damping_n_s_per_m.assign(mesh.points.size(), 0.2 * fastest * body.mass_kg[0]);
  models.push_back(body);  // the thesis's, which rules over the springs
  models.back().spring_damping = SpringDamping::kIsotropic;
  models.back().spring_damping_n_s_per_m.assign(k.size(), 5.0 / fastest * k[0]);
  return models;
}

MeasuredStep measure(const MotionModel& model, IntegratorKind kind, MeasureStepOptions options) {
  IntegratorOptions wanted;
  wanted.kind = kind;
  options.first_step_s = bound_stable_step(model, IntegratorKind::kSymplecticEuler).step_s;
  const auto stepper = make_stepper(model, wanted);
  return measure_stable_step(*stepper, options);
}

TEST(MeasuredStep, IsThePredictedOneWithinTwoPercentOnEveryMeshAndDamping) {
  MeasureStepOptions options;
  options.horizon_least = 512;
  options.horizon_most = 4096;
  options.tolerance = 0.01;
  const std::vector<TetMesh> meshes{make_small_kidney(), build_bar(1), build_kuhn_cube(2, 0.4, 3)};
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    for (const VolumeModel volume : {VolumeModel::kNone, VolumeModel::kTet, VolumeModel::kNodeAverage}) {
      if (m > 0 && volume == VolumeModel::kTet) continue;
      for (const MotionModel& model : make_damped(meshes[m], volume)) {
        for (const IntegratorKind kind : kDampedOrNot) {
          const StableStep predicted = predict_stable_step(model, kind);
          const MeasuredStep measured = measure(model, kind, options);
          SCOPED_TRACE(std::string(integrator_name(kind)) + " on mesh " + std::to_string(m) + " with " +
                       volume_model_name(volume));
          ASSERT_TRUE(measured.is_found());
          EXPECT_NEAR(measured.step_s() / predicted.step_s, 1.0, 0.02);
          EXPECT_EQ(predicted.step_at_most_s, predicted.step_s);
          EXPECT_LE(bound_stable_step(model, kind).step_s, measured.unstable_s);
        }
      }
    }
  }
}

TEST(MeasuredStep, ExplicitEulersIsThePredictedOneWhereThereIsDamping) {
  MeasureStepOptions options;
  options.horizon_least = options.horizon_most = 8192;  // just over its bound it grows slowly
  for (const TetMesh& mesh : {make_small_kidney(), build_bar(1)}) {
    const std::vector<MotionModel> models = make_damped(mesh, VolumeModel::kNone);
    for (std::size_t k = 1; k < models.size(); ++k) {
      SCOPED_TRACE("damping " + std::to_string(k));
      const StableStep predicted = predict_stable_step(models[k], IntegratorKind::kExplicitEuler);
      const MeasuredStep measured = measure(models[k], IntegratorKind::kExplicitEuler, options);
      ASSERT_TRUE(measured.is_found());
      EXPECT_NEAR(measured.step_s() / predicted.step_s, 1.0, 0.02);
      EXPECT_EQ(predicted.step_at_most_s, predicted.step_s);
    }
  }
}

TEST(MeasuredStep, AStepsOwnEigenvaluesTellWhatNoHorizonSees) {
  const TetMesh mesh = build_kuhn_cube(2, 0.4, 3);
  const std::size_t n = mesh.points.size();
  MotionModel model = make_damped(mesh, VolumeModel::kNone)[2];
  Loads hold{std::vector<Vec3>(n), {}, std::vector<std::uint8_t>(n), std::vector<Vec3>(n)};
  for (std::size_t v = 0; v < n; ++v) hold.held[v] = mesh.points[v].x == 0.0 ? 7 : 0;
  model.loads.push_back({hold, {}});
  for (const double damping : {1.0, 1e-3}) {  // of the latter growth is about 1e-9 a step just over the bound
    for (double& c : model.spring_damping_n_s_per_m) c *= damping;
    for (double& c : model.environment_damping_n_s_per_m) c *= damping;
    for (const IntegratorKind kind : {IntegratorKind::kExplicitEuler, IntegratorKind::kSymplecticEuler}) {
      SCOPED_TRACE(std::string(integrator_name(kind)) + " damping " + std::to_string(damping));
      const StableStep predicted = predict_stable_step(model, kind);
      IntegratorOptions wanted;
      wanted.kind = kind;
      const auto stepper = make_stepper(model, wanted);
      MeasureMapOptions options;
      options.first_step_s = 0.7 * predicted.step_s;
      const MeasuredStep measured = measure_stable_step_by_map(*stepper, options);
      ASSERT_TRUE(measured.is_found());
      EXPECT_NEAR(measured.step_s() / predicted.step_s, 1.0, 0.005);
    }
  }
}

TEST(MeasuredStep, TheMapOfAModeHasItsEigenvalues) {
  const double h = 0.3;
  for (const double damping : {0.0, 0.4}) {
    MotionModel model = linearise(make_oscillator(1.0, damping));
    model.loads[0].loads.held[1] = 6;  // moves along the spring alone
    IntegratorOptions wanted;
    wanted.kind = IntegratorKind::kExplicitEuler;  // |z|^2 = 1 - h d + h^2
    EXPECT_NEAR(measure_map_growth(*make_stepper(model, wanted), h), h * h - h * damping, 1e-14);
    wanted.kind = IntegratorKind::kSymplecticEuler;  // |z|^2 = 1 - h d
    EXPECT_NEAR(measure_map_growth(*make_stepper(model, wanted), h), -h * damping, 1e-14);
  }
}

TEST(MeasuredStep, OfTheQuickEngineInBothPrecisions) {
  MotionModel model = make_free_body(make_small_kidney(), 0.0);
  model.environment_damping_n_s_per_m.assign(model.mass_kg.size(), 0.1 * model.mass_kg[0]);
  const double predicted = predict_stable_step(model, IntegratorKind::kSymplecticEuler).step_s;
  for (const Precision precision : {Precision::kDouble, Precision::kSingle}) {
    const auto stepper = make_plain_stepper(model, precision, 1);
    MeasureStepOptions options;
    options.first_step_s = 0.1 * predicted;
    options.amplitude_m = precision == Precision::kDouble ? 1e-9 : 1e-7;
    options.horizon_most = 2048;
    const MeasuredStep measured = measure_stable_step(*stepper, options);
    ASSERT_TRUE(measured.is_found()) << precision_name(precision);
    EXPECT_NEAR(measured.step_s() / predicted, 1.0, 0.02) << precision_name(precision);
  }
}

TEST(MeasuredStep, WhatHasNoBoundAndWhatHasNoStableStepSaySo) {
  MotionModel model = linearise(make_oscillator(2.0, 0.0));
  IntegratorOptions wanted;
  MeasureStepOptions options;
  options.first_step_s = 0.1;
  options.horizon_most = 1024;
  wanted.kind = IntegratorKind::kImplicitEuler;
  const MeasuredStep implicit = measure_stable_step(*make_stepper(model, wanted), options);
  EXPECT_FALSE(implicit.is_found());
  EXPECT_EQ(implicit.unstable_s, std::numeric_limits<double>::infinity());
  EXPECT_GT(implicit.stable_s, 1e5);
  EXPECT_THROW(static_cast<void>(implicit.step_s()), ContractError);
  wanted.kind = IntegratorKind::kExplicitEuler;
  options.most_strides = 4;
  const MeasuredStep none = measure_stable_step(*make_stepper(model, wanted), options);
  EXPECT_FALSE(none.is_found());
  EXPECT_EQ(none.stable_s, 0.0);
  EXPECT_EQ(none.unstable_s, 0.1 / 16.0);
}

TEST(MeasuredStep, SpringsThatArePressedTogetherTakeOtherStepsThanAtRest) {
  // One mass between two held ends: k / m (1 + 1) along, and across 2 k / m (1 - L / r), which grows with r.
  MotionModel model = make_oscillator(1.0, 0.0);
  model.elastic.rest = {{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}};
  model.elastic.springs = {{{0, 1}, {1, 2}}, {1.0, 1.0}, {1.0, 1.0}};
  model.mass_kg = {1.0, 1.0, 1.0};
  model.spring_damping_n_s_per_m.clear();
  model.loads[0].loads = {std::vector<Vec3>(3), {}, {7, 6, 7}, std::vector<Vec3>(3)};
  const std::vector<Vec3> still(3);
  // At rest 2 / sqrt(2); the far end at 3 leaves the axis as it is, for springs are linear along themselves.
  EXPECT_NEAR(predict_stable_step_at(model, IntegratorKind::kSymplecticEuler, still).step_s, std::sqrt(2.0),
              1e-6);
  // Only across, with both springs at twice their length: 2 k (1 - 1/2) = 1.
  model.loads[0].loads.held = {7, 5, 7};
  const std::vector<Vec3> stretched{{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}};
  EXPECT_NEAR(predict_stable_step_at(model, IntegratorKind::kSymplecticEuler, stretched).step_s, 2.0, 1e-6);
  EXPECT_EQ(predict_stable_step_at(model, IntegratorKind::kSymplecticEuler, still).step_s,
            std::numeric_limits<double>::infinity());
}

TEST(MeasuredStep, FromADeformedStateIsShorterForAStiffeningBody) {
  const TetMesh mesh = make_small_kidney();
  const MotionModel model = make_free_body(mesh, 0.0);
  const double predicted = predict_stable_step(model, IntegratorKind::kSymplecticEuler).step_s;
  MotionState start = start_at_rest(model);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) start.displacement_m[v] = 1.0 * mesh.points[v];
  MeasureLargeOptions options;
  options.first_step_s = 0.5 * predicted;
  options.steps = 400;
  const MeasuredStep measured = measure_stable_step_from(*make_stepper(model, {}), start, options);
  ASSERT_TRUE(measured.is_found());
  EXPECT_LT(measured.step_s(), 0.98 * predicted);
  EXPECT_GT(measured.step_s(), 0.2 * predicted);
}

template <typename Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(MeasuredStep, RefusesWhatIsNoSetting) {
  const MotionModel model = make_oscillator(2.0, 0.0);
  const auto stepper = make_stepper(model, {});
  const auto with = [&](auto&& change) {
    MeasureStepOptions options;
    options.first_step_s = 0.1;
    change(options);
    return error_of([&] { measure_stable_step(*stepper, options); });
  };
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT(with([&](MeasureStepOptions& o) { o.first_step_s = bad; }),
                HasSubstr("first step: expected"));
    EXPECT_THAT(with([&](MeasureStepOptions& o) { o.amplitude_m = bad; }), HasSubstr("amplitude: expected"));
    EXPECT_THAT(with([&](MeasureStepOptions& o) { o.growth_factor = bad; }), HasSubstr("growth factor"));
    EXPECT_THAT(with([&](MeasureStepOptions& o) { o.tolerance = bad; }), HasSubstr("tolerance: expected"));
  }
  EXPECT_THAT(with([](MeasureStepOptions& o) { o.stride = 1.0; }), HasSubstr("stride: expected"));
  EXPECT_THAT(with([](MeasureStepOptions& o) { o.horizon_least = 100; }), HasSubstr("at least 512 steps"));
  EXPECT_THAT(with([](MeasureStepOptions& o) { o.horizon_most = 600; }), HasSubstr("1024 and 600"));
  const auto with_map = [&](auto&& change) {
    MeasureMapOptions map;
    map.first_step_s = 0.1;
    change(map);
    return error_of([&] { measure_stable_step_by_map(*stepper, map); });
  };
  EXPECT_THAT(with_map([](MeasureMapOptions& o) { o.first_step_s = 0.0; }),
              HasSubstr("first step: expected"));
  EXPECT_THAT(with_map([](MeasureMapOptions& o) { o.first_stride = 1.0; }), HasSubstr("stride: expected"));
  EXPECT_THAT(with_map([](MeasureMapOptions& o) { o.tolerance = -1.0; }), HasSubstr("tolerance: expected"));
  MeasureLargeOptions large;
  EXPECT_THAT(error_of([&] { measure_stable_step_from(*stepper, start_at_rest(model), large); }),
              HasSubstr("first step: expected"));
  MotionModel thesis = model;
  thesis.elastic.volume_force.emplace();
  EXPECT_THAT(error_of([&] { linearise(thesis); }), HasSubstr("found a volume force"));
  EXPECT_THAT(error_of([] { parse_precision("half"); }), HasSubstr("double or float, found half"));
}

}  // namespace
}  // namespace palpate::dynamics

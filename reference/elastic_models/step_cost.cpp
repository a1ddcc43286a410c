#include "reference/elastic_models/step_cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/motion/motion_model.h"
#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/dynamics/stability/stability.h"
#include "core/dynamics/tet_engine/tet_engine.h"
#include "core/dynamics/time_loop/body_stepper.h"

namespace palpate::reference {
namespace {

using dynamics::BodyStepper;
using dynamics::MotionModel;

constexpr std::size_t kStretches = 9;
constexpr double kStretch = 0.01;  // s, of the clock
constexpr std::uint64_t kWarmSteps = 4;

std::unique_ptr<BodyStepper> choose_stepper(const MotionModel& model, int threads, std::string& engine) {
  using dynamics::Precision;
  if (find_more_than_plain(model).empty()) {
    engine = "plain";
    return make_plain_stepper(model, Precision::kSingle, threads);
  }
  if (find_more_than_tets(model).empty()) {
    engine = "tets";
    return make_tet_stepper(model, Precision::kSingle, threads);
  }
  engine = "general";
  dynamics::IntegratorOptions options;
  options.kind = dynamics::IntegratorKind::kSymplecticEuler;
  options.threads = threads;
  return make_stepper(model, options);
}

double seconds_of(BodyStepper& stepper, double step_s, std::uint64_t steps) {
  const Stopwatch watch;
  stepper.advance(step_s, steps);
  return watch.seconds();
}

bool is_finite_state(const dynamics::MotionState& state) {
  return std::all_of(state.displacement_m.begin(), state.displacement_m.end(),
                     [](const Vec3& u) { return std::isfinite(u.x + u.y + u.z); });
}

}  // namespace

StepCost measure_step_cost(const TetMesh& mesh, dynamics::ElasticModel model, const dynamics::Loads& loads,
                           double density_kg_m3, int threads) {
  MotionModel body;
  body.tets = mesh.tets;
  body.elastic = std::move(model);
  if (body.elastic.strain_terms.empty()) body.elastic.springs_are_linear = false;
  body.mass_kg = dynamics::build_lumped_masses(mesh, density_kg_m3);
  body.loads.push_back({loads, {}});
  StepCost cost;
  const auto kind = dynamics::IntegratorKind::kSymplecticEuler;
  const dynamics::StableStep bound = predict_stable_step(body, kind, threads);
  cost.stable_step_s = bound.converged ? bound.step_s : bound_stable_step(body, kind).step_s;
  if (!(cost.stable_step_s > 0.0) || !std::isfinite(cost.stable_step_s))
    throw InputError("step_cost", 0, "a stable step", "none: the body has no stiffness");
  const double step_s = kStepSafety * cost.stable_step_s;
  const std::unique_ptr<BodyStepper> stepper = choose_stepper(body, threads, cost.engine);
  stepper->set_state(start_at_rest(body));
  const double warm_s = seconds_of(*stepper, step_s, kWarmSteps);
  const double wanted = kStretch * static_cast<double>(kWarmSteps) / std::max(warm_s, 1e-9);
  const auto steps = static_cast<std::uint64_t>(std::clamp(wanted, 1.0, 1e5));
  std::array<double, kStretches> times{};
  for (double& time : times) time = seconds_of(*stepper, step_s, steps) / static_cast<double>(steps);
  std::nth_element(times.begin(), times.begin() + kStretches / 2, times.end());
  cost.step_wall_s = times[kStretches / 2];
  cost.is_finite = is_finite_state(stepper->state());
  return cost;
}

void report_step_cost(const StepCost& cost, nlohmann::json& report) {
  report["explicit_step_s"] = cost.stable_step_s;
  report["step_engine"] = cost.engine;
  report["step_wall_s"] = cost.is_finite ? nlohmann::json(cost.step_wall_s) : nlohmann::json();
  report["simulated_second_s"] =
      cost.is_finite ? nlohmann::json(cost.simulated_second_s()) : nlohmann::json();
}

}  // namespace palpate::reference

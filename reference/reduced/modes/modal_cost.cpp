#include "reference/reduced/modes/modal_cost.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/base/stopwatch.h"

namespace palpate::reference {
namespace {

using dynamics::ModalPhase;
using nlohmann::json;

constexpr std::size_t kStretches = 9;
constexpr double kStretchS = 0.01;  // of the clock
constexpr std::uint64_t kWarmSteps = 16;

double median_of(std::array<double, kStretches>& times) {
  std::nth_element(times.begin(), times.begin() + kStretches / 2, times.end());
  return times[kStretches / 2];
}

/// Steps on from `time_s`, which is moved. Returns: the seconds of the clock that a step took.
double step_time(ModalPhase& body, std::uint64_t steps, double& time_s) {
  const Stopwatch watch;
  for (std::uint64_t k = 0; k < steps; ++k) {
    time_s += kCountedStepS;
    body.advance(kCountedStepS, time_s);
  }
  return watch.seconds() / static_cast<double>(steps);
}

}  // namespace

double time_field(const ModalPhase& body, std::size_t nodes) {
  std::array<double, kStretches> times{};
  for (double& time : times) {
    const Stopwatch watch;
    const std::vector<Vec3> field = body.displacements_of_first(nodes);
    time = field.empty() ? 0.0 : watch.seconds();
  }
  return median_of(times);
}

void report_step_cost(ModalPhase& body, std::size_t nodes, json& report) {
  body.prepare(kCountedStepS);
  double time_s = 0.0;
  const double warm_s = step_time(body, kWarmSteps, time_s);
  const auto steps = static_cast<std::uint64_t>(std::clamp(kStretchS / std::max(warm_s, 1e-9), 1.0, 1e6));
  std::array<double, kStretches> times{};
  for (double& time : times) time = step_time(body, steps, time_s);
  const double step_s = median_of(times);
  const double field_s = time_field(body, nodes);
  const std::vector<Vec3> field = body.displacements_of_first(nodes);
  const bool is_finite_field =
      std::all_of(field.begin(), field.end(), [](const Vec3& u) { return is_finite(u); });
  report["step_engine"] = "modes";
  report["step_wall_s"] = is_finite_field ? json(step_s) : json(nullptr);
  report["field_wall_s"] = is_finite_field ? json(field_s) : json(nullptr);
  report["simulated_second_s"] =
      is_finite_field ? json(step_s / kCountedStepS + kPicturesPerS * field_s) : json(nullptr);
}

}  // namespace palpate::reference

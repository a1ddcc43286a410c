#include "experiments/contests/motion_watch.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <string>

#include "core/base/number_text.h"
#include "experiments/files/plain_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// What limits the step: the place, and the tetrahedron there that is flattest.
std::string limit_text(const json& limiting) {
  const json& place = limiting.at("place_m");
  std::array<char, 320> text{};
  std::snprintf(
      text.data(), text.size(),
      "the fastest motion, which limits the step, is at vertex %lld at (%.4g, %.4g, %.4g) m; the flattest "
      "tetrahedron there, number %lld, is %.3g mm high (median of the mesh %.3g mm)",
      static_cast<long long>(limiting.at("vertex").get<std::int64_t>()), place.at(0).get<double>(),
      place.at(1).get<double>(), place.at(2).get<double>(),
      static_cast<long long>(limiting.at("tet").get<std::int64_t>()),
      1000.0 * limiting.at("height_m").get<double>(), 1000.0 * limiting.at("median_height_m").get<double>());
  return text.data();
}

}  // namespace

void MotionWatch::say_start(const json& progress) {
  has_started_ = true;
  const json& bound = progress.at("stable_step_s");
  progress_.say(
      progress.at("steps").dump() + " steps of " + short_number(progress.at("time_step_s").get<double>()) +
      " s" +
      (bound.is_number() ? "; the longest stable step is " + short_number(bound.get<double>()) + " s" : ""));
  if (progress.at("limiting").is_object()) progress_.say(limit_text(progress.at("limiting")));
  progress_.start(progress.at("steps").get<std::size_t>());
  progress_.show("steps");
}

void MotionWatch::say_stage(const std::string& stage) {
  if (stage == stage_) return;
  stage_ = stage;
  progress_.say(stage);
}

void MotionWatch::look() {
  const auto bytes = read_bytes(file_);
  if (!bytes) return;
  try {
    tell(json::parse(*bytes));
  } catch (const json::exception&) {  // what it does not understand it does not tell
  }
}

void MotionWatch::tell(const json& progress) {
  constexpr double kLeastSeconds = 1.0;  // before it is said how long it may take
  constexpr double kLongSeconds = 10.0;  // what takes longer is worth a line of its own
  if (progress.at("schema") != "palpate/progress/1") return;
  if (progress.contains("stage")) return say_stage(progress.at("stage").get<std::string>());
  if (!has_started_) say_start(progress);
  const auto done = progress.at("steps_done").get<double>();
  const auto steps = progress.at("steps").get<double>();
  const auto seconds = progress.at("seconds").get<double>();
  if (!(done > 0.0) || seconds < kLeastSeconds) return;
  const double all = seconds * steps / done;
  if (!has_estimated_ && all > kLongSeconds)
    progress_.say("all steps will take about " + duration_text(all) + ", by the first " + short_number(done));
  has_estimated_ = true;
  progress_.reach(static_cast<std::size_t>(done), all - seconds);
}

}  // namespace palpate::experiments

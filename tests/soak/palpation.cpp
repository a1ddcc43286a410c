#include "tests/soak/palpation.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/files/file_hash.h"
#include "live/body/pad.h"

namespace palpate::soak {
namespace {

constexpr double kTickS = 1e-3;
constexpr double kMostStepsPerTick = 1e4;
constexpr double kLeastDepth = 0.3;

std::string hash_fields(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  std::string bytes(reinterpret_cast<const char*>(a.data()), a.size() * sizeof(Vec3));
  bytes.append(reinterpret_cast<const char*>(b.data()), b.size() * sizeof(Vec3));
  return experiments::hash_bytes(bytes);
}

}  // namespace

Palpation::Palpation(live::LiveBody& body, const FingerOptions& options)
    : body_(body), options_(options), random_(options.seed) {
  const double bound_s = body.predict_step(options.stiffness_pa_per_m).step_s;
  const double steps = std::ceil(kTickS / (options.share_of_bound * bound_s));
  if (!(steps <= kMostStepsPerTick))
    throw InputError("soak", 0, "a body with a stable step above 0.1 us", three_digits(bound_s) + " s");
  steps_per_tick_ = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(steps));
  step_s_ = kTickS / static_cast<double>(steps_per_tick_);
}

bool Palpation::step_ticks(std::uint64_t ticks) {
  return body_.step(step_s_, ticks * steps_per_tick_);
}

Index Palpation::neighbour_of(Index vertex) {
  std::vector<Index> found;
  for (const Triangle& face : body_.skin()) {
    const auto corner = std::find(face.begin(), face.end(), vertex);
    if (corner == face.end()) continue;
    found.push_back(face[static_cast<std::size_t>(corner - face.begin() + 1) % 3]);
  }
  return found[random_.below(found.size())];
}

/// All of a dent at once in another place would be a blow: so the finger slides at a third of its depth.
bool Palpation::hold(const Vec3& inward, Index slide_to) {
  constexpr std::uint64_t kQuietTicks = 100;
  constexpr std::uint64_t kRiseTicks = (kHeldTicks - 2 * kQuietTicks) / 2;
  if (slide_to == kNoIndex) return step_ticks(kHeldTicks);
  const double speed_m_s = 2.0 / 3.0 * length(inward) / (kTickS * static_cast<double>(kRiseTicks));
  if (!step_ticks(kQuietTicks)) return false;
  body_.aim((1.0 / 3.0) * inward, speed_m_s);
  if (!step_ticks(kRiseTicks)) return false;
  body_.slide(slide_to, options_.radius_m, options_.stiffness_pa_per_m);
  body_.aim(inward, speed_m_s);
  return step_ticks(kRiseTicks + kQuietTicks);
}

CycleFigures Palpation::run_cycle() {
  CycleFigures out;
  const Triangle& face = body_.skin()[random_.below(body_.skin().size())];
  out.vertex = face[random_.below(3)];
  out.depth_m = options_.deepest_m * (kLeastDepth + (1.0 - kLeastDepth) * random_.uniform());
  out.has_slid = random_.below(2) == 0;
  const Index to = neighbour_of(out.vertex);  // drawn in any case, so that cycles draw alike
  const std::vector<Vec3>& rest = body_.model().elastic.rest;
  const Vec3 inward = -out.depth_m * live::skin_normal(rest, body_.skin(), out.vertex);

  body_.press(out.vertex, options_.radius_m, options_.stiffness_pa_per_m);
  body_.aim(inward, out.depth_m / (kTickS * static_cast<double>(kDownTicks)));
  const bool is_whole = step_ticks(kDownTicks) && hold(inward, out.has_slid ? to : kNoIndex);
  out.pressed = body_.report();
  if (is_whole) {
    body_.aim({}, out.depth_m / (kTickS * static_cast<double>(kUpTicks)));
    step_ticks(kUpTicks);
    body_.release();
    step_ticks(kFreeTicks);
  }
  measure_end(out);
  return out;
}

void Palpation::measure_end(CycleFigures& out) {
  out.rest = body_.report();
  const dynamics::MotionState& state = body_.state();
  Vec3 sum;
  for (const Vec3& u : state.displacement_m) sum = sum + u;
  out.mean_offset_m = (1.0 / static_cast<double>(state.displacement_m.size())) * sum;
  out.hash = hash_fields(state.displacement_m, state.velocity_m_s);
}

}  // namespace palpate::soak

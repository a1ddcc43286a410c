#include "experiments/rounds/case_state.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "experiments/records/case_record.h"
#include "experiments/records/record_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr double kMedianLevel = 0.95;

bool is_measured(const json& record) {
  return !record.value("warmup", false);
}

std::optional<double> kernel_time(const json& record) {
  const json value = record.value("kernel_s", json());
  return value.is_number() ? std::optional<double>(value.get<double>()) : std::nullopt;
}

bool closes(const std::string& outcome) {
  return outcome == "timed_out" || outcome == "bad_input" || outcome == "unavailable" ||
         outcome == "not_judged";
}

}  // namespace

std::optional<MedianInterval> median_interval(std::vector<double> values, double level) {
  const std::size_t n = values.size();
  constexpr std::size_t kMostValues = 10'000;  // 2^-n is still a normal number of this type
  require(n <= kMostValues, "median_interval: too many values");
  if (n < 2) return std::nullopt;
  std::sort(values.begin(), values.end());
  std::optional<MedianInterval> found;
  long double chance = std::ldexp(1.0L, -static_cast<int>(n));  // P(B = i - 1)
  long double below = 0.0L;                                     // P(B <= i - 1)
  for (std::size_t i = 1; i <= n / 2; ++i) {
    below += chance;
    const auto coverage = static_cast<double>(1.0L - 2.0L * below);
    if (coverage < level) break;
    found = MedianInterval{values[i - 1], values[n - i], coverage};
    chance *= static_cast<long double>(n - i + 1) / static_cast<long double>(i);
  }
  return found;
}

double relative_median_width(const std::vector<double>& values) {
  const auto interval = median_interval(values, kMedianLevel);
  if (!interval) return std::numeric_limits<double>::infinity();
  return (interval->high - interval->low) / median(values);
}

RepeatBounds repeat_bounds(const RunSettings& run, const Case& c) {
  return {repeats_of(run, c), most_repeats_of(run, c), run.until_width};
}

void CaseState::remember(const json& record, const RepeatBounds& bounds) {
  done.insert(record.at("repeat").get<int>());
  if (record.value("wall_s", json()).is_number()) wall_s = record.at("wall_s").get<double>();
  const std::string outcome = record.at("outcome").get<std::string>();
  is_closed_ = is_closed_ || closes(outcome);
  if (worst.empty() || outcome != "accepted") worst = outcome;
  if (first_failure.empty() && outcome != "accepted") first_failure = outcome + ": " + reason_of(record);
  remember_answer(record);
  if (is_measured(record)) {
    ++measured_;
    if (const auto time = kernel_time(record)) times_.push_back(*time);
  }
  if (measured_ < bounds.least) return;
  if (bounds.most == bounds.least) {
    end = RepeatsEnd::kAll;
    return;
  }
  width = relative_median_width(times_);
  if (static_cast<int>(times_.size()) < measured_) {
    end = RepeatsEnd::kNoTime;
  } else if (width <= *bounds.width) {
    end = RepeatsEnd::kNarrow;
  } else if (measured_ >= bounds.most) {
    end = RepeatsEnd::kLimit;
  }
}

void CaseState::remember_answer(const json& record) {
  static const json nothing;
  const auto part = [](const json& of,
                       const char* key) -> const json& {  // a judge's block is too long to copy
    const auto found = of.is_object() ? of.find(key) : of.end();
    return found != of.end() ? *found : nothing;
  };
  const json& found = part(record, "tuned");
  if (tuned.empty() && !found.empty()) tuned = found;
  const json& judge = part(record, "judge");
  if (!tets && part(judge, "tets").is_number()) {
    tets = judge.at("tets").get<double>();
    const json& upper = part(judge, "surface_distance_upper");
    if (upper.is_number()) distance = upper.get<double>();
  }
  const json& hash = part(record, "output_hash");
  if (!hash.is_string()) return;
  const json& ended = part(part(record, "report"), "outcome");
  const bool is_known = std::any_of(answers_.begin(), answers_.end(), [&](const PastAnswer& answer) {
    return hash == answer.output_hash && ended == answer.ended;
  });
  if (!is_known) answers_.push_back({hash.get<std::string>(), ended, json::to_msgpack(judge)});
}

std::vector<json> CaseState::earlier_answers() const {
  std::vector<json> found;
  for (const PastAnswer& answer : answers_) {
    const json report = answer.ended.is_null() ? json() : json{{"outcome", answer.ended}};
    found.push_back({{"output_hash", answer.output_hash},
                     {"report", report},
                     {"judge", json::from_msgpack(answer.judge)}});
  }
  return found;
}

void CaseState::drop_answers() {
  answers_ = {};
}

bool CaseState::is_closed() const {
  return is_closed_;
}

bool CaseState::is_due(int repeat, int warmup, const RepeatBounds& bounds) const {
  if (done.count(repeat) > 0 || is_closed() || end == RepeatsEnd::kHalved) return false;
  if (repeat < warmup + bounds.least) return true;
  return repeat < warmup + bounds.most && end == RepeatsEnd::kNotYet;
}

int CaseState::count_due(int warmup, const RepeatBounds& bounds) const {
  int due = 0;
  for (int repeat = 0; repeat < warmup + bounds.most; ++repeat) due += is_due(repeat, warmup, bounds) ? 1 : 0;
  return due;
}

int CaseState::count_measured() const {
  return measured_;
}

const char* repeats_end_name(RepeatsEnd end) {
  switch (end) {
    case RepeatsEnd::kNarrow:
      return "narrow";
    case RepeatsEnd::kLimit:
      return "limit";
    case RepeatsEnd::kNoTime:
      return "no_time";
    case RepeatsEnd::kHalved:
      return "halved";
    case RepeatsEnd::kNotYet:
    case RepeatsEnd::kAll:
      break;
  }
  return "";
}

void state_repeats(const RunSettings& run, const std::vector<Case>& cases,
                   const std::vector<CaseState>& states, json& provenance) {
  require(cases.size() == states.size(), "state_repeats: a state a case");
  provenance["repeats_of"] = json::object();
  if (run.until_width || run.halving_from > 0) provenance["repeats_ended"] = json::object();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const RepeatBounds bounds = repeat_bounds(run, cases[i]);
    const CaseState& state = states[i];
    const std::string reason = repeats_end_name(state.end);
    const int wanted = reason.empty() ? bounds.most : state.count_measured();
    if (wanted != run.repeats) provenance["repeats_of"][cases[i].id] = wanted;
    if (reason.empty()) continue;
    const bool known = std::isfinite(state.width);
    provenance["repeats_ended"][cases[i].id] = {
        {"reason", reason}, {"repeats", wanted}, {"width", known ? json(state.width) : json()}};
    if (!state.halved_by.empty()) provenance["repeats_ended"][cases[i].id]["by"] = state.halved_by;
  }
}

}  // namespace palpate::experiments

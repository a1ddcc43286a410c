#include "experiments/contests/stability/stability_judge.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/judge/motion/stability_reading.h"
#include "experiments/contests/stability/stability_answer.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using judge::Ending;
using judge::RunHistory;
using judge::RunReading;
using nlohmann::json;
using reference::number_or_null;

constexpr double kAgreement = 0.02;
constexpr double kWidestBracket = 1.025;  // upper end over lower; contestants halve to 0.5, 2 or 2.1%
constexpr double kEnergyFactor = 100.0;
constexpr double kLargeEnergyFactor = 10.0;  // of brackets of large motions
constexpr double kSame = 1e-9;

/// A number of the report; nothing where it has none.
std::optional<double> number_of(const json& report, const char* key) {
  const json value = report.value(key, json());
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

json describe_run(const RunHistory& run, const RunReading& reading, double size_m) {
  return {{"step_s", run.step_s},
          {"ending", judge::ending_name(reading.ending)},
          {"steps", reading.steps},
          {"inverted_start", run.rows.front().inverted},
          {"inverted_end", reading.inverted},
          {"steps_unsolved", run.rows.back().unsolved},
          {"energy_start_j", number_or_null(reading.energy_start_j)},
          {"energy_most_j", number_or_null(reading.energy_most_j)},
          {"kinetic_end_j", number_or_null(reading.kinetic_end_j)},
          {"drift_over_size", number_or_null(reading.farthest_m / size_m)}};
}

/// Judges one answer.
class AnswerJudge {
 public:
  AnswerJudge(const StabilityInput& input, const json& options, const json& report,
              const StabilityAnswer& answer)
      : input_(input), options_(options), report_(report), answer_(answer) {
    const Material& material = input.problem.material;
    bounds_ = {kEnergyFactor,
               judge::rounding_energy(input.mesh, material.young_modulus_pa, material.poisson_ratio,
                                      input.problem.stiffness_factor, answer.rounding)};
  }

  json figures() {
    figures_ = {{"min_dihedral_deg", input_.min_dihedral_deg}, {"flattened_tets", input_.flattened}};
    judge_runs();
    if (measures()) judge_bracket();
    figures_["valid"] = findings_.empty();
    figures_["findings"] = findings_;
    return figures_;
  }

 private:
  bool measures() const { return options_.value("task", "measure") == "measure"; }
  bool is_large() const { return options_.value("regime", "small") == "large"; }

  void judge_runs() {
    const double size = judge::longest_side(input_.mesh);
    const auto asked = options_.value("steps", std::uint64_t{1});
    json runs = json::array();
    for (const RunHistory& run : answer_.runs) {
      const RunReading reading = judge::read_run(run, input_.mesh, bounds_);
      runs.push_back(describe_run(run, reading, size));
      const std::string name = "run " + std::to_string(runs.size());
      if (reading.ending == Ending::kTooSlow)
        findings_.push_back(name + " was given up after " + std::to_string(reading.steps) +
                            " steps for want of time: how it ends is not known");
      if (run.steps < asked)
        findings_.push_back(name + " was to take " + std::to_string(run.steps) + " steps, " +
                            std::to_string(asked) + " were asked for");
      const std::uint64_t counted = run.rows.back().inverted;
      if (reading.ending != Ending::kNonFinite && (counted == 0) != (reading.inverted == 0))
        findings_.push_back(name + " says that it ends with " + std::to_string(counted) +
                            " inverted tets, the judge counts " + std::to_string(reading.inverted));
    }
    compare_words(runs);
    const std::size_t place = measures() && runs.size() > 1 ? 1 : 0;
    figures_["ending"] = runs.at(place).at("ending");
    const json said = report_.value("outcome", json());
    if (said != figures_.at("ending")) add_difference("the body", said, figures_.at("ending"));
    figures_["runs"] = std::move(runs);
  }

  void add_difference(const std::string& of, const json& said, const json& judged) {
    findings_.push_back("of " + of + " it says " +
                        (said.is_string() ? said.get<std::string>() : said.dump()) +
                        ", by its history it is " + judged.get<std::string>());
  }

  /// What the report says of each run, against what the judge reads.
  void compare_words(const json& runs) {
    const json said = report_.value("runs", json::array());
    if (!said.is_array() || said.size() != runs.size()) {
      findings_.push_back("its report has " + std::to_string(said.size()) + " runs, its histories " +
                          std::to_string(runs.size()));
      return;
    }
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const std::string name = "run " + std::to_string(k + 1);
      if (!said[k].is_object())
        throw InputError("report: runs[" + std::to_string(k) + "]", 0, "an object", said[k].dump());
      const json outcome = said[k].value("outcome", json());
      if (outcome != runs[k].at("ending")) add_difference(name, outcome, runs[k].at("ending"));
      const auto step = number_of(said[k], "step_s");
      if (!step || !is_same(*step, runs[k].at("step_s").get<double>()))
        findings_.push_back(name + " has the step " + said[k].value("step_s", json()).dump() +
                            " s in the report, " + runs[k].at("step_s").dump() + " s in its history");
    }
  }

  static bool is_same(double one, double other) {
    return std::abs(one - other) <= kSame * std::max(std::abs(one), std::abs(other));
  }

  /// "stable", "grows", or why that cannot be told.
  std::string read_end(const BracketEnd& end, const std::string& where) const {
    if (end.run) {
      const judge::RunBounds bounds{is_large() ? kLargeEnergyFactor : kEnergyFactor, bounds_.noise_j};
      const Ending ending = judge::read_run(*end.run, input_.mesh, bounds).ending;
      if (ending == Ending::kTooSlow) return "too short";
      return judge::is_unstable(ending) ? "grows" : "stable";
    }
    judge::TrialBounds bounds;
    bounds.horizon = options_.value("horizon", bounds.horizon);
    if (answer_.rounding > 1e-10) bounds.growth_factor = 1e3;  // less room between rounding and large motions
    switch (judge::read_trial(*end.trial, bounds, where)) {
      case judge::TrialEnding::kStable:
        return "stable";
      case judge::TrialEnding::kGrows:
        return "grows";
      case judge::TrialEnding::kTooShort:
        break;
    }
    return "too short";
  }

  void judge_bracket() {
    const auto said = number_of(report_, "measured_step_s");
    if (!answer_.bracket) {
      if (said)
        findings_.push_back("it says that it measured " + short_number(*said) + " s and shows no bracket");
      return;
    }
    const StabilityBracket& bracket = *answer_.bracket;
    const std::string lower = read_end(bracket.lower, "history.json: bracket.lower");
    const std::string upper = read_end(bracket.upper, "history.json: bracket.upper");
    figures_["bracket"] = {{"by", bracket.by},
                           {"lower_s", bracket.lower.step_s},
                           {"upper_s", bracket.upper.step_s},
                           {"lower", lower},
                           {"upper", upper}};
    const std::size_t before = findings_.size();
    if (lower != "stable")
      findings_.push_back("it says that the step " + short_number(bracket.lower.step_s) +
                          " s is stable, by its history it is " + (lower == "grows" ? "not" : lower));
    if (upper != "grows")
      findings_.push_back("it says that the step " + short_number(bracket.upper.step_s) +
                          " s is too long, by its history it is " + upper);
    if ((bracket.by == "runs") != is_large())
      findings_.push_back("its bracket is by " + bracket.by + ", which belongs to " +
                          (is_large() ? "small" : "large") + " motions");
    if (!(bracket.lower.step_s < bracket.upper.step_s) ||
        !(bracket.upper.step_s <= kWidestBracket * bracket.lower.step_s))
      findings_.push_back("its bracket from " + short_number(bracket.lower.step_s) + " to " +
                          short_number(bracket.upper.step_s) + " s is not one of at most 2.5%");
    const double measured = std::sqrt(bracket.lower.step_s) * std::sqrt(bracket.upper.step_s);
    if (!said || !is_same(*said, measured))
      findings_.push_back("it says that it measured " + report_.value("measured_step_s", json()).dump() +
                          " s, the middle of its bracket is " + short_number(measured) + " s");
    check_around(measured);
    if (findings_.size() == before) add_measured(measured);
  }

  /// The first run is below the measured step, the second beyond.
  void check_around(double measured) {
    const auto& runs = answer_.runs;
    if (runs.size() < 2 || !(runs[0].step_s <= measured) || !(runs[1].step_s >= measured))
      findings_.push_back("its first two runs are not below and beyond the measured step");
  }

  void add_measured(double measured) {
    figures_["measured_step_s"] = measured;
    const auto least = number_of(report_, "predicted_step_s");
    const auto most = number_of(report_, "predicted_at_most_s");
    if (least && most && *least > 0.0 && *least <= *most)
      figures_["measured_over_predicted"] = measured / std::clamp(measured, *least, *most);
    if (const auto rows = number_of(report_, "row_sum_step_s"))
      figures_["row_sum_over_measured"] = *rows / measured;
  }

  const StabilityInput& input_;
  const json& options_;
  const json& report_;
  const StabilityAnswer& answer_;
  judge::RunBounds bounds_;
  json figures_;
  std::vector<std::string> findings_;
};

}  // namespace

json judge_stability(const StabilityInput& input, const json& options, const json& report,
                     const std::filesystem::path& file) {
  const StabilityAnswer answer = read_stability_answer(file, input.mesh);
  return AnswerJudge(input, options, report, answer).figures();
}

json pick_reported(const json& report) {
  json out = json::object();
  for (const char* key :
       {"outcome", "predicted_step_s", "predicted_at_most_s", "predicted_at_start_s", "predicted_is_exact",
        "row_sum_step_s", "measured_by", "measured_step_s", "measured_stable_s", "measured_unstable_s",
        "vertices", "trials", "trial_steps", "springs", "mass_ratio", "volume_ratio", "rate_per_s"}) {
    if (report.contains(key)) out[key] = report.at(key);
  }
  out["runs"] = json::array();
  for (const json& run : report.value("runs", json::array())) {
    json own = json::object();
    for (const char* key : {"outcome", "step_over_predicted", "time_s", "vertex", "growth_per_step"}) {
      if (run.contains(key)) own[key] = run.at(key);
    }
    out["runs"].push_back(std::move(own));
  }
  return out;
}

void add_agreement_violations(json& record) {
  if (record.at("options").value("regime", "") != "small") return;
  const json& judge = record.at("judge");
  const json ratio = judge.value("measured_over_predicted", json());
  // Where the prediction is no more than a safe one, the measured step may be longer.
  const bool is_exact = record.at("reported").value("predicted_is_exact", true);
  const double off = ratio.is_number() ? ratio.get<double>() - 1.0 : 0.0;
  if (off < -kAgreement || (is_exact && off > kAgreement))
    record["violations"].push_back("the measured step is " + short_number(ratio.get<double>()) +
                                   " of the predicted one, within 2% is accepted");
  const json rows = judge.value("row_sum_over_measured", json());
  if (rows.is_number() && rows.get<double>() > 1.0 + kAgreement)
    record["violations"].push_back("the row sums' step is " + short_number(rows.get<double>()) +
                                   " of the measured one");
}

}  // namespace palpate::experiments

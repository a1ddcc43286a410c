#include "experiments/records/case_record.h"

#include <array>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/files/file_hash.h"
#include "experiments/judging/measure.h"
#include "experiments/records/provenance.h"
#include "experiments/text/terminal.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using reference::or_null;

constexpr const char* kDiffers = "output differs between repeats";

json describe_stop(const Stop& stop) {
  json value = {{"kind", stop_name(stop.kind)}, {"value", nullptr}};
  if (stop.kind == StopKind::kRatio) value["value"] = stop.value;
  if (stop.kind == StopKind::kFusions || stop.kind == StopKind::kTets) {
    value["value"] = static_cast<std::int64_t>(stop.value);
  }
  if (!stop.of.empty()) value["of"] = stop.of;
  return value;
}

json base_record(const Plan& plan, const json& subject) {
  return {{"schema", "palpate/record/1"},
          {"plan", plan.name},
          {"mesh", subject},
          {"message", ""},
          {"violations", json::array()},
          {"null_reasons", json::object()},
          {"report", nullptr},
          {"tuned", json::object()},
          {"searched", false},
          {"notes", json::array()},
          {"judge", nullptr},
          {"output_hash", nullptr},
          {"mesh_file", nullptr}};
}

}  // namespace

void add_bound_violations(const std::vector<AcceptBound>& bounds, json& record) {
  json& violations = record["violations"];
  for (const AcceptBound& bound : bounds) {
    const Measure& measure = *find_measure(bound.measure);
    const auto figure = figure_of(record, measure);
    if (!figure) {
      violations.push_back(bound.measure + " has no figure");
    } else if (bound.max && *figure > *bound.max) {
      violations.push_back(bound.measure + " is " + short_number(*figure) + ", at most " +
                           short_number(*bound.max) + " is accepted");
    } else if (bound.min && *figure < *bound.min) {
      violations.push_back(bound.measure + " is " + short_number(*figure) + ", at least " +
                           short_number(*bound.min) + " is accepted");
    }
  }
}

namespace {

/// What a contestant says of its own end; null where the contest asks for nothing of the kind.
json outcome_of(const json& report) {
  return report.is_object() ? report.value("outcome", json()) : json();
}

/// The judge's figures and violations of an output, from an earlier repeat if it is the same and ended alike.
/// Returns false if it could not be judged; the record then says why.
bool judge_output_file(const OutputJudge& judge, const RepeatFacts& facts, const ContestantAnswer& answer,
                       const std::vector<json>& earlier, json& record) {
  std::error_code error;
  const bool has_output = std::filesystem::is_regular_file(answer.output, error);
  const json hash = has_output ? json(hash_file(answer.output)) : json();
  const json* same = nullptr;
  bool differs = false;
  for (const json& other : earlier) {
    if (!has_output || !other.at("output_hash").is_string()) continue;
    if (other.at("output_hash") == hash) {
      if (outcome_of(other.at("report")) == outcome_of(answer.report)) same = &other;
    } else {
      differs = true;
    }
  }
  if (same != nullptr) {
    record["judge"] = same->at("judge");
  } else {
    auto figures = judge_bounded([&] { return judge.figures(answer.output); }, facts.judge_bounds, record);
    if (!figures) return false;
    record["judge"] = *std::move(figures);
  }
  record["violations"] = json::array();
  if (!record["judge"].value("valid", false))
    record["violations"] = record["judge"].value("findings", json::array());
  if (record["violations"].empty() && !record["judge"].value("valid", false))
    record["violations"].push_back(std::string("the ") + judge.what + " is invalid");
  record["output_hash"] = hash;
  if (!differs) return true;
  if (facts.deterministic) {
    record["violations"].push_back(kDiffers);
  } else {
    record["notes"].push_back(std::string(kDiffers) + ": the method is not deterministic");
  }
  return true;
}

void add_null_reasons(json& record) {
  const std::string reason = record.at("outcome").get<std::string>();
  for (const char* key :
       {"kernel_s", "wall_s", "user_s", "peak_rss_bytes", "report", "judge", "output_hash"}) {
    if (record.contains(key) && record.at(key).is_null()) record["null_reasons"][key] = reason;
  }
}

}  // namespace

std::optional<json> judge_bounded(const std::function<json()>& judge, const WorkBounds& bounds,
                                  json& record) {
  WorkResult result = run_bounded(judge, bounds);
  if (result.end == WorkEnd::kDone) return std::move(result.value);
  record["outcome"] = result.end == WorkEnd::kInterrupted ? "interrupted" : "not_judged";
  record["message"] = "the judge " + result.message;
  return std::nullopt;
}

json start_record(const RepeatFacts& facts, const json& subject, const ContestantAnswer& answer) {
  json record = base_record(facts.plan, subject);
  record["case"] = facts.run_case.id;
  record["contestant"] = facts.contestant.method;
  record["label"] = facts.contestant.label;
  record["required"] = facts.contestant.required;
  record["options"] = facts.run_case.options;
  record["keep"] = facts.contestant.keep;
  record["stop"] = facts.plan.contest == "simplify" ? describe_stop(facts.stop) : json();
  record["sweep"] = facts.run_case.sweep;
  record["seed"] = or_null(facts.run_case.seed);
  record["repeat"] = facts.repeat;
  record["warmup"] = facts.warmup;
  record["kernel_s"] = or_null(answer.kernel_s);
  record["wall_s"] = or_null(answer.wall_s);
  record["user_s"] = or_null(answer.user_s);
  record["peak_rss_bytes"] = or_null(answer.peak_rss_bytes);
  record["outcome"] = answer.outcome;
  record["message"] = answer.message;
  record["finished_at"] = utc_now();
  if (!answer.standard_error.empty()) record["stderr"] = answer.standard_error;
  if (answer.outcome != "ok") return record;
  record["report"] = answer.report;
  record["tuned"] = answer.tuned;
  record["searched"] = answer.searched;
  record["notes"] = answer.notes;
  return record;
}

void judge_answer(const OutputJudge& judge, const RepeatFacts& facts, const ContestantAnswer& answer,
                  const std::vector<json>& earlier, json& record) {
  if (answer.outcome == "ok") {
    try {
      if (judge_output_file(judge, facts, answer, earlier, record)) {
        judge.add_violations(record);
        add_bound_violations(facts.plan.accept, record);
        const bool accepted = record.at("violations").empty();
        record["outcome"] = accepted ? "accepted" : "rejected";
        if (!accepted) record["message"] = reason_of(record);
      }
    } catch (const json::exception& error) {  // a figure of its report has another type than it must have
      record["outcome"] = "bad_answer";
      record["message"] = std::string("its report: ") + error.what();
      record["judge"] = nullptr;
      record["output_hash"] = nullptr;
      record["violations"] = json::array();
    } catch (const InputError& error) {
      std::string message = error.what();  // names the scratch file: of no use to a reader
      const std::size_t name = message.find(answer.output.filename().string());
      if (name != std::string::npos) message.erase(0, name);
      record["outcome"] = "bad_answer";
      record["message"] = std::string("its ") + judge.what + " cannot be read: " + message;
    }
  }
  if (record.at("outcome") == "accepted") record.erase("stderr");
  add_null_reasons(record);
}

json start_input_record(const Plan& plan, const json& subject, const std::string& case_id,
                        const std::string& label) {
  json record = base_record(plan, subject);
  record["case"] = case_id;
  record["contestant"] = nullptr;
  record["label"] = label;
  record["required"] = true;
  record["options"] = json::object();
  record["keep"] = json::array();
  record["stop"] = nullptr;
  record["sweep"] = json::object();
  record["seed"] = nullptr;
  record["repeat"] = 0;
  record["warmup"] = false;
  for (const char* key : {"kernel_s", "wall_s", "user_s", "peak_rss_bytes"}) record[key] = nullptr;
  record["outcome"] = "accepted";
  record["finished_at"] = utc_now();
  return record;
}

std::string reason_of(const json& record) {
  const json violations = record.value("violations", json::array());
  if (violations.empty()) return record.value("message", "");
  const std::string first = violations.front().get<std::string>();
  return violations.size() == 1 ? first : first + " (and " + std::to_string(violations.size() - 1) + " more)";
}

}  // namespace palpate::experiments

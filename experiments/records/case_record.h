// One record: who ran on what, how it went, and what the judge says (palpate/record/1).
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/contestants/contestant_run.h"
#include "experiments/plan_reader/case_list.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/processes/bounded_work.h"

namespace palpate::experiments {

/// What is known of a repeat before it runs.
struct RepeatFacts {
  const Plan& plan;
  const Case& run_case;
  const PlanContestant& contestant;
  Stop stop;  ///< resolved where it could be; contest simplify alone
  int repeat = 0;
  bool warmup = false;
  bool deterministic = true;  ///< whether another output than an earlier repeat's is a violation
  WorkBounds judge_bounds{};  ///< of the child that judges
};

/// How a contest judges an output.
struct OutputJudge {
  /// Figures of the output file (which is missing where a numerical outcome left none); "valid" and
  /// "findings" are among them. Throws: InputError if it cannot be read.
  std::function<nlohmann::json(const std::filesystem::path&)> figures;
  /// Adds violations that follow from the whole record.
  std::function<void(nlohmann::json&)> add_violations;
  const char* what;  ///< "mesh", for messages
};

/// A record with everything but a judgement; its outcome is the answer's. `subject` is its key "mesh".
nlohmann::json start_record(const RepeatFacts& facts, const nlohmann::json& subject,
                            const ContestantAnswer& answer);

/// Judges an answer that is "ok" in a child, and ends the record. `earlier` are the records of the case so
/// far: the same output of the same outcome is not judged again, another output is a violation. If the judge
/// runs out of its bounds the outcome is "not_judged", never "accepted"; "interrupted" if the stop flag rose.
/// Keys: experiments/schema/record.schema.json.
void judge_answer(const OutputJudge& judge, const RepeatFacts& facts, const ContestantAnswer& answer,
                  const std::vector<nlohmann::json>& earlier, nlohmann::json& record);

/// The value of `judge`, which runs in a child with these bounds. Nothing if it ran out of them: the record's
/// outcome is then "not_judged" and its message says why ("interrupted" if the stop flag rose).
std::optional<nlohmann::json> judge_bounded(const std::function<nlohmann::json()>& judge,
                                            const WorkBounds& bounds, nlohmann::json& record);

/// Adds a violation for each bound that the record's figures do not keep, or have no figure for.
void add_bound_violations(const std::vector<AcceptBound>& bounds, nlohmann::json& record);

/// The record of something that no contestant of the plan made ("input", "reference"), to be filled.
nlohmann::json start_input_record(const Plan& plan, const nlohmann::json& subject, const std::string& case_id,
                                  const std::string& label);

/// One line that says why a record is not accepted; empty if it is.
std::string reason_of(const nlohmann::json& record);

}  // namespace palpate::experiments

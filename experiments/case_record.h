// One record: who ran on what, how it went, and what the judge says (palpate/record/1).
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/case_list.h"
#include "experiments/contestant_run.h"
#include "experiments/plan.h"
#include "experiments/plan_mesh.h"

namespace palpate::experiments {

/// What is known of a repeat before it runs.
struct RepeatFacts {
  const Plan& plan;
  const Case& run_case;
  const PlanContestant& contestant;
  const RunMesh& mesh;
  Stop stop;  ///< resolved where it could be
  int repeat = 0;
  bool warmup = false;
  bool deterministic = true;  ///< whether another output than an earlier repeat's is a violation
};

/// Judges the answer's mesh and builds its record. `earlier` are the records of the case so far: the same
/// output is not judged again, another output is a violation. Keys: experiments/schema/record.schema.json.
nlohmann::json build_record(const RepeatFacts& facts, const ContestantAnswer& answer,
                            const std::vector<nlohmann::json>& earlier);

/// The record of an input mesh, with label "input".
nlohmann::json build_input_record(const Plan& plan, const RunMesh& mesh);

/// Why a record is not accepted, in one line.
std::string reason_of(const nlohmann::json& record);

}  // namespace palpate::experiments

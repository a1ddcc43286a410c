// How an answer of the contest stability is judged: each run by its history, the measured step by the two
// ends of its bracket, and what the contestant says of itself by both.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "experiments/contests/stability/stability_input.h"

namespace palpate::experiments {

/// The record's block "judge": "valid", "findings", "ending" (of the single run, or of the one just beyond
/// the measured step), "runs" (each as the judge reads it), the body's angles; and for a measurement whose
/// bracket holds, "bracket", "measured_step_s", "measured_over_predicted" (with the prediction that is
/// reported) and "row_sum_over_measured" (alike). A bracket holds if the history at its lower end is stable
/// and that at its upper end is not. Throws: InputError if the file cannot be read as
/// palpate/stability_answer/1, or the report's runs are none.
nlohmann::json judge_stability(const StabilityInput& input, const nlohmann::json& options,
                               const nlohmann::json& report, const std::filesystem::path& file);

/// The record's block "reported": of the report, what the judge cannot know: the predictions, the row sums,
/// how was measured, what the contestant itself says of its runs. Throws: json::exception for a report of
/// another form.
nlohmann::json pick_reported(const nlohmann::json& report);

/// Of small motions the judged step has to be the predicted one to 2% (where the prediction is only a safe
/// one: no shorter), and row sums no longer than it. Adds what is not so to the record's violations.
void add_agreement_violations(nlohmann::json& record);

}  // namespace palpate::experiments

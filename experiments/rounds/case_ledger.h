// What a run's records say of its cases and inputs: which repeats are still to be run.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "experiments/plan_reader/case_list.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/rounds/case_state.h"
#include "experiments/rounds/halving.h"

namespace palpate::experiments {

/// The books of one run. Plan and cases outlive it.
class CaseLedger {
 public:
  CaseLedger(const Plan& plan, const std::vector<Case>& cases);

  /// Takes in all records of a file, in the place of what was known. A record of no case is an input's.
  /// Throws: InputError as for_each_record does.
  void load(const std::filesystem::path& records);

  /// Takes the record of a case in, and lets go of what no further repeat of it needs.
  void remember(std::size_t index, const nlohmann::json& record);

  /// Takes an input's record in: that there is one, and why it failed.
  void note_input(const nlohmann::json& record);

  const CaseState& state(std::size_t index) const { return states_[index]; }
  const std::set<std::string>& recorded_inputs() const { return recorded_inputs_; }  ///< by their case
  /// Inputs that were not accepted, outcome and reason, by their case.
  const std::map<std::string, std::string>& failed_inputs() const { return failed_inputs_; }

  /// The most rounds of any case, with its warm-up.
  int rounds() const;
  /// Whether this repeat (0 is the first warm-up) is to be run.
  bool is_due(std::size_t index, int repeat) const;
  /// Whether any repeat is to be run.
  bool has_due(std::size_t index) const { return count_due(index) > 0; }
  int count_due(std::size_t index) const;

  /// After so many measured repeats, if that ends a rung of the plan's halving: cases that cannot be on the
  /// frontier any more (find_halved) get no more repeats. Returns: these, and how many repeats each had due.
  std::map<std::size_t, int> halve(int measured, const std::vector<std::size_t>& selected);

  /// Says in a provenance how many repeats each case has to have, and why they ended (case_state.h).
  void state_repeats(nlohmann::json& provenance) const;

 private:
  RepeatBounds bounds_of(std::size_t index) const { return repeat_bounds(plan_.run, cases_[index]); }

  const Plan& plan_;
  const std::vector<Case>& cases_;
  std::vector<CaseState> states_;
  HalvingRecords halving_;
  std::set<std::string> recorded_inputs_;
  std::map<std::string, std::string> failed_inputs_;
};

}  // namespace palpate::experiments

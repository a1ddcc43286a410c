// What gates need of a run's records: a small row each, so that 10^6 of them can be held.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "experiments/judging/measure.h"

namespace palpate::experiments {

/// What is kept of a record. Names, words and plans lie once each in the RunRows that the row is of.
struct RunRow {
  const std::string* run_case;
  const std::string* outcome;
  const std::string* message;      ///< null where it says nothing, or is accepted
  const std::string* output_hash;  ///< null where it left no output
  const nlohmann::json* plan;      ///< its key "plan"; null (as JSON) without one
  std::int64_t repeat;
  int place = -1;                              ///< of its case in the plan's order; -1: no case of the plan
  bool is_answer;                              ///< a contestant's; an input's or a reference's is none
  bool is_required;                            ///< its failure is the run's
  bool is_warmup;                              ///< it counts for nothing that is timed
  bool has_searched;                           ///< its process also made the search for the stop
  bool has_coarse_reference;                   ///< reference_too_coarse
  std::vector<std::optional<double>> figures;  ///< of the RunRows' measures, in their order
};

/// The rows of a run.
class RunRows {
 public:
  /// No rows yet. Of each record the figures of these measures are kept.
  explicit RunRows(std::vector<const Measure*> measures);
  RunRows(RunRows&&) = default;
  RunRows& operator=(RunRows&&) = default;

  /// Takes in what is needed of a record of `file`. Throws: InputError for a flag that is no boolean.
  void add(const nlohmann::json& record, const std::string& file);

  /// Orders the rows by repeat, and those of one repeat by the place of their case; what has no place comes
  /// first. Equal ones stay in their order.
  void sort(const std::map<std::string, int>& places);

  const std::vector<RunRow>& all() const { return rows_; }

  /// The rows of a case in their order; none of a case that the run does not have.
  std::vector<const RunRow*> of_case(const std::string& run_case) const;

  /// The figure that a row's record has; nothing if it has none. `measure` is one of those that are kept.
  std::optional<double> figure(const RunRow& row, const Measure& measure) const;

 private:
  const std::string* word(const nlohmann::json& record, const char* key);

  std::vector<const Measure*> measures_;
  std::vector<RunRow> rows_;
  std::map<std::string, std::vector<std::size_t>, std::less<>> cases_;  ///< places in rows_
  std::set<std::string> words_;
  std::set<nlohmann::json> plans_;
};

/// The provenance of a run; null where there is none that can be read: who cannot do without it says so.
nlohmann::json known_provenance(const std::filesystem::path& folder);

/// The rows of a run's records, round by round and in the order of the plan's cases, whatever order the
/// rounds were run in; what is no case of the plan (inputs, references) comes first. Without a list of cases
/// in the provenance they stay as they are. No more than one whole record is held at a time.
/// Throws: InputError as read_records and RunRows::add do.
RunRows read_run_rows(const std::filesystem::path& folder, std::vector<const Measure*> measures);

}  // namespace palpate::experiments

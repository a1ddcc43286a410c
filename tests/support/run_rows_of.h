// The rows that a gate reads, of records as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "experiments/judging/measure.h"
#include "experiments/records/run_rows.h"

namespace palpate::test {

/// The rows of `records`, as if a file had them in this order, with the figures of all measures.
inline experiments::RunRows run_rows_of(const std::vector<nlohmann::json>& records) {
  std::vector<const experiments::Measure*> measures;
  for (const experiments::Measure& measure : experiments::list_measures()) measures.push_back(&measure);
  experiments::RunRows rows(measures);
  for (const nlohmann::json& record : records) rows.add(record, "records.jsonl");
  return rows;
}

}  // namespace palpate::test

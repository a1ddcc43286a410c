#include "experiments/records/run_rows.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "experiments/records/provenance.h"
#include "experiments/records/record_file.h"
#include "experiments/records/run_folder.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

bool flag(const json& record, const char* key, bool otherwise, const std::string& file) {
  const auto found = record.find(key);
  if (found == record.end()) return otherwise;
  if (!found->is_boolean())
    throw InputError(file + ": " + record.at("case").get<std::string>() + ": " + key, 0, "true or false",
                     found->type_name());
  return found->get<bool>();
}

/// The place of each case in the plan's order; none if the run's provenance cannot tell.
std::map<std::string, int> planned_places(const json& provenance) {
  std::map<std::string, int> places;
  if (!provenance.is_object()) return places;
  const json cases = provenance.value("cases", json::array());
  for (const json& name : cases) {
    if (name.is_string()) places.emplace(name.get<std::string>(), static_cast<int>(places.size()));
  }
  return places;
}

}  // namespace

RunRows::RunRows(std::vector<const Measure*> measures) : measures_(std::move(measures)) {}

const std::string* RunRows::word(const json& record, const char* key) {
  const auto found = record.find(key);
  const bool is_word = found != record.end() && found->is_string();
  return is_word ? &*words_.insert(found->get_ref<const std::string&>()).first : nullptr;
}

void RunRows::add(const json& record, const std::string& file) {
  static const json::json_pointer coarse_place("/judge/reference_too_coarse");
  const auto own = cases_.try_emplace(record.at("case").get<std::string>()).first;
  own->second.push_back(rows_.size());
  RunRow row{};
  row.run_case = &own->first;
  row.outcome = word(record, "outcome");
  require(row.outcome != nullptr, "RunRows: a record without an outcome");
  row.message = *row.outcome == "accepted" ? nullptr : word(record, "message");
  row.output_hash = word(record, "output_hash");
  row.plan = &*plans_.insert(record.value("plan", json())).first;
  row.repeat = record.at("repeat").get<std::int64_t>();
  row.place = -1;
  row.is_answer = !record.value("contestant", json()).is_null();
  row.is_required = flag(record, "required", true, file);
  row.is_warmup = flag(record, "warmup", false, file);
  row.has_searched = flag(record, "searched", false, file);
  row.has_coarse_reference = record.contains(coarse_place) && record.at(coarse_place) == true;
  row.figures.reserve(measures_.size());
  for (const Measure* measure : measures_) row.figures.push_back(figure_of(record, *measure));
  rows_.push_back(std::move(row));
}

void RunRows::sort(const std::map<std::string, int>& places) {
  for (auto& [name, own] : cases_) {
    const auto place = places.find(name);
    for (const std::size_t i : own) rows_[i].place = place == places.end() ? -1 : place->second;
    own.clear();
  }
  const auto key = [](const RunRow& row) {
    return row.place < 0 ? std::pair(std::int64_t{-1}, -1) : std::pair(row.repeat, row.place);
  };
  std::stable_sort(rows_.begin(), rows_.end(),
                   [&key](const RunRow& a, const RunRow& b) { return key(a) < key(b); });
  for (std::size_t i = 0; i < rows_.size(); ++i) cases_.find(*rows_[i].run_case)->second.push_back(i);
}

std::vector<const RunRow*> RunRows::of_case(const std::string& run_case) const {
  std::vector<const RunRow*> own;
  const auto found = cases_.find(run_case);
  if (found == cases_.end()) return own;
  own.reserve(found->second.size());
  for (const std::size_t i : found->second) own.push_back(&rows_[i]);
  return own;
}

std::optional<double> RunRows::figure(const RunRow& row, const Measure& measure) const {
  const auto found = std::find(measures_.begin(), measures_.end(), &measure);
  require(found != measures_.end(), "RunRows: a figure of a measure that is not kept");
  return row.figures[static_cast<std::size_t>(found - measures_.begin())];
}

json known_provenance(const fs::path& folder) {
  try {
    return read_provenance(RunPaths{folder}.provenance());
  } catch (const InputError&) {
    return {};
  }
}

RunRows read_run_rows(const fs::path& folder, std::vector<const Measure*> measures) {
  RunRows rows(std::move(measures));
  const std::string file = RunPaths{folder}.records().string();
  for_each_record(file, [&](const json& record) { rows.add(record, file); });
  rows.sort(planned_places(known_provenance(folder)));
  return rows;
}

}  // namespace palpate::experiments

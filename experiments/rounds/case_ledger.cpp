#include "experiments/rounds/case_ledger.h"

#include <algorithm>

#include "experiments/records/case_record.h"
#include "experiments/records/record_file.h"

namespace palpate::experiments {

using nlohmann::json;

CaseLedger::CaseLedger(const Plan& plan, const std::vector<Case>& cases)
    : plan_(plan), cases_(cases), states_(cases.size()), halving_(plan, cases) {}

void CaseLedger::load(const std::filesystem::path& records) {
  states_.assign(cases_.size(), {});
  halving_ = HalvingRecords(plan_, cases_);
  recorded_inputs_.clear();
  failed_inputs_.clear();
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < cases_.size(); ++i) index[cases_[i].id] = i;
  for_each_record(records, [&](const json& record) {
    const auto found = index.find(record.at("case").get<std::string>());
    if (found != index.end()) {
      remember(found->second, record);
    } else {
      note_input(record);
    }
  });
}

void CaseLedger::remember(std::size_t index, const json& record) {
  CaseState& state = states_[index];
  const RepeatBounds bounds = bounds_of(index);
  state.remember(record, bounds);
  if (plan_.run.halving_from > 0) halving_.add(index, record);
  if (state.done.size() >= static_cast<std::size_t>(bounds.least) && !has_due(index)) state.drop_answers();
}

void CaseLedger::note_input(const json& record) {
  const std::string id = record.at("case").get<std::string>();
  recorded_inputs_.insert(id);
  if (plan_.run.halving_from > 0) halving_.add_reference(record);
  if (!record.at("contestant").is_null() || record.at("outcome") == "accepted") return;
  failed_inputs_[id] = record.at("outcome").get<std::string>() + ": " + reason_of(record);
}

int CaseLedger::rounds() const {
  int most = 0;
  for (std::size_t i = 0; i < cases_.size(); ++i) most = std::max(most, bounds_of(i).most);
  return plan_.run.warmup + most;
}

bool CaseLedger::is_due(std::size_t index, int repeat) const {
  return states_[index].is_due(repeat, plan_.run.warmup, bounds_of(index));
}

int CaseLedger::count_due(std::size_t index) const {
  return states_[index].count_due(plan_.run.warmup, bounds_of(index));
}

std::map<std::size_t, int> CaseLedger::halve(int measured, const std::vector<std::size_t>& selected) {
  std::map<std::size_t, int> left_out;
  const int first = plan_.run.halving_from;
  if (first == 0 || measured >= plan_.run.repeats || !is_rung(measured, first)) return left_out;
  std::vector<bool> is_open(cases_.size(), false);
  for (const std::size_t index : selected) is_open[index] = states_[index].end != RepeatsEnd::kHalved;
  const auto halved = find_halved(halving_.figures(plan_.run.warmup, measured), is_open);
  for (std::size_t index = 0; index < halved.size(); ++index) {
    if (!halved[index]) continue;
    left_out[index] = count_due(index);
    states_[index].end = RepeatsEnd::kHalved;
    states_[index].halved_by = cases_[*halved[index]].id;
  }
  return left_out;
}

void CaseLedger::state_repeats(json& provenance) const {
  experiments::state_repeats(plan_.run, cases_, states_, provenance);
}

}  // namespace palpate::experiments

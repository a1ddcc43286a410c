#include "experiments/rounds/halving.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "experiments/records/record_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// Errors of a frontier, each with the place of the reference's own in its record.
constexpr std::array<std::pair<const char*, const char*>, 5> kErrors{{
    {"displacement_deformation", "reference_error_deformation"},
    {"displacement_l2", "reference_error"},
    {"displacement_max", "reference_error_max"},
    {"displacement_energy", "reference_error_energy"},
    {"pad_force", "reference_error_pad_force"},
}};

std::optional<double> number_of(const json& record, const char* block, const char* key) {
  const auto at = record.find(block);
  if (at == record.end() || !at->is_object()) return std::nullopt;
  const auto value = at->find(key);
  if (value == at->end() || !value->is_number()) return std::nullopt;
  const double number = value->get<double>();
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

/// The values of a sweep that `names` has, after the scene's name.
std::string group_key(const std::string& scene, const json& sweep, std::initializer_list<const char*> names) {
  std::string key = scene;
  for (const char* name : names) {
    if (sweep.is_object() && sweep.contains(name)) key += "/" + sweep.at(name).dump();
  }
  return key;
}

std::string problem_of(const json& record) {
  return group_key(record.value("/scene/name"_json_pointer, std::string()), record.value("sweep", json()),
                   {"poisson_ratio", "vertices"});
}

double largest_of(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

double least_of(const std::vector<double>& values) {
  return *std::min_element(values.begin(), values.end());
}

bool beats(const HalvingFigures& one, const HalvingFigures& other, const std::string& work,
           const std::string& measure) {
  const auto time = one.times_s.find(work);
  const auto error = one.errors.find(measure);
  if (time == one.times_s.end() || time->second.empty() || error == one.errors.end()) return false;
  return largest_of(time->second) < least_of(other.times_s.at(work)) &&
         error->second.high <= other.errors.at(measure).low;
}

/// The medians above which a case is of the dearer half, by group and work.
std::map<std::pair<std::string, std::string>, double> find_middles(const std::vector<HalvingFigures>& cases,
                                                                   const std::vector<bool>& is_open) {
  std::map<std::pair<std::string, std::string>, std::vector<double>> medians;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (const auto& [work, times] : cases[i].times_s) {
      if (is_open[i] && !times.empty()) medians[{cases[i].group, work}].push_back(median(times));
    }
  }
  std::map<std::pair<std::string, std::string>, double> middles;
  for (const auto& [key, values] : medians) middles[key] = median(values);
  return middles;
}

}  // namespace

std::vector<std::optional<std::size_t>> find_halved(const std::vector<HalvingFigures>& cases,
                                                    const std::vector<bool>& is_open) {
  require(cases.size() == is_open.size(), "find_halved: a flag a case");
  const auto middles = find_middles(cases, is_open);
  std::map<std::string, std::vector<std::size_t>> members;
  for (std::size_t i = 0; i < cases.size(); ++i) members[cases[i].group].push_back(i);
  std::vector<std::optional<std::size_t>> halved(cases.size());
  const auto beaten_by = [&](std::size_t i) -> std::optional<std::size_t> {
    std::optional<std::size_t> first;
    for (const auto& [work, times] : cases[i].times_s) {
      if (times.empty()) continue;
      if (!(median(times) > middles.at({cases[i].group, work}))) return std::nullopt;
      for (const auto& [measure, span] : cases[i].errors) {
        const std::vector<std::size_t>& group = members.at(cases[i].group);
        const auto other =
            std::find_if(group.begin(), group.end(), [&, &w = work, &m = measure](std::size_t k) {
              return k != i && beats(cases[k], cases[i], w, m);
            });
        if (other == group.end()) return std::nullopt;
        if (!first) first = *other;
      }
    }
    return first;
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (is_open[i]) halved[i] = beaten_by(i);
  }
  return halved;
}

bool is_rung(int measured, int first) {
  int rung = first;
  while (rung < measured) rung *= 2;
  return rung == measured;
}

HalvingRecords::HalvingRecords(const Plan& plan, const std::vector<Case>& cases) : cases_(cases.size()) {
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Case& c = cases[i];
    const std::string label = plan.families_of_simplifiers && c.simplifier
                                  ? plan.simplifiers[*c.simplifier].label
                                  : plan.contestants[c.contestant].label;
    const auto family = plan.families.find(label);
    cases_[i].group = group_key(std::to_string(c.subject), c.sweep, {"poisson_ratio"}) + "/" +
                      (family == plan.families.end() ? label : family->second);
  }
}

void HalvingRecords::add_reference(const json& record) {
  if (record.value("label", "") != "reference") return;
  std::map<std::string, double>& own = reference_errors_[problem_of(record)];
  for (const auto& [measure, key] : kErrors) {
    if (const auto error = number_of(record, "judge", key)) own[measure] = *error;
  }
}

void HalvingRecords::add(std::size_t index, const json& record) {
  if (record.value("outcome", "") != "accepted" || record.value("warmup", false)) return;
  Own& own = cases_[index];
  own.problem = problem_of(record);
  for (const auto& [measure, key] : kErrors) {
    if (const auto error = number_of(record, "judge", measure)) own.errors.emplace(measure, *error);
  }
  Repeat repeat;
  repeat.number = record.at("repeat").get<int>();
  const json kernel = record.value("kernel_s", json());
  const double simplify_s = number_of(record, "solved_on", "simplify_s").value_or(0.0);
  if (kernel.is_number()) repeat.times_s["first"] = kernel.get<double>() + simplify_s;
  if (const auto time = number_of(record, "report", "answer_s")) repeat.times_s["further"] = *time;
  if (const auto time = number_of(record, "report", "simulated_second_s")) {
    repeat.times_s["second"] = *time;
    if (const auto setup = number_of(record, "report", "identify_s"))
      repeat.times_s["second_setup"] = simplify_s + *setup + *time;
  }
  own.repeats.push_back(std::move(repeat));
}

std::vector<HalvingFigures> HalvingRecords::figures(int warmup, int measured) const {
  std::vector<HalvingFigures> all;
  all.reserve(cases_.size());
  for (const Own& own : cases_) {
    HalvingFigures& found = all.emplace_back();
    found.group = own.group;
    const auto reference = reference_errors_.find(own.problem);
    for (const auto& [measure, error] : own.errors) {
      ErrorSpan span;
      if (reference != reference_errors_.end()) {
        const auto at = reference->second.find(measure);
        if (at != reference->second.end()) span = {std::max(0.0, error - at->second), error + at->second};
      }
      found.errors[measure] = span;
    }
    for (const Repeat& repeat : own.repeats) {
      if (repeat.number >= warmup + measured) continue;
      for (const auto& [work, time] : repeat.times_s) found.times_s[work].push_back(time);
    }
  }
  return all;
}

}  // namespace palpate::experiments

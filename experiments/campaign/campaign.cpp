#include "experiments/campaign/campaign.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <set>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "experiments/files/output_file.h"
#include "experiments/files/places.h"
#include "experiments/records/record_file.h"
#include "experiments/records/run_folder.h"
#include "experiments/registry/contestant.h"
#include "experiments/registry/method_options.h"
#include "experiments/registry/option_spec.h"
#include "experiments/registry/registry.h"
#include "experiments/rounds/case_groups.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr double kMebibyte = 1024.0 * 1024.0;
constexpr double kMemoryMargin = 1.25;
constexpr std::size_t kOwnMemoryMib =
    1024;  // of the program, and of its judge on a mesh of some 100,000 tets
constexpr double kTimeMargin = 4.0;
constexpr double kExtraSeconds = 600.0;  // inputs that are made anew, a slow file system
constexpr double kInputSeconds = 60.0;   // of a mesh
constexpr double kDaySeconds = 86400.0;
constexpr std::size_t kReferenceMemoryMib = 8192;  // at least: a reference has no bound of its own
constexpr double kSecondsARecord = 0.7e-3;         // four times what taking, resuming and a report took
constexpr double kMebibytesARecord = 1e-3;

const std::vector<std::string> kFiles{"Snakefile", "slurm/config.yaml", "slurm/status.py"};

std::string part_name(std::size_t number) {
  std::ostringstream name;
  name << std::setw(4) << std::setfill('0') << number;
  return name.str();
}

/// What the cases of one group ask for together.
struct Group {
  std::vector<std::size_t> cases;
  double seconds = 0.0;
  double longest_seconds = 0.0;  // if every repeat runs into its time-out
  double memory_mib = 0.0;
  bool is_timed = false;
};

std::vector<Group> list_groups(const Plan& plan, const std::vector<Case>& cases,
                               const std::map<std::string, CaseCost>& costs, double unknown_seconds) {
  const std::vector<bool> timed = find_timed(plan, cases);
  const std::vector<std::size_t> group = group_cases(cases, timed);
  std::map<std::size_t, Group> groups;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Group& own = groups[group[i]];
    const auto known = costs.find(cases[i].id);
    const double repeats = plan.run.warmup + most_repeats_of(plan.run, cases[i]);
    own.cases.push_back(i);
    own.seconds += repeats * (known != costs.end() ? known->second.seconds : unknown_seconds);
    own.longest_seconds += repeats * (plan.run.timeout_s + plan.run.judge_timeout_s);
    own.memory_mib =
        std::max(own.memory_mib, known != costs.end() ? kMemoryMargin * known->second.memory_mib
                                                      : static_cast<double>(plan.run.memory_mib));
    own.is_timed = own.is_timed || timed[i];
  }
  std::vector<Group> list;
  list.reserve(groups.size());
  for (auto& [first, own] : groups) list.push_back(std::move(own));
  return list;
}

std::size_t minutes_of(double seconds) {
  return static_cast<std::size_t>(std::ceil(seconds / 60.0));
}

/// The time of all solutions that a reference is made of, as its record tells it; 0 if it tells none.
double reference_seconds(const json& record) {
  double seconds = 0.0;
  const json judge = record.value("judge", json());
  for (const char* list : {"level_reports", "runs"}) {
    const json solutions = judge.is_object() ? judge.value(list, json()) : json();
    if (!solutions.is_array()) continue;
    for (const json& one : solutions) {
      const json own = one.is_object() ? one.value("kernel_s", json()) : json();
      if (own.is_number()) seconds += own.get<double>();
    }
  }
  return seconds;
}

bool has_references(const Plan& plan) {
  return plan.reference || std::any_of(plan.contestants.begin(), plan.contestants.end(),
                                       [](const PlanContestant& one) { return !one.train.empty(); });
}

json request_json(const JobRequest& request) {
  return {{"minutes", request.minutes}, {"memory_mib", request.memory_mib}};
}

}  // namespace

std::map<std::string, CaseCost> read_costs(const std::vector<fs::path>& runs) {
  std::map<std::string, std::vector<double>> seconds;
  std::map<std::string, CaseCost> costs;
  for (const fs::path& run : runs) {
    for_each_record(find_run(run) / "records.jsonl", [&](const json& record) {
      if (record.value("contestant", json()).is_null()) {
        const double own = reference_seconds(record);
        if (own > 0.0) seconds[record.at("case").get<std::string>()].push_back(own);
        return;
      }
      if (!record.value("wall_s", json()).is_number()) return;
      const std::string id = record.at("case").get<std::string>();
      seconds[id].push_back(record.at("wall_s").get<double>());
      const json memory = record.value("peak_rss_bytes", json());
      if (memory.is_number())
        costs[id].memory_mib = std::max(costs[id].memory_mib, memory.get<double>() / kMebibyte);
    });
  }
  for (const auto& [id, times] : seconds) costs[id].seconds = median(times);
  return costs;
}

std::vector<CampaignPart> split_campaign(const Plan& plan, const std::vector<Case>& cases,
                                         const std::map<std::string, CaseCost>& costs,
                                         const CampaignSettings& settings) {
  std::vector<CampaignPart> parts;
  double longest = 0.0;
  for (const Group& group : list_groups(plan, cases, costs, settings.unknown_seconds)) {
    const bool is_full = parts.empty() || parts.back().is_timed != group.is_timed ||
                         parts.back().seconds + group.seconds > settings.job_seconds;
    if (is_full) {
      parts.emplace_back().name = part_name(parts.size());
      longest = 0.0;
    }
    CampaignPart& part = parts.back();
    for (const std::size_t i : group.cases) part.cases.push_back(cases[i].id);
    part.seconds += group.seconds;
    longest += group.longest_seconds;
    part.is_timed = group.is_timed;
    const double asked = kExtraSeconds + std::min(kTimeMargin * part.seconds, longest);
    part.minutes = minutes_of(asked);
    part.memory_mib =
        std::max(part.memory_mib, kOwnMemoryMib + static_cast<std::size_t>(std::ceil(group.memory_mib)));
  }
  return parts;
}

CampaignEnds request_ends(const Plan& plan, const std::vector<Case>& cases,
                          const std::map<std::string, CaseCost>& costs,
                          const std::vector<CampaignPart>& parts) {
  std::set<std::string> ids;
  double records = 0.0;
  for (const Case& c : cases) {
    ids.insert(c.id);
    records += plan.run.warmup + most_repeats_of(plan.run, c);
  }
  double known = 0.0;  // of inputs
  for (const auto& [id, cost] : costs) known += ids.count(id) == 0 ? cost.seconds : 0.0;
  const bool is_solved = has_references(plan);
  double asked = kExtraSeconds + kInputSeconds * static_cast<double>(plan.meshes.size() + plan.scenes.size());
  if (is_solved) asked = known > 0.0 ? asked + kTimeMargin * known : kDaySeconds;
  CampaignEnds ends;
  ends.prepare.minutes = minutes_of(std::min(asked, kDaySeconds));
  ends.prepare.memory_mib =
      std::max<std::size_t>(is_solved ? kReferenceMemoryMib : 0, kOwnMemoryMib + plan.run.memory_mib);
  ends.gather = {0, ends.prepare.memory_mib};
  for (const CampaignPart& part : parts) {
    ends.gather.minutes = std::max(ends.gather.minutes, part.minutes);
    ends.gather.memory_mib = std::max(ends.gather.memory_mib, part.memory_mib);
  }
  ends.gather.minutes += ends.prepare.minutes + minutes_of(kExtraSeconds + kSecondsARecord * records);
  const auto own = static_cast<std::size_t>(std::ceil(kMebibytesARecord * records));
  ends.gather.memory_mib = std::max(ends.gather.memory_mib, kOwnMemoryMib + own);
  return ends;
}

int most_ranks_of(const Plan& plan, const std::vector<Case>& cases, const Registry& registry) {
  int most = 1;
  for (const Case& c : cases) {
    const MethodSpec& method = *registry.find(plan.contestants[c.contestant].method)->method;
    most = std::max(most, count_ranks(method.options, c.options));
  }
  const auto look = [&](const std::string& name, const std::map<std::string, GivenOption>& given) {
    if (name.empty()) return;
    const MethodSpec& method = *registry.find(name)->method;
    most = std::max(most, count_ranks(method.options, resolve_options(method, given)));
  };
  for (const PlanContestant& simplifier : plan.simplifiers) look(simplifier.method, simplifier.set);
  if (plan.reference) look(plan.reference->method, plan.reference->set);
  return most;
}

void write_campaign(const Campaign& campaign, const fs::path& folder) {
  create_folder(folder);
  if (!fs::is_empty(folder))
    throw InputError(folder.string(), 0, "an empty folder for the workflow", "other files");
  json listed = json::array();
  create_folder(folder / "cases");
  for (const CampaignPart& part : campaign.parts) {
    std::string lines;
    for (const std::string& id : part.cases) lines += id + "\n";
    write_file_atomically(folder / "cases" / (part.name + ".txt"), lines);
    listed.push_back({{"name", part.name},
                      {"cases", part.cases.size()},
                      {"seconds", part.seconds},
                      {"minutes", part.minutes},
                      {"memory_mib", part.memory_mib},
                      {"timed", part.is_timed}});
  }
  const json told = {{"schema", "palpate/campaign/1"},
                     {"palpate", program_folder() + "/palpate"},
                     {"plan", fs::absolute(campaign.plan).lexically_normal().string()},
                     {"threads", campaign.threads},
                     {"processors", campaign.threads * campaign.most_ranks},
                     {"prepare", request_json(campaign.ends.prepare)},
                     {"gather", request_json(campaign.ends.gather)},
                     {"parts", listed}};
  write_file_atomically(folder / "campaign.json", told.dump(1) + "\n");
  const fs::path from = fs::path(source_folder()) / "experiments" / "campaign" / "workflow";
  create_folder(folder / "slurm");
  create_folder(folder / "logs");  // where Slurm writes before a job starts
  for (const std::string& name : kFiles) {
    std::error_code error;
    fs::copy_file(from / name, folder / name, error);
    if (error) fail_to_write(folder / name, "a file that can be written", error.value());
  }
}

}  // namespace palpate::experiments

#include "experiments/runner/read_plan.h"

#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "experiments/files/places.h"
#include "experiments/plan_reader/plan_report.h"
#include "experiments/registry/method_options.h"
#include "experiments/registry/option_spec.h"
#include "experiments/registry/registry.h"
#include "experiments/runner/contest_table.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/yaml_schema.h"

namespace palpate::experiments {
namespace {

constexpr const char* kPlanSchema = "palpate/plan/1";
constexpr std::int64_t kMostRanks = 1024;
/// Fewer repeats than this part equal cases by chance too often (rounds/halving.h).
constexpr int kLeastRung = 3;
constexpr std::int64_t kLargestOrderSeed = std::int64_t{1} << 40;

/// until_width and most_repeats: one is nothing without the other.
void read_width(const YamlFields& fields, RunSettings& run) {
  const auto width = fields.find("until_width");
  const auto most = fields.find("most_repeats");
  if (most && !width)
    most->fail("\"most_repeats\" needs \"until_width\": repeats are asked for by \"repeats\"");
  if (!width) return;
  if (!run.timed) width->fail("\"until_width\" is of times, and the plan says \"timed: false\"");
  if (!most) width->fail("\"until_width\" needs \"most_repeats\": an interval may never get so narrow");
  run.until_width = width->number(1e-6, 1e3);
  run.most_repeats = static_cast<int>(most->integer(run.repeats, 10'000));
}

/// halving_from, which needs repeats to leave out.
void read_halving(const YamlFields& fields, RunSettings& run) {
  const auto from = fields.find("halving_from");
  if (!from) return;
  if (!run.timed) from->fail("\"halving_from\" is of times, and the plan says \"timed: false\"");
  if (run.until_width) from->fail("\"halving_from\" goes with \"repeats\", not with \"until_width\"");
  if (run.repeats <= kLeastRung)
    from->fail("\"halving_from\" needs more than " + std::to_string(kLeastRung) +
               " \"repeats\" to leave some out");
  run.halving_from = static_cast<int>(from->integer(kLeastRung, run.repeats - 1));
}

RunSettings read_run(const YamlValue& value) {
  const YamlFields fields =
      value.fields({"repeats", "seed_repeats", "warmup", "threads", "timeout_s", "memory_mib",
                    "judge_timeout_s", "judge_memory_mib", "until_width", "most_repeats", "order_seed",
                    "timed", "mpi_ranks", "halving_from"});
  RunSettings run;
  if (const auto v = fields.find("repeats")) run.repeats = static_cast<int>(v->integer(1, 10'000));
  if (const auto v = fields.find("seed_repeats")) run.seed_repeats = static_cast<int>(v->integer(1, 10'000));
  if (const auto v = fields.find("warmup")) run.warmup = static_cast<int>(v->integer(0, 1'000));
  if (const auto v = fields.find("threads")) run.threads = static_cast<int>(v->integer(1, 1'024));
  if (const auto v = fields.find("mpi_ranks")) run.mpi_ranks = static_cast<int>(v->integer(1, kMostRanks));
  if (const auto v = fields.find("timeout_s")) run.timeout_s = v->number(0.01, 1e7);
  if (const auto v = fields.find("memory_mib")) {
    run.memory_mib = static_cast<std::uint64_t>(v->integer(16, 1 << 24));
  }
  if (const auto v = fields.find("judge_timeout_s")) run.judge_timeout_s = v->number(0.01, 1e7);
  if (const auto v = fields.find("judge_memory_mib")) {
    run.judge_memory_mib = static_cast<std::uint64_t>(v->integer(1, 1 << 24));
  }
  if (const auto v = fields.find("order_seed")) run.order_seed = v->integer(0, kLargestOrderSeed);
  if (const auto v = fields.find("timed")) run.timed = v->boolean();
  read_width(fields, run);
  read_halving(fields, run);
  return run;
}

std::vector<AcceptBound> read_accept(const YamlValue& value) {
  std::vector<AcceptBound> bounds;
  for (const auto& [name, entry] : value.entries()) bounds.push_back(read_bound(name, entry));
  return bounds;
}

void read_measures(const YamlValue& value, bool timed, std::vector<std::string>& measures) {
  for (const YamlValue& item : value.items()) {
    const std::string name = item.text();
    known_measure(item, name, false);
    if (!timed && is_clock_time(name)) item.fail(name + " is a time, and the plan says \"timed: false\"");
    if (std::find(measures.begin(), measures.end(), name) != measures.end()) {
      item.fail("measure \"" + name + "\" twice");
    }
    measures.push_back(name);
  }
}

std::string plan_name(const std::filesystem::path& path) {
  const std::string stem = path.stem().string();
  std::string name;
  for (const char c : stem) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '_' || c == '-' || c == '.';
    name += plain ? c : '_';
  }
  return name.empty() ? "plan" : name;
}

bool has_key(const ContestKind& kind, const std::string& key) {
  return std::find(kind.keys.begin(), kind.keys.end(), key) != kind.keys.end();
}

/// The contest that the plan names. Throws: InputError at `name` for an unknown one.
const ContestKind& known_contest(const YamlValue& name) {
  std::string known;
  const auto& contests = list_contests();
  for (std::size_t i = 0; i < contests.size(); ++i) {
    if (contests[i]->name == name.text()) return *contests[i];
    known += (i == 0 ? "" : i + 1 == contests.size() ? " or " : ", ") + contests[i]->name;
  }
  name.fail_expected(known);
}

/// Refuses keys that belong to other contests alone, and those that this one does not take.
void refuse_keys_of_others(const YamlFields& fields, const ContestKind& own) {
  for (const auto& [key, why] : own.refused) {
    if (const auto extra = fields.find(key)) extra->fail(why);
  }
  for (const ContestKind* kind : list_contests()) {
    for (const std::string& key : kind->keys) {
      const auto extra = fields.find(key);
      if (extra && !has_key(own, key))
        extra->fail("\"" + key + "\" belongs to the contest " + kind->name + ", not to " + own.name);
    }
  }
}

void add_availability_notes(Plan& plan, const Registry& registry) {
  const auto add = [&](const std::string& label, const std::string& method) {
    const std::string why = registry.find(method)->contestant->unavailable();
    if (!why.empty()) plan.notes.push_back(label + " is unavailable: " + why);
  };
  for (const PlanContestant& contestant : plan.contestants) add(contestant.label, contestant.method);
  for (const PlanContestant& simplifier : plan.simplifiers) {
    if (!simplifier.method.empty()) add(simplifier.label, simplifier.method);
  }
  if (plan.reference) add("the reference", plan.reference->method);
}

/// Gives every method of the plan that can run under mpirun the plan's number of ranks, unless its own entry
/// has one. Throws: InputError at `run` if none can, or one can with fewer.
void set_ranks(const YamlValue& run, Plan& plan, const Registry& registry) {
  bool any = false;
  const std::string count = std::to_string(plan.run.mpi_ranks);
  const std::string where = run.file() + ":" + std::to_string(run.line()) + ": run: mpi_ranks";
  const auto set = [&](const std::string& method, std::map<std::string, GivenOption>& given) {
    if (method.empty()) return;
    const OptionSpec* ranks = find_ranks_option(registry.find(method)->method->options);
    if (ranks == nullptr) return;
    any = true;
    if (given.count(ranks->name) > 0) return;
    parse_option(*ranks, count, where);
    given[ranks->name] = {count, where};
  };
  for (PlanContestant& contestant : plan.contestants) set(contestant.method, contestant.set);
  for (PlanContestant& simplifier : plan.simplifiers) set(simplifier.method, simplifier.set);
  if (plan.reference) set(plan.reference->method, plan.reference->set);
  if (!any) run.fail("\"mpi_ranks\" is " + count + ", and no method of the plan can run under mpirun");
}

}  // namespace

std::vector<std::filesystem::path> read_contestant_folders(const std::filesystem::path& path) {
  std::vector<std::filesystem::path> folders;
  const YamlValue root = read_yaml(path);
  require_schema(root, kPlanSchema);
  if (!root.is_map()) return folders;
  for (const auto& [key, value] : root.entries()) {
    if (key != "contestant_folders") continue;
    for (const YamlValue& item : value.items()) {
      const std::filesystem::path folder =
          std::filesystem::absolute(path.parent_path() / item.text()).lexically_normal();
      std::error_code error;
      if (!std::filesystem::is_directory(folder, error)) item.fail("no folder " + folder.string());
      folders.push_back(folder);
    }
    if (folders.empty()) value.fail_expected("at least one folder");
  }
  return folders;
}

std::filesystem::path find_plan(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::is_regular_file(name, error) || fs::path(name).has_parent_path()) return name;
  const bool has_ending = fs::path(name).extension() == ".yaml";
  const std::string file = has_ending ? name : name + ".yaml";
  if (fs::is_regular_file(file, error)) return file;
  const fs::path plans = fs::path(source_folder()) / "experiments" / "plans";
  if (fs::is_regular_file(plans / file, error)) return plans / file;
  std::set<std::string> known;
  for (const auto& entry : fs::directory_iterator(plans, error)) {
    if (entry.path().extension() == ".yaml") known.insert(entry.path().stem().string());
  }
  const std::vector<std::string> names(known.begin(), known.end());
  throw InputError("no plan is called \"" + name + "\", here or in " +
                   (install_prefix() ? plans.string() : "experiments/plans") +
                   nearest_hint(fs::path(file).stem().string(), names));
}

Plan read_plan(const std::filesystem::path& path, const Registry& registry) {
  const YamlValue root = read_yaml(path);
  require_schema(root, kPlanSchema);
  const YamlFields fields = root.fields(list_plan_keys());
  Plan plan;
  plan.file = path;
  plan.name = plan_name(path);
  plan.question = fields.need("question").text();
  if (plan.question.empty()) fields.need("question").fail_expected("a question");
  const ContestKind& contest = known_contest(fields.need("contest"));
  plan.contest = contest.name;
  refuse_keys_of_others(fields, contest);
  if (const auto run = fields.find("run")) plan.run = read_run(*run);
  contest.read(fields, plan, registry);
  if (plan.run.halving_from > 0 && (plan.contest != "deform" || !fields.find("frontier")))
    fields.need("run").fail(
        "\"halving_from\" leaves out what cannot be on the frontier, and the plan has no \"frontier\"");
  if (const auto measure = fields.find("measure")) read_measures(*measure, plan.run.timed, plan.measure);
  if (const auto accept = fields.find("accept")) plan.accept = read_accept(*accept);
  if (const auto charts = fields.find("charts")) plan.charts = read_charts(*charts, contest.charts);
  if (const auto run = fields.find("run"); run && plan.run.mpi_ranks > 1) set_ranks(*run, plan, registry);
  add_availability_notes(plan, registry);
  if (std::string note = timing_note(plan); !note.empty()) plan.notes.push_back(std::move(note));
  return plan;
}

}  // namespace palpate::experiments

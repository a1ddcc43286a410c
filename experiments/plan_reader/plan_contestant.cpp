#include "experiments/plan_reader/plan_contestant.h"

#include <algorithm>

#include "core/base/error.h"
#include "experiments/judging/kept_regions.h"
#include "experiments/plan_reader/plan_report.h"
#include "experiments/scene_reader/shape_fields.h"
#include "experiments/spring_training/training_plan.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

/// A contestant as read, with the places of the parts that are checked later.
struct Entry {
  PlanContestant contestant;
  YamlValue at;
  std::optional<YamlValue> stop_at;
  MethodEntry method;
};

Stop read_stop(const YamlValue& value) {
  const auto entries = value.entries();
  const YamlFields fields = value.fields({"fusions", "tets", "ratio", "limit", "tets_of", "at_its_distance"});
  Stop stop;
  const auto at_its_distance = fields.find("at_its_distance");
  if (at_its_distance) {
    if (!fields.find("tets_of")) at_its_distance->fail("at_its_distance goes with tets_of");
    stop.at_its_distance = at_its_distance->boolean();
  }
  if (entries.size() != (at_its_distance ? 2U : 1U))
    value.fail("stop: expected one of fusions, tets, ratio, limit and tets_of");
  if (const auto label = fields.find("tets_of")) {
    stop.kind = StopKind::kTetsOf;
    stop.of = label->identifier();
    return stop;
  }
  if (const auto limit = fields.find("limit")) {
    if (!limit->boolean()) limit->fail_expected("true (without a stop, a method runs to its limit)");
    return stop;
  }
  for (const StopKind kind : {StopKind::kFusions, StopKind::kTets, StopKind::kRatio}) {
    const auto number = fields.find(stop_name(kind));
    if (!number) continue;
    stop.kind = kind;
    stop.value = read_stop_value(kind, *number);
  }
  return stop;
}

std::vector<std::int64_t> read_seeds(const YamlValue& value) {
  std::vector<std::int64_t> seeds;
  if (!value.is_list()) {
    const std::int64_t count = value.integer(1, 10'000);
    for (std::int64_t seed = 1; seed <= count; ++seed) seeds.push_back(seed);
    return seeds;
  }
  for (const YamlValue& item : value.items()) {
    const std::int64_t seed = item.integer(0, kLargestSeed);
    if (std::find(seeds.begin(), seeds.end(), seed) != seeds.end()) item.fail_expected("seeds that differ");
    seeds.push_back(seed);
  }
  if (seeds.empty()) value.fail_expected("at least one seed");
  return seeds;
}

/// The training plan of a contestant, read once so that what is wrong with it is said now.
std::filesystem::path read_train(const YamlValue& value, const Entry& entry) {
  if (entry.method.method->find_option("springs") == nullptr)
    value.fail("method " + entry.contestant.method + " takes no trained springs");
  const std::filesystem::path file = std::filesystem::path(value.file()).parent_path() / value.text();
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    value.fail("expected a training plan, found none at " + file.string());
  read_training_plan(file);  // throws where something is wrong
  for (const char* option : {"springs", "moduli", "volume"}) {
    if (entry.contestant.set.count(option) > 0)
      value.fail("\"train\" and the option \"" + std::string(option) + "\" exclude each other");
  }
  return std::filesystem::absolute(file).lexically_normal();
}

/// Where of the sweep a contestant runs.
std::map<std::string, std::vector<nlohmann::json>> read_at(const YamlValue& value,
                                                           const std::string& contest) {
  if (contest != "deform")
    value.fail("\"at\" of one contestant belongs to the contest deform, not to " + contest);
  const std::vector<std::string> axes{"poisson_ratio", "vertices", "simplify", "tets_removed_ratio"};
  std::map<std::string, std::vector<nlohmann::json>> places;
  for (const auto& [axis, given] : value.entries()) {
    if (std::find(axes.begin(), axes.end(), axis) == axes.end())
      given.fail("unknown axis \"" + axis + "\"" + nearest_hint(axis, axes));
    std::vector<nlohmann::json>& values = places[axis];
    for (const YamlValue& item : given.is_list() ? given.items() : std::vector<YamlValue>{given}) {
      if (axis == "simplify") {
        values.emplace_back(item.identifier());
      } else {
        values.emplace_back(item.number());
      }
    }
    if (values.empty()) given.fail_expected("at least one value");
  }
  return places;
}

Entry read_entry(const YamlValue& value, const std::string& contest, const Registry& registry) {
  if (value.is_text()) {
    const std::string name = value.text();
    Entry entry{{}, value, std::nullopt, find_method(value, name, contest, registry)};
    entry.contestant.method = name;
    entry.contestant.label = name;
    return entry;
  }
  const YamlFields fields = value.fields({"method", "label", "tags", "stop", "set", "train", "keep", "seeds",
                                          "required", "timed", "scenes", "at", "own_limit", "grade"});
  const YamlValue method = fields.need("method");
  Entry entry{{}, value, fields.find("stop"), find_method(method, method.text(), contest, registry)};
  PlanContestant& contestant = entry.contestant;
  contestant.method = method.text();
  const auto label = fields.find("label");
  contestant.label = label ? label->identifier() : contestant.method;
  contestant.tags = read_tags(fields);
  if (entry.stop_at && contest != "simplify")
    entry.stop_at->fail("stops belong to the contest simplify, not to " + contest);
  if (entry.stop_at) contestant.stop = read_stop(*entry.stop_at);
  if (const auto scenes = fields.find("scenes")) {
    if (contest != "engine")
      scenes->fail("scenes of one contestant belong to the contest engine, not to " + contest);
    for (const YamlValue& item : scenes->items()) contestant.scenes.push_back(item.identifier());
    if (contestant.scenes.empty()) scenes->fail_expected("at least one scene");
  }
  if (const auto at = fields.find("at")) contestant.at = read_at(*at, contest);
  if (const auto required = fields.find("required")) contestant.required = required->boolean();
  if (const auto timed = fields.find("timed")) contestant.timed = timed->boolean();
  if (const auto set = fields.find("set")) contestant.set = read_set(*set, *entry.method.method);
  if (const auto limit = fields.find("own_limit")) {
    if (contest != "motion")
      limit->fail("a contestant's own limit belongs to the contest motion, not to " + contest);
    contestant.own_limit = read_set(*limit, *entry.method.method);
    if (contestant.own_limit.empty()) limit->fail_expected("at least one option");
  }
  if (const auto train = fields.find("train")) contestant.train = read_train(*train, entry);
  if (const auto keep = fields.find("keep")) {
    if (!entry.method.method->keeps)
      keep->fail("method " + contestant.method + " keeps no regions" + keeping_methods(registry));
    contestant.keep = read_kept_regions(*keep);
    contestant.keep_where = keep->file() + ":" + std::to_string(keep->line());
  }
  if (const auto grade = fields.find("grade")) {
    if (entry.method.method->find_option("sizes") == nullptr)
      grade->fail("method " + contestant.method + " takes no sizes: palpate.refined and palpate.surface do");
    if (contestant.set.count("sizes") > 0)
      grade->fail("\"grade\" and the option \"sizes\" exclude each other");
    contestant.grade = read_grade(*grade, registry);
  }
  if (const auto seeds = fields.find("seeds")) {
    if (entry.method.method->find_option("seed") == nullptr) {
      seeds->fail("method " + contestant.method + " has no option \"seed\"");
    }
    if (contestant.set.count("seed") > 0) seeds->fail("\"seeds\" and the option \"seed\" exclude each other");
    contestant.seeds = read_seeds(*seeds);
  }
  return entry;
}

void check_stop_kind(const Entry& entry, StopKind kind) {
  const std::string needed = kind == StopKind::kTetsOf ? "tets" : stop_name(kind);
  if (entry.method.method->takes_stop(needed)) return;
  (entry.stop_at ? *entry.stop_at : entry.at)
      .fail("method " + entry.contestant.method + " cannot stop at " + needed + ", only at " +
            joined(entry.method.method->stops));
}

void check_at_its_distance(const Entry& entry) {
  const std::string bound = kBoundOfDistance;
  if (entry.method.method->find_option(bound) == nullptr ||
      entry.method.method->find_option(kUnitOfDistance) == nullptr)
    entry.stop_at->fail("method " + entry.contestant.method + " has no option \"" + bound +
                        "\" that at_its_distance could set: palpate.surface does");
  if (entry.contestant.set.count(bound) > 0)
    entry.stop_at->fail("at_its_distance and the option \"" + bound + "\" exclude each other");
}

void check_tets_of(const std::vector<Entry>& entries, const Entry& entry) {
  std::vector<std::string> labels;
  labels.reserve(entries.size());
  for (const Entry& other : entries) labels.push_back(other.contestant.label);
  const Entry* at = &entry;
  for (std::size_t steps = 0; at->contestant.stop && at->contestant.stop->kind == StopKind::kTetsOf;
       ++steps) {
    const std::string& of = at->contestant.stop->of;
    if (steps > entries.size() || of == at->contestant.label) {
      entry.stop_at->fail("tets_of goes round in a circle through \"" + of + "\"");
    }
    const auto next = std::find(labels.begin(), labels.end(), of);
    if (next == labels.end()) at->stop_at->fail("unknown label \"" + of + "\"" + nearest_hint(of, labels));
    const Entry& referred = entries[static_cast<std::size_t>(next - labels.begin())];
    if (!referred.contestant.seeds.empty()) {
      at->stop_at->fail("tets_of needs a label without seeds, \"" + of + "\" has some");
    }
    at = &referred;
  }
}

void check_sweep(const std::vector<Entry>& entries, const SweepAxis& axis) {
  if (axis.is_problem()) return;  // of the scenes, whoever solves them
  bool used = false;
  for (const Entry& entry : entries) {
    if (!axis.is_option()) {
      if (entry.contestant.stop) continue;
      check_stop_kind(entry, axis.stop_kind());
      used = true;
      continue;
    }
    const OptionSpec* option = entry.method.method->find_option(axis.option());
    if (option == nullptr || entry.contestant.set.count(axis.option()) > 0) continue;
    if (axis.option() == "seed" && !entry.contestant.seeds.empty()) continue;
    for (const GivenOption& value : axis.texts) parse_option(*option, value.text, value.where);
    used = true;
  }
  if (!used) {
    const std::string why = axis.is_option() ? " has that option free" : " is without a stop of its own";
    throw InputError(axis.texts.front().where + ": the sweep " + axis.name + " meets no contestant that" +
                     why);
  }
}

}  // namespace

MethodEntry find_method(const YamlValue& at, const std::string& name, const std::string& contest,
                        const Registry& registry) {
  const auto entry = registry.find(name);
  if (!entry) at.fail("unknown method \"" + name + "\"" + nearest_hint(name, registry.method_names()));
  if (entry->contestant->contest != contest) {
    at.fail("method " + name + " is in the contest " + entry->contestant->contest + ", not in " + contest);
  }
  return *entry;
}

std::map<std::string, GivenOption> read_set(const YamlValue& value, const MethodSpec& method) {
  std::map<std::string, GivenOption> set;
  for (const auto& [name, option] : value.entries()) {
    set[name] = {option.text(), option.file() + ":" + std::to_string(option.line())};
    const OptionSpec* spec = method.find_option(name);
    if (spec == nullptr || spec->type != OptionType::kFile || set[name].text.empty()) continue;
    set[name].text = (std::filesystem::path(option.file()).parent_path() / option.text()).string();
  }
  resolve_options(method, set);  // throws where a name or a value is wrong
  return set;
}

std::vector<PlanContestant> read_contestants(const YamlValue& value, const std::string& contest,
                                             const std::vector<SweepAxis>& sweep, const Registry& registry) {
  std::vector<Entry> entries;
  for (const YamlValue& item : value.items()) {
    Entry entry = read_entry(item, contest, registry);
    const std::string& label = entry.contestant.label;
    if (label == "input") item.fail("the label \"input\" stands for the input mesh itself");
    for (const Entry& other : entries) {
      if (other.contestant.label == label) item.fail("label \"" + label + "\" twice");
    }
    entries.push_back(std::move(entry));
  }
  if (entries.empty()) value.fail("contestants: expected at least one");
  for (const Entry& entry : entries) {
    if (!entry.contestant.stop) continue;
    check_stop_kind(entry, entry.contestant.stop->kind);
    if (entry.contestant.stop->kind == StopKind::kTetsOf) check_tets_of(entries, entry);
    if (entry.contestant.stop->at_its_distance) check_at_its_distance(entry);
  }
  for (const SweepAxis& axis : sweep) check_sweep(entries, axis);
  std::vector<PlanContestant> contestants;
  contestants.reserve(entries.size());
  for (Entry& entry : entries) contestants.push_back(std::move(entry.contestant));
  return contestants;
}

bool runs_on(const PlanContestant& contestant, const std::string& scene) {
  return contestant.scenes.empty() ||
         std::find(contestant.scenes.begin(), contestant.scenes.end(), scene) != contestant.scenes.end();
}

}  // namespace palpate::experiments

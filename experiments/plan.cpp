#include "experiments/plan.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "experiments/keep.h"
#include "experiments/measure.h"
#include "experiments/nearest_name.h"
#include "experiments/plan_contestant.h"
#include "experiments/plan_deform.h"
#include "experiments/plan_engine.h"
#include "experiments/plan_report.h"
#include "experiments/plan_stability.h"
#include "experiments/plan_targets.h"
#include "experiments/plan_verify.h"
#include "experiments/shape_fields.h"

namespace palpate::experiments {
namespace {

constexpr std::int64_t kMostVertices = std::int64_t{1} << 29;
constexpr std::int64_t kLargestCount = std::int64_t{1} << 40;

PlanMesh read_mesh_entry(const YamlValue& value, const std::filesystem::path& folder) {
  const YamlFields fields = value.fields(with_shape_keys({"name", "make", "file"}));
  PlanMesh mesh;
  mesh.name = fields.need("name").identifier();
  const auto make = fields.find("make");
  const auto file = fields.find("file");
  if (make.has_value() == file.has_value()) value.fail("a mesh needs one of \"make\" and \"file\"");
  if (make) {
    mesh.shape = read_shape_fields(fields, *make);
    return mesh;
  }
  refuse_shape_keys(fields);
  mesh.file = folder / file->text();
  std::error_code error;
  if (!std::filesystem::is_regular_file(mesh.file, error)) {
    file->fail("expected a mesh file, found none at " + mesh.file.string());
  }
  return mesh;
}

std::vector<PlanMesh> read_meshes(const YamlValue& value, const std::filesystem::path& folder) {
  std::vector<PlanMesh> meshes;
  std::set<std::string> names;
  for (const YamlValue& item : value.items()) {
    meshes.push_back(read_mesh_entry(item, folder));
    if (!names.insert(meshes.back().name).second) item.fail("mesh \"" + meshes.back().name + "\" twice");
  }
  if (meshes.empty()) value.fail("meshes: expected at least one");
  return meshes;
}

/// A value of an axis that is no option, checked.
void check_axis_value(const SweepAxis& axis, const YamlValue& value) {
  if (axis.is_stop()) read_stop_value(axis.stop_kind(), value);
  if (axis.name == "poisson_ratio") check_poisson_ratio(value, value.number());
  if (axis.name == "vertices") value.integer(4, kMostVertices);
}

/// `axes`: the names that the plan's contest knows beside option.NAME.
std::vector<SweepAxis> read_sweep(const YamlValue& value, const std::vector<std::string>& axes) {
  std::vector<SweepAxis> sweep;
  bool has_stop = false;
  for (const auto& [key, list] : value.entries()) {
    SweepAxis axis;
    axis.name = key;
    if (!axis.is_option()) {
      if (std::find(axes.begin(), axes.end(), key) == axes.end()) {
        auto known = axes;
        known.emplace_back("option.NAME");
        list.fail("unknown sweep \"" + key + "\"" + nearest_hint(key, known));
      }
      if (axis.is_stop() && has_stop) list.fail("a sweep takes one kind of stop, not two");
      has_stop = has_stop || axis.is_stop();
    }
    std::set<std::string> seen;
    for (const YamlValue& item : list.items()) {
      if (!seen.insert(item.text()).second) item.fail_expected("values that differ");
      if (!axis.is_option()) check_axis_value(axis, item);
      const nlohmann::json number = item.json();
      if (std::find(axis.values.begin(), axis.values.end(), number) != axis.values.end())
        item.fail_expected("values that differ");
      axis.values.push_back(number);
      axis.texts.push_back({item.text(), item.file() + ":" + std::to_string(item.line())});
    }
    if (axis.values.empty()) list.fail_expected("at least one value");
    sweep.push_back(std::move(axis));
  }
  return sweep;
}

RunSettings read_run(const YamlValue& value) {
  const YamlFields fields = value.fields(
      {"repeats", "warmup", "threads", "timeout_s", "memory_mib", "judge_timeout_s", "judge_memory_mib"});
  RunSettings run;
  if (const auto v = fields.find("repeats")) run.repeats = static_cast<int>(v->integer(1, 10'000));
  if (const auto v = fields.find("warmup")) run.warmup = static_cast<int>(v->integer(0, 1'000));
  if (const auto v = fields.find("threads")) run.threads = static_cast<int>(v->integer(1, 1'024));
  if (const auto v = fields.find("timeout_s")) run.timeout_s = v->number(0.01, 1e7);
  if (const auto v = fields.find("memory_mib")) {
    run.memory_mib = static_cast<std::uint64_t>(v->integer(16, 1 << 24));
  }
  if (const auto v = fields.find("judge_timeout_s")) run.judge_timeout_s = v->number(0.01, 1e7);
  if (const auto v = fields.find("judge_memory_mib")) {
    run.judge_memory_mib = static_cast<std::uint64_t>(v->integer(1, 1 << 24));
  }
  return run;
}

std::vector<AcceptBound> read_accept(const YamlValue& value) {
  std::vector<AcceptBound> bounds;
  for (const auto& [name, entry] : value.entries()) bounds.push_back(read_bound(name, entry));
  return bounds;
}

void read_measures(const YamlValue& value, std::vector<std::string>& measures) {
  for (const YamlValue& item : value.items()) {
    const std::string name = item.text();
    known_measure(item, name, false);
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

}  // namespace

const char* stop_name(StopKind kind) {
  switch (kind) {
    case StopKind::kFusions:
      return "fusions";
    case StopKind::kTets:
      return "tets";
    case StopKind::kRatio:
      return "ratio";
    case StopKind::kLimit:
      return "limit";
    case StopKind::kTetsOf:
      return "tets_of";
  }
  throw ContractError("stop_name: unknown kind");
}

nlohmann::json stop_request(const Stop& stop) {
  require(stop.kind != StopKind::kTetsOf, "stop_request: tets_of is not resolved");
  if (stop.kind == StopKind::kLimit) return {{"limit", true}};
  if (stop.kind == StopKind::kRatio) return {{"ratio", stop.value}};
  return {{stop_name(stop.kind), static_cast<std::int64_t>(stop.value)}};
}

StopKind SweepAxis::stop_kind() const {
  if (name == "fusions") return StopKind::kFusions;
  return name == "tets" ? StopKind::kTets : StopKind::kRatio;
}

std::vector<std::string> subject_names(const Plan& plan) {
  std::vector<std::string> names;
  for (const PlanMesh& mesh : plan.meshes) names.push_back(mesh.name);
  for (const PlanScene& scene : plan.scenes) names.push_back(scene.name);
  for (const PlanKnownCase& known : plan.known_cases) names.push_back(known.name);
  return names;
}

namespace {

/// Refuses keys that belong to other contests alone.
void refuse_keys_of_others(const YamlFields& fields, const std::string& contest) {
  struct Owned {
    const char* key;
    std::vector<std::string> contests;
  };
  static const std::vector<Owned> all_owned{
      {"meshes", {"simplify", "stability"}},
      {"region", {"simplify"}},
      {"equal_count", {"simplify"}},
      {"claim", {"simplify"}},
      {"comparisons", {"simplify"}},
      {"scenes", {"deform", "motion", "engine"}},
      {"reference", {"deform", "motion", "engine"}},
      {"simplify", {"deform", "stability"}},
      {"scene_sets", {"deform"}},
      {"targets", {"deform"}},
      {"cases", {"verify"}},
      {"extremes", {"stability"}},
  };
  for (const auto& [key, contests] : all_owned) {
    const auto extra = fields.find(key);
    if (!extra || std::find(contests.begin(), contests.end(), contest) != contests.end()) continue;
    extra->fail("\"" + std::string(key) + "\" belongs to the contest " + contests.front() + ", not to " +
                contest);
  }
}

/// What a contest of simplifiers is about.
void read_simplify_parts(const YamlFields& fields, Plan& plan, const Registry& registry) {
  plan.meshes = read_meshes(fields.need("meshes"), plan.file.parent_path());
  if (const auto sweep = fields.find("sweep"))
    plan.sweep = read_sweep(*sweep, {"tets_removed_ratio", "fusions", "tets"});
  plan.contestants = read_contestants(fields.need("contestants"), "simplify", plan.sweep, registry);
  if (const auto region = fields.find("region")) plan.region = read_keep(*region);
  if (const auto equal_count = fields.find("equal_count")) plan.equal_count = equal_count->number(1e-6, 0.1);
}

/// What a contest of displacements is about.
void read_deform_parts(const YamlFields& fields, Plan& plan, const Registry& registry) {
  plan.scenes = read_plan_scenes(fields.need("scenes"), plan.file.parent_path(), plan.contest);
  if (const auto sweep = fields.find("sweep"))
    plan.sweep = read_sweep(*sweep, {"poisson_ratio", "vertices", "tets_removed_ratio"});
  read_simplifiers(fields, plan, registry);
  std::vector<SweepAxis> own;  // the ratio is the simplifiers'
  for (const SweepAxis& axis : plan.sweep) {
    if (!axis.is_stop()) own.push_back(axis);
  }
  plan.contestants = read_contestants(fields.need("contestants"), "deform", own, registry);
  check_reserved_labels(fields.need("contestants"), plan);
  plan.reference = read_reference(fields.need("reference"), plan.contest, registry);
  check_vertices_sweep(fields, plan);
  check_targets(fields, plan);
}

/// What a contest of motions is about.
void read_motion_parts(const YamlFields& fields, Plan& plan, const Registry& registry) {
  plan.scenes = read_plan_scenes(fields.need("scenes"), plan.file.parent_path(), plan.contest);
  if (const auto sweep = fields.find("sweep")) plan.sweep = read_sweep(*sweep, {"poisson_ratio", "vertices"});
  plan.contestants = read_contestants(fields.need("contestants"), "motion", plan.sweep, registry);
  check_reserved_labels(fields.need("contestants"), plan);
  plan.reference = read_reference(fields.need("reference"), plan.contest, registry);
  check_vertices_sweep(fields, plan);
}

/// What a contest with known answers is about.
void read_verify_parts(const YamlFields& fields, Plan& plan, const Registry& registry) {
  if (const auto sweep = fields.find("sweep"))
    sweep->fail("the contest verify sweeps the cells of its cases");
  if (const auto accept = fields.find("accept"))
    accept->fail("the contest verify has its bounds in \"expect\"");
  plan.contestants = read_contestants(fields.need("contestants"), "deform", {}, registry);
  plan.known_cases = read_known_cases(fields.need("cases"), plan.contestants);
}

/// What a contest of the engine is about.
void read_engine_parts(const YamlFields& fields, Plan& plan, const Registry& registry) {
  plan.scenes = read_dynamic_scenes(fields.need("scenes"), plan.file.parent_path());
  if (const auto sweep = fields.find("sweep")) plan.sweep = read_sweep(*sweep, {});
  plan.contestants = read_contestants(fields.need("contestants"), "engine", plan.sweep, registry);
  check_scenes_of_contestants(fields.need("contestants"), plan);
  if (const auto reference = fields.find("reference"))
    plan.reference = read_reference(*reference, "deform", registry);
}

/// What a contest of extremes is about.
void read_stability_parts(const YamlFields& fields, Plan& plan, const Registry& registry) {
  if (const auto sweep = fields.find("sweep")) sweep->fail("the contest stability sweeps in its extremes");
  plan.meshes = read_meshes(fields.need("meshes"), plan.file.parent_path());
  if (const auto simplify = fields.find("simplify"))
    plan.simplifiers = read_contestants(*simplify, "simplify", {}, registry);
  plan.contestants = read_contestants(fields.need("contestants"), "stability", {}, registry);
  plan.extremes = read_extremes(fields.need("extremes"), plan, registry);
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

}  // namespace

Plan read_plan(const std::filesystem::path& path, const Registry& registry) {
  const YamlValue root = read_yaml(path);
  const YamlFields fields =
      root.fields({"schema",   "question",    "contest",     "meshes", "scenes",     "cases",   "reference",
                   "simplify", "contestants", "sweep",       "region", "run",        "measure", "accept",
                   "claim",    "equal_count", "comparisons", "charts", "scene_sets", "targets", "extremes"});
  const YamlValue schema = fields.need("schema");
  if (schema.text() != "palpate/plan/1") schema.fail_expected("palpate/plan/1");
  Plan plan;
  plan.file = path;
  plan.name = plan_name(path);
  plan.question = fields.need("question").text();
  if (plan.question.empty()) fields.need("question").fail_expected("a question");
  const YamlValue contest = fields.need("contest");
  plan.contest = contest.text();
  refuse_keys_of_others(fields, plan.contest);
  if (plan.contest == "simplify") {
    read_simplify_parts(fields, plan, registry);
  } else if (plan.contest == "deform") {
    read_deform_parts(fields, plan, registry);
  } else if (plan.contest == "motion") {
    read_motion_parts(fields, plan, registry);
  } else if (plan.contest == "verify") {
    read_verify_parts(fields, plan, registry);
  } else if (plan.contest == "engine") {
    read_engine_parts(fields, plan, registry);
  } else if (plan.contest == "stability") {
    read_stability_parts(fields, plan, registry);
  } else {
    contest.fail_expected("simplify, deform, motion, verify, engine or stability");
  }
  if (const auto run = fields.find("run")) plan.run = read_run(*run);
  if (const auto measure = fields.find("measure")) read_measures(*measure, plan.measure);
  if (const auto accept = fields.find("accept")) plan.accept = read_accept(*accept);
  if (const auto claim = fields.find("claim")) plan.claim = read_claim(*claim, plan.contestants);
  if (const auto comparisons = fields.find("comparisons")) {
    plan.comparisons = read_comparisons(*comparisons, plan.contestants, plan.run);
  }
  if (const auto charts = fields.find("charts")) plan.charts = read_charts(*charts, plan.contest);
  add_availability_notes(plan, registry);
  if (std::string note = timing_note(plan); !note.empty()) plan.notes.push_back(std::move(note));
  return plan;
}

}  // namespace palpate::experiments

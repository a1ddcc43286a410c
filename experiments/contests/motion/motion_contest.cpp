#include "experiments/contests/motion/motion_contest.h"

#include <map>

#include "core/base/error.h"
#include "experiments/contests/motion/motion_input.h"
#include "experiments/contests/motion/plan_motion.h"
#include "experiments/contests/simplified_mesh.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

json scene_facts(const MotionInput& input) {
  const Material& material = input.problem.body.material;
  const auto window = judging_window(input.problem);
  return {{"name", input.scene},
          {"problem_hash", input.files.problem_hash},
          {"strain", "small"},
          {"young_modulus_pa", material.young_modulus_pa},
          {"poisson_ratio", material.poisson_ratio},
          {"duration_s", input.problem.duration_s},
          {"window_s", window}};
}

json describe_motion(const MotionReference& reference) {
  if (!reference.failure.empty()) return nullptr;
  return {{"valid", true},
          {"findings", json::array()},
          {"kind", "motion"},
          {"frequencies_hz", reference.truth.frequencies_hz},
          {"own_error", reference.own_error},
          {"runs", reference.runs}};
}

/// How far a solver leaves a motion from that of its own body.
void compare_with_limit(const MotionInput& input, const OwnLimit& limit, const JudgedMotion& found,
                        json& figures) {
  if (!limit.failure.empty()) {
    figures["solver_limit"] = "none: it " + limit.failure;
    return;
  }
  const json off = compare_motions(input.problem, {found.history, {}}, {limit.history, {}});
  for (const char* name : {"probe_l2", "force_l2"}) {
    if (off.contains(name)) figures[std::string("solver_") + name] = off.at(name);
  }
}

json judge_motion(const MotionInput& input, const MotionReference& reference, const OwnLimit* limit,
                  const json& report, const std::filesystem::path& file) {
  json figures = {{"valid", false}, {"findings", json::array()}};
  const std::string outcome = report.at("outcome").get<std::string>();
  const bool is_unsolved = outcome == "unsolved";
  if (is_unsolved)
    figures["findings"].push_back("its solver did not come to its tolerance in " +
                                  report.value("steps_unsolved", json()).dump() + " of " +
                                  report.value("steps", json()).dump() + " steps");
  if (outcome != "completed" && !is_unsolved) {
    figures["findings"].push_back("its outcome is " + outcome);
    return figures;
  }
  JudgedMotion found;
  found.history = reference::read_history(file, input.problem);
  const json frequencies = report.value("frequencies_hz", json());
  if (!frequencies.is_array() || frequencies.size() != reference.truth.frequencies_hz.size())
    throw InputError(file.string(), 0, std::to_string(kComparedFrequencies) + " frequencies in the report",
                     frequencies.dump().substr(0, 80));
  for (const json& each : frequencies) {
    if (!each.is_number()) throw InputError(file.string(), 0, "frequencies that are numbers", each.dump());
    found.frequencies_hz.push_back(each.get<double>());
  }
  figures.update(compare_motions(input.problem, found, reference.truth));
  if (limit != nullptr) compare_with_limit(input, *limit, found, figures);
  figures["frequencies_hz"] = found.frequencies_hz;
  figures["reference_own_error"] = reference.own_error;
  figures["valid"] = !is_unsolved;
  return figures;
}

class MotionContest : public Contest {
 public:
  explicit MotionContest(const ContestSetting& setting) : setting_(setting) {}

  json prepare(const std::vector<const Case*>& cases, const json& earlier) override {
    json described = earlier.is_null() ? json::object() : earlier.value("problems", json::object());
    for (const Case* c : cases) {
      require_going_on(setting_);
      const std::string id = id_of(*c);
      if (!setting_.plan.contestants[c->contestant].own_limit.empty()) limited_.push_back(*c);
      if (inputs_.count(id) == 0) {
        setting_.progress.show("scene " + id);
        inputs_.emplace(id, build_motion_input(setting_.plan.scenes[c->subject], c->sweep,
                                               setting_.folder.paths().problem(id)));
        order_.push_back(id);
        describe(id, described);
      }
      if (!is_simplified(setting_.plan, *c)) continue;
      const std::string simplified = simplified_id(setting_.plan, *c, id);
      if (simplified_.count(simplified) > 0) continue;
      setting_.progress.show("simplified scene " + simplified);
      simplified_.emplace(simplified, simplify_motion_input(inputs_.at(id), *c, simplified, setting_));
    }
    return {{"problems", described}};
  }

  bool record_inputs(const std::set<std::string>& recorded,
                     const std::function<void(json)>& append) override {
    for (const std::string& id : order_) {
      setting_.progress.show("reference of " + id);
      MotionReference reference = solve_motion_reference(inputs_.at(id), setting_);
      if (reference.interrupted) return false;
      json record = build_reference_record(inputs_.at(id), reference);
      if (recorded.count(record.at("case").get<std::string>()) == 0) append(std::move(record));
      references_.emplace(id, std::move(reference));
    }
    for (const Case& each : limited_) {
      setting_.progress.show("own limit of " + each.id);
      const MotionInput& input = input_of(each);
      OwnLimit limit;
      limit.failure = input.failure;
      if (limit.failure.empty()) limit = solve_own_limit(input, each, setting_);
      if (limit.interrupted) return false;
      limits_.emplace(each.id, std::move(limit));
    }
    return true;
  }

  std::string fill_task(const Case& run_case, ContestantTask& task) const override {
    const MotionReference& reference = references_.at(id_of(run_case));
    if (!reference.failure.empty()) return "there is nothing to judge it by: " + reference.failure;
    const MotionInput& input = input_of(run_case);
    if (!input.failure.empty()) return input.failure;
    task.mesh_in = input.files.mesh_file;
    task.problem_in = input.files.problem_file;
    return "";
  }

  json build_record(const RepeatFacts& facts, const ContestantAnswer& answer,
                    const std::vector<json>& earlier) const override {
    const MotionInput& whole = inputs_.at(id_of(facts.run_case));
    const MotionInput& input = input_of(facts.run_case);
    const MotionReference& reference = references_.at(whole.id);
    const auto limit = limits_.find(facts.run_case.id);
    const auto judge = [&](const std::filesystem::path& file) {
      return judge_motion(input, reference, limit == limits_.end() ? nullptr : &limit->second, answer.report,
                          file);
    };
    json record =
        start_record(facts, mesh_facts(whole.scene, whole.files.mesh, whole.files.mesh_hash), answer);
    record["scene"] = scene_facts(whole);
    if (&input != &whole && input.failure.empty()) {
      record["solved_on"] = mesh_facts(input.id, input.files.mesh, input.files.mesh_hash);
      if (input.simplify_s) record["solved_on"]["simplify_s"] = *input.simplify_s;
    }
    judge_answer({judge, [](json&) {}, "history"}, facts, answer, earlier, record);
    return record;
  }

  std::filesystem::path kept_output(const Case& run_case) const override {
    return setting_.folder.paths().history(run_case.id);
  }

 private:
  std::string id_of(const Case& run_case) const {
    return problem_id(setting_.plan.scenes[run_case.subject].name, run_case.sweep);
  }

  /// On the case's own mesh, simplified or not.
  const MotionInput& input_of(const Case& run_case) const {
    if (!is_simplified(setting_.plan, run_case)) return inputs_.at(id_of(run_case));
    return simplified_.at(simplified_id(setting_.plan, run_case, id_of(run_case)));
  }

  void describe(const std::string& id, json& described) const {
    describe_problem(setting_.folder.paths(), id, inputs_.at(id).files, described);
  }

  json build_reference_record(const MotionInput& input, const MotionReference& reference) const {
    json record = start_reference_record(setting_.plan,
                                         mesh_facts(input.scene, input.files.mesh, input.files.mesh_hash),
                                         input.scene, input.sweep, reference.outcome, reference.failure);
    record["scene"] = scene_facts(input);
    record["judge"] = describe_motion(reference);
    if (reference.failure.empty())
      record["mesh_file"] =
          reference.history_file.lexically_relative(setting_.folder.paths().folder).string();
    for (const char* key : {"kernel_s", "wall_s", "user_s", "peak_rss_bytes"})
      record["null_reasons"][key] = "several runs: see judge.runs";
    return record;
  }

  ContestSetting setting_;
  std::vector<std::string> order_;
  std::map<std::string, MotionInput> inputs_;
  std::map<std::string, MotionInput> simplified_;
  std::map<std::string, MotionReference> references_;
  std::vector<Case> limited_;               ///< cases that are held against their own limit
  std::map<std::string, OwnLimit> limits_;  ///< by case
};

}  // namespace

const ContestKind& motion_contest() {
  static const ContestKind kind{"motion",
                                {"scenes", "reference", "simplify", "charts"},
                                {"scenes", "reference"},
                                {},
                                {"motion_errors", "motion_histories"},
                                read_motion_plan,
                                cross_cases,
                                [](const ContestSetting& setting) -> std::unique_ptr<Contest> {
                                  return std::make_unique<MotionContest>(setting);
                                }};
  return kind;
}

}  // namespace palpate::experiments

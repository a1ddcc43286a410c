#include "experiments/contests/engine/engine_contest.h"

#include <map>

#include "core/mesh/geometry.h"
#include "experiments/contests/engine/engine_judge.h"
#include "experiments/contests/engine/plan_engine.h"
#include "experiments/contests/pad_force.h"
#include "experiments/contests/problem_files.h"
#include "experiments/scene_reader/scene_motion.h"
#include "experiments/scene_reader/scene_problem.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// A scene on one mesh.
struct EngineInput {
  std::string id;  ///< "kidney_hold/vertices=1503"
  std::string scene;
  Scene placed;
  reference::MovingBody body;
  ProblemFiles files;
};

/// The points that the tools push, as probes after the scene's own.
void add_tool_probes(EngineInput& input) {
  for (const SceneLoad& load : input.placed.loads) {
    if (load.kind == SceneLoad::Kind::kDisplace && load.region.kind == Region::Kind::kSphere)
      input.body.motion.probes.push_back(nearest_point(input.files.mesh.points, load.region.center));
  }
}

class EngineContest : public Contest {
 public:
  explicit EngineContest(const ContestSetting& setting) : setting_(setting) {}

  json prepare(const std::vector<const Case*>& cases, const json& earlier) override {
    json described = earlier.is_null() ? json::object() : earlier.value("problems", json::object());
    for (const Case* c : cases) {
      require_going_on(setting_);
      const std::string id = id_of(*c);
      if (inputs_.count(id) == 0) {
        setting_.progress.show("scene " + id);
        inputs_.emplace(id, build_input(*c, id));
        describe_problem(setting_.folder.paths(), id, inputs_.at(id).files, described);
      }
      if (needs_force(*c)) forces_.emplace(id, PadForce{});
    }
    return {{"problems", described}};
  }

  bool record_inputs(const std::set<std::string>& recorded,
                     const std::function<void(json)>& append) override {
    for (auto& [id, force] : forces_) {
      setting_.progress.show("force of the reference on " + id);
      const EngineInput& input = inputs_.at(id);
      force = solve_pad_force(input.placed, input.files.mesh,
                              setting_.folder.paths().problem(id + "/reference"), setting_);
      if (force.interrupted) return false;
      json record = build_force_record(input, force);
      if (recorded.count(record.at("case").get<std::string>()) == 0) append(std::move(record));
    }
    return true;
  }

  std::string fill_task(const Case& run_case, ContestantTask& task) const override {
    const ProblemFiles& files = inputs_.at(id_of(run_case)).files;
    task.mesh_in = files.mesh_file;
    task.problem_in = files.problem_file;
    return "";
  }

  json build_record(const RepeatFacts& facts, const ContestantAnswer& answer,
                    const std::vector<json>& earlier) const override {
    const EngineInput& input = inputs_.at(id_of(facts.run_case));
    json record =
        start_record(facts, mesh_facts(input.scene, input.files.mesh, input.files.mesh_hash), answer);
    record["scene"] = scene_facts(input);
    const auto judge = [&](const std::filesystem::path& file) {
      json figures = judge_engine_file(input.body.motion, input.files.mesh, answer.report, file);
      const auto force = forces_.find(input.id);
      if (force != forces_.end() && force->second.failure.empty())
        compare_force({force->second.force_n, force->second.change}, figures);
      return figures;
    };
    judge_answer({judge, [](json&) {}, "motion"}, facts, answer, earlier, record);
    if (record.at("judge").is_object()) record["reported"] = reported_figures(answer.report);
    return record;
  }

  std::filesystem::path kept_output(const Case& run_case) const override {
    return setting_.folder.paths().motion(run_case.id);
  }

 private:
  static std::uint64_t vertices_of(const Case& run_case) {
    return run_case.options.value("vertices", std::uint64_t{0});
  }

  std::string id_of(const Case& run_case) const {
    const std::string& scene = setting_.plan.scenes[run_case.subject].name;
    const std::uint64_t vertices = vertices_of(run_case);
    return vertices == 0 ? scene : scene + "/vertices=" + std::to_string(vertices);
  }

  bool needs_force(const Case& run_case) const {
    // Whoever answers them: "engine.ticks", "reduced.modal_ticks".
    return setting_.plan.reference &&
           setting_.plan.contestants[run_case.contestant].method.ends_with("ticks");
  }

  EngineInput build_input(const Case& run_case, const std::string& id) const {
    const PlanScene& scene = setting_.plan.scenes[run_case.subject];
    EngineInput input{id, scene.name, {}, {}, {}};
    std::optional<std::uint64_t> vertices;
    if (vertices_of(run_case) > 0) vertices = vertices_of(run_case);
    input.files.mesh = build_scene_mesh(scene.scene.mesh, vertices).mesh;
    input.placed = place_scene(scene.scene, input.files.mesh);
    input.body = build_moving_body(input.placed, input.files.mesh, setting_.registry);
    add_tool_probes(input);
    write_problem(input.files, reference::moving_body_to_json(input.body),
                  setting_.folder.paths().problem(id));
    return input;
  }

  static json scene_facts(const EngineInput& input) {
    const Material& material = input.placed.material;
    return {{"name", input.scene},
            {"problem_hash", input.files.problem_hash},
            {"strain", input.placed.strain == StrainSize::kSmall ? "small" : "large"},
            {"young_modulus_pa", material.young_modulus_pa},
            {"poisson_ratio", material.poisson_ratio}};
  }

  json build_force_record(const EngineInput& input, const PadForce& force) const {
    json record =
        start_input_record(setting_.plan, mesh_facts(input.scene, input.files.mesh, input.files.mesh_hash),
                           input.id + "/reference", "reference");
    record["scene"] = scene_facts(input);
    record["outcome"] = force.outcome;
    record["message"] = force.failure;
    record["judge"] = nullptr;
    if (!force.levels.empty() && (force.failure.empty() || !force.faults.empty())) {
      record["judge"] = {{"kind", "pad_force"},
                         {"valid", force.faults.empty()},
                         {"findings", force.faults},
                         {"level_reports", force.levels}};
      record["judge"]["force_n"] = {force.force_n.x, force.force_n.y, force.force_n.z};
      record["judge"]["force_change"] = force.change ? json(*force.change) : json();
    }
    for (const char* key : {"kernel_s", "wall_s", "user_s", "peak_rss_bytes"})
      record["null_reasons"][key] = "several runs: see judge.level_reports";
    return record;
  }

  ContestSetting setting_;
  std::map<std::string, EngineInput> inputs_;
  std::map<std::string, PadForce> forces_;
};

}  // namespace

const ContestKind& engine_contest() {
  static const ContestKind kind{"engine",
                                {"scenes", "reference"},
                                {"scenes"},
                                {},
                                {},
                                read_engine_plan,
                                cross_cases,
                                [](const ContestSetting& setting) -> std::unique_ptr<Contest> {
                                  return std::make_unique<EngineContest>(setting);
                                }};
  return kind;
}

}  // namespace palpate::experiments

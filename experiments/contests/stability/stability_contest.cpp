#include "experiments/contests/stability/stability_contest.h"

#include <filesystem>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/medit.h"
#include "experiments/contests/problem_files.h"
#include "experiments/contests/run_mesh.h"
#include "experiments/contests/stability/plan_stability.h"
#include "experiments/contests/stability/stability_input.h"
#include "experiments/contests/stability/stability_judge.h"
#include "experiments/files/file_hash.h"
#include "reference/door/stability_problem.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr double kShortTimeout = 300.0;

class StabilityContest : public Contest {
 public:
  explicit StabilityContest(const ContestSetting& setting) : setting_(setting) {}

  json prepare(const std::vector<const Case*>& cases, const json& earlier) override {
    json described = json::array();
    for (const PlanMesh& mesh : setting_.plan.meshes) {
      const auto file = setting_.folder.paths().mesh(mesh.name + "/input");
      if (!earlier.is_null()) {
        meshes_.push_back(reload_mesh(mesh, file, earlier));
        continue;
      }
      setting_.progress.show("mesh " + mesh.name);
      meshes_.push_back(obtain_mesh(mesh, file));
      described.push_back(describe_mesh(meshes_.back()));
    }
    for (const Case* c : cases) {
      require_going_on(setting_);
      if (c->simplifier && simplified_.count(simplified_id(*c)) == 0) simplify(*c);
    }
    return earlier.is_null() ? json{{"meshes", described}} : json::object();
  }

  bool record_inputs(const std::set<std::string>&, const std::function<void(json)>&) override {
    return true;  // any mesh will do
  }

  std::string fill_task(const Case& run_case, ContestantTask& task) const override {
    if (run_case.simplifier) {
      const Simplified& simplified = simplified_.at(simplified_id(run_case));
      if (!simplified.failure.empty()) return simplified.failure;
    }
    ProblemFiles files;
    try {
      StabilityInput input = build_stability_input(mesh_of(run_case).mesh, run_case.options);
      files.mesh = std::move(input.mesh);
      write_problem(files, reference::stability_to_json(input.problem),
                    setting_.folder.paths().problem(run_case.id));
    } catch (const InputError& error) {
      return error.what();
    }
    task.mesh_in = files.mesh_file;
    task.problem_in = files.problem_file;
    task.options = own_options(run_case.options);
    return "";
  }

  json build_record(const RepeatFacts& facts, const ContestantAnswer& answer,
                    const std::vector<json>& earlier) const override {
    const RunMesh& mesh = mesh_of(facts.run_case);
    json record = start_record(facts, mesh_facts(mesh.name, mesh.mesh, mesh.hash), answer);
    if (answer.outcome == "timed_out") {
      // The process was ended from outside: how the body ends is not known, which is nothing to accept.
      record["judge"] = {{"valid", false},
                         {"findings", {"it was too slow: how it ends is not known"}},
                         {"ending", "too_slow"}};
      record["null_reasons"] = {{"report", "timed out"}, {"kernel_s", "timed out"}};
      return record;
    }
    if (answer.outcome == "ok") record["reported"] = pick_reported(answer.report);
    const auto judge = [&](const fs::path& file) {
      const StabilityInput input = build_stability_input(mesh.mesh, facts.run_case.options);
      return judge_stability(input, facts.run_case.options, answer.report, file);
    };
    judge_answer({judge, add_agreement_violations, "answer"}, facts, answer, earlier, record);
    return record;
  }

  fs::path kept_output(const Case& run_case) const override {
    return setting_.folder.paths().motion(run_case.id);
  }

 private:
  struct Simplified {
    RunMesh mesh;
    std::string failure;
  };

  std::string simplified_id(const Case& run_case) const {
    return setting_.plan.meshes[run_case.subject].name +
           "/simplify=" + setting_.plan.simplifiers[*run_case.simplifier].label;
  }

  const RunMesh& mesh_of(const Case& run_case) const {
    if (run_case.simplifier) {
      const Simplified& simplified = simplified_.at(simplified_id(run_case));
      if (simplified.failure.empty()) return simplified.mesh;
    }
    return meshes_[run_case.subject];
  }

  /// Runs the simplifier on a mesh, as it is asked for: its output is not judged.
  void simplify(const Case& run_case) {
    const PlanContestant& simplifier = setting_.plan.simplifiers[*run_case.simplifier];
    const std::string id = simplified_id(run_case);
    setting_.progress.show("mesh " + id);
    ContestantTask task =
        start_task(simplifier.method, fs::absolute(meshes_[run_case.subject].file), setting_);
    task.stop = run_case.simplifier_stop;
    task.options = resolve_options(*task.method.method, simplifier.set);
    task.timeout_s = kShortTimeout;
    const ContestantAnswer answer = run_contestant(task);
    Simplified& out = simplified_[id];
    if (answer.outcome != "ok") {
      out.failure = simplifier.label + " left no mesh: " + answer.outcome + ": " + answer.message;
      return;
    }
    out.mesh.name = id;
    out.mesh.file = setting_.folder.paths().mesh(id);
    // Turned tets are turned back, and the mesh overlaps itself: what a mesh without checks is worth.
    out.mesh.mesh = read_medit(answer.output).mesh;
    fs::create_directories(out.mesh.file.parent_path());
    write_medit(out.mesh.file, out.mesh.mesh);
    out.mesh.hash = hash_file(out.mesh.file);
    out.mesh.ideal_volume = total_volume(out.mesh.mesh) / static_cast<double>(out.mesh.mesh.tets.size());
  }

  ContestSetting setting_;
  std::vector<RunMesh> meshes_;
  std::map<std::string, Simplified> simplified_;
};

}  // namespace

const ContestKind& stability_contest() {
  static const ContestKind kind{"stability",
                                {"meshes", "simplify", "extremes"},
                                {"meshes", "extremes"},
                                {{"sweep", "the contest stability sweeps in its extremes"}},
                                {},
                                read_stability_plan,
                                build_stability_cases,
                                [](const ContestSetting& setting) -> std::unique_ptr<Contest> {
                                  return std::make_unique<StabilityContest>(setting);
                                }};
  return kind;
}

}  // namespace palpate::experiments

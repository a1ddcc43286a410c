#include "experiments/contests/stability/stability_contest.h"

#include <cmath>
#include <filesystem>
#include <map>

#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/medit.h"
#include "experiments/contests/run_mesh.h"
#include "experiments/contests/stability/plan_stability.h"
#include "experiments/files/file_hash.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr double kAgreement = 0.02;
constexpr double kSimplifierTimeout = 300.0;
constexpr const char* kEndings[] = {"steady",   "oscillating", "energy_growing", "diverged",
                                    "inverted", "non_finite",  "too_slow",       "growing_slowly"};

bool is_ending(const json& outcome) {
  for (const char* ending : kEndings) {
    if (outcome == ending) return true;
  }
  return false;
}

/// Findings of what is in a report, from what has to be there.
json judge_report(const json& report) {
  json figures{{"valid", true}, {"findings", json::array()}, {"ending", report.value("outcome", json())}};
  json& findings = figures["findings"];
  if (!is_ending(figures.at("ending"))) findings.push_back("its outcome is none of the eight");
  const json runs = report.value("runs", json::array());
  if (!runs.is_array() || runs.empty()) findings.push_back("it reports no run");
  for (const json& run : runs) {
    if (!is_ending(run.value("outcome", json()))) findings.push_back("a run's outcome is none of the eight");
    if (run.value("outcome", json()) == "too_slow")
      findings.push_back("a run was given up after " + run.value("steps", json()).dump() +
                         " steps for want of time: how it ends is not known");
  }
  const json ratio = report.value("measured_over_predicted", json());
  if (ratio.is_number()) figures["measured_over_predicted"] = ratio;
  const json rows = report.value("row_sum_step_s", json());
  const json measured = report.value("measured_step_s", json());
  if (rows.is_number() && measured.is_number())
    figures["row_sum_over_measured"] = rows.get<double>() / measured.get<double>();
  figures["valid"] = findings.empty();
  return figures;
}

/// Of small motions the measured step has to be the predicted one, and row sums no longer than it.
void add_agreement_violations(json& record) {
  if (record.at("options").value("regime", "") != "small") return;
  const json& judge = record.at("judge");
  const json ratio = judge.value("measured_over_predicted", json());
  // Where the prediction is no more than a safe one, the measured step may be longer.
  const bool is_exact = record.at("report").value("predicted_is_exact", true);
  const double off = ratio.is_number() ? ratio.get<double>() - 1.0 : 0.0;
  if (off < -kAgreement || (is_exact && off > kAgreement))
    record["violations"].push_back("the measured step is " + short_number(ratio.get<double>()) +
                                   " of the predicted one, within 2% is accepted");
  const json rows = judge.value("row_sum_over_measured", json());
  if (rows.is_number() && rows.get<double>() > 1.0 + kAgreement)
    record["violations"].push_back("the row sums' step is " + short_number(rows.get<double>()) +
                                   " of the measured one");
}

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
    task.mesh_in = fs::absolute(mesh_of(run_case).file);
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
    const auto judge = [&](const fs::path&) { return judge_report(answer.report); };
    judge_answer({judge, add_agreement_violations, "report"}, facts, answer, earlier, record);
    if (record.at("judge").is_object()) record["null_reasons"]["output_hash"] = "the report is all there is";
    return record;
  }

  fs::path kept_output(const Case& run_case) const override {
    return setting_.folder.paths().mesh(run_case.id);
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
    task.timeout_s = kSimplifierTimeout;
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

#include "experiments/contests/simplify/simplify_contest.h"

#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "experiments/contests/run_mesh.h"
#include "experiments/contests/simplify/plan_simplify.h"
#include "experiments/judging/judge_record.h"
#include "experiments/judging/kept_regions.h"
#include "experiments/meshes/mesh_source.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// Notes a reported count that is not what was counted. A count that is not reported, or null, says nothing.
void hold_count(const char* reported, const json& seen, const std::string& who, json& record) {
  constexpr std::size_t kShown = 60;
  const json said = record.at("report").value(reported, json());
  if (said.is_null() || !seen.is_number() || (said.is_number() && said == seen)) return;
  std::string shown = said.dump(-1, ' ', true, json::error_handler_t::replace);
  if (shown.size() > kShown) shown = shown.substr(0, kShown) + "...";
  record["violations"].push_back(std::string("reports ") + reported + " " + shown + ", " + who + " " +
                                 seen.dump());
}

/// What the adapter reports of the meshes has to be what they have.
void add_report_violations(json& record) {
  const json judged = record.at("judge");
  const json input = record.at("mesh");
  hold_count("tets_out", judged.value("tets", json()), "the judge counts", record);
  hold_count("vertices_out", judged.value("vertices", json()), "the judge counts", record);
  hold_count("tets_in", input.value("tets", json()), "the input has", record);
  hold_count("vertices_in", input.value("vertices", json()), "the input has", record);
}

/// Whether the plan shows, bounds or compares a measure of linear elements.
bool asks_for_linear_elements(const Plan& plan) {
  const auto asks = [](const auto& names) {
    return std::any_of(names.begin(), names.end(), is_of_linear_elements);
  };
  const SimplifyPart& part = part_of<SimplifyPart>(plan);
  return asks(plan.measure) || asks(plan.compared) ||
         (part.claim && is_of_linear_elements(part.claim->measure)) ||
         std::any_of(plan.accept.begin(), plan.accept.end(),
                     [](const AcceptBound& bound) { return is_of_linear_elements(bound.measure); });
}

class SimplifyContest : public Contest {
 public:
  explicit SimplifyContest(const ContestSetting& setting) : setting_(setting) {}

  json prepare(const std::vector<const Case*>&, const json& earlier) override {
    json described = prepare_meshes(setting_, earlier, meshes_);
    check_kept_regions();
    return described;
  }

  bool record_inputs(const std::set<std::string>& recorded,
                     const std::function<void(json)>& append) override {
    for (const RunMesh& mesh : meshes_) {
      if (recorded.count(mesh.name + "/input") > 0) continue;
      json record = build_input_record(mesh);
      if (record.at("outcome") == "interrupted") return false;
      append(std::move(record));
    }
    return true;
  }

  std::string fill_task(const Case& run_case, ContestantTask& task) const override {
    task.mesh_in = std::filesystem::absolute(mesh_of(run_case).file);
    return "";
  }

  json build_record(const RepeatFacts& facts, const ContestantAnswer& answer,
                    const std::vector<json>& earlier) const override {
    const RunMesh& mesh = mesh_of(facts.run_case);
    const auto judge = [&](const std::filesystem::path& file) {
      const TetMesh output = read_mesh(file, ReadOrientation::kKeep).mesh;
      Judgement judgement = judge_output(output, mesh.mesh, facts.contestant.keep);
      const SimplifyPart& part = part_of<SimplifyPart>(facts.plan);
      add_region_figures(judgement.figures, output, mesh.mesh, part.region);
      if (part.feature_deg) add_feature_figures(judgement.figures, output, mesh.mesh, *part.feature_deg);
      if (asks_for_linear_elements(facts.plan)) add_linear_element_figures(judgement.figures, output);
      return judgement.figures;
    };
    json record = start_record(facts, mesh_facts(mesh.name, mesh.mesh, mesh.hash), answer);
    judge_answer({judge, add_report_violations, "mesh"}, facts, answer, earlier, record);
    return record;
  }

  std::filesystem::path kept_output(const Case& run_case) const override {
    return setting_.folder.paths().mesh(run_case.id);
  }

 private:
  /// Throws: InputError for a region that a contestant is to keep and that meets none of the plan's meshes.
  void check_kept_regions() const {
    for (const PlanContestant& contestant : setting_.plan.contestants) {
      for (std::size_t k = 0; k < contestant.keep.size(); ++k) {
        const bool meets = std::any_of(meshes_.begin(), meshes_.end(), [&](const RunMesh& mesh) {
          return meets_region(contestant.keep[k], mesh.mesh);
        });
        if (!meets)
          throw InputError(contestant.keep_where + ": keep", 0,
                           "a region in the meshes' own coordinates that meets one of them",
                           "\"" + contestant.keep[k] + "\", which no tetrahedron meets");
      }
    }
  }

  const RunMesh& mesh_of(const Case& run_case) const { return meshes_[run_case.subject]; }

  json build_input_record(const RunMesh& mesh) const {
    json record = start_input_record(setting_.plan, mesh_facts(mesh.name, mesh.mesh, mesh.hash),
                                     mesh.name + "/input", "input");
    const auto judge = [&] {
      Judgement judgement = judge_mesh(mesh.mesh);
      add_region_figures(judgement.figures, mesh.mesh, mesh.mesh,
                         part_of<SimplifyPart>(setting_.plan).region);
      if (asks_for_linear_elements(setting_.plan)) add_linear_element_figures(judgement.figures, mesh.mesh);
      return json{{"figures", judgement.figures}, {"violations", judgement.violations}};
    };
    for (const char* key : {"kernel_s", "wall_s", "user_s", "peak_rss_bytes"})
      record["null_reasons"][key] = "the input mesh itself: nothing ran";
    record["mesh_file"] = "meshes/" + mesh.name + "/input.mesh";
    const auto judged = judge_bounded(judge, judge_bounds(setting_.plan, setting_.stop_flag), record);
    if (!judged) {
      for (const char* key : {"judge", "output_hash"}) record["null_reasons"][key] = "not_judged";
      return record;
    }
    record["judge"] = judged->at("figures");
    record["output_hash"] = mesh.hash;
    record["violations"] = judged->at("violations");
    const bool is_valid = record.at("violations").empty();
    record["outcome"] = is_valid ? "accepted" : "rejected";
    if (!is_valid) record["message"] = reason_of(record);
    return record;
  }

  ContestSetting setting_;
  std::vector<RunMesh> meshes_;
};

}  // namespace

const ContestKind& simplify_contest() {
  static const ContestKind kind{
      "simplify",
      {"meshes", "region", "feature_deg", "equal_count", "claim", "comparisons", "charts"},
      {"meshes"},
      {},
      {"histograms", "overview", "timing", "quality_time", "quality_distance", "scaling", "cut_away"},
      read_simplify_plan,
      cross_cases,
      [](const ContestSetting& setting) -> std::unique_ptr<Contest> {
        return std::make_unique<SimplifyContest>(setting);
      }};
  return kind;
}

}  // namespace palpate::experiments

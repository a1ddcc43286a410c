#include "experiments/contests/extra/extra_contest.h"

#include "core/mesh/io/medit.h"
#include "experiments/contests/run_mesh.h"
#include "experiments/plan_reader/plan_contestant.h"
#include "experiments/plan_reader/plan_mesh.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// What the contest alone reads: how many tetrahedra each answer is to have at least.
struct ExtraPart : ContestPart {
  std::int64_t at_least = 1;
};

void read_extra_plan(const YamlFields& fields, Plan& plan, const Registry& registry) {
  plan.meshes = read_meshes(fields.need("meshes"), plan.file.parent_path());
  plan.subjects = names_of(plan.meshes);
  plan.contestants = read_contestants(fields.need("contestants"), "extra", {}, registry);
  auto part = std::make_shared<ExtraPart>();
  if (const auto least = fields.find("at_least")) part->at_least = least->integer(1, 1'000'000);
  plan.part = std::move(part);
}

class ExtraContest : public Contest {
 public:
  explicit ExtraContest(const ContestSetting& setting) : setting_(setting) {}

  json prepare(const std::vector<const Case*>&, const json& earlier) override {
    return prepare_meshes(setting_, earlier, meshes_);
  }

  bool record_inputs(const std::set<std::string>&, const std::function<void(json)>&) override { return true; }

  std::string fill_task(const Case& run_case, ContestantTask& task) const override {
    task.mesh_in = std::filesystem::absolute(meshes_[run_case.subject].file);
    return "";
  }

  json build_record(const RepeatFacts& facts, const ContestantAnswer& answer,
                    const std::vector<json>& earlier) const override {
    const RunMesh& mesh = meshes_[facts.run_case.subject];
    json record = start_record(facts, mesh_facts(mesh.name, mesh.mesh, mesh.hash), answer);
    const auto judge = [&](const std::filesystem::path& file) {
      const auto tets = static_cast<std::int64_t>(read_medit(file).mesh.tets.size());
      json figures = {{"valid", tets >= part_of<ExtraPart>(facts.plan).at_least},
                      {"findings", json::array()},
                      {"tets", tets}};
      if (!figures["valid"]) figures["findings"].push_back("too few tetrahedra");
      return figures;
    };
    judge_answer({judge, [](json&) {}, "mesh"}, facts, answer, earlier, record);
    return record;
  }

  std::filesystem::path kept_output(const Case& run_case) const override {
    return setting_.folder.paths().mesh(run_case.id);
  }

 private:
  ContestSetting setting_;
  std::vector<RunMesh> meshes_;
};

}  // namespace

const ContestKind& extra_contest() {
  static const ContestKind kind{"extra",
                                {"meshes", "at_least"},
                                {"meshes"},
                                {},
                                {},
                                read_extra_plan,
                                cross_cases,
                                [](const ContestSetting& setting) -> std::unique_ptr<Contest> {
                                  return std::make_unique<ExtraContest>(setting);
                                }};
  return kind;
}

}  // namespace palpate::experiments

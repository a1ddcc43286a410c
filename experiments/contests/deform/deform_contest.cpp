#include "experiments/contests/deform/deform_contest.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/error.h"
#include "core/judge/displacement/displacement.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "experiments/contests/deform/deform_input.h"
#include "experiments/contests/deform/plan_deform.h"
#include "experiments/contests/pad_force.h"
#include "experiments/contests/simplified_mesh.h"
#include "experiments/files/output_file.h"
#include "reference/door/deform_problem.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using reference::or_null;

double largest(const std::vector<Vec3>& field) {
  double most = 0.0;
  for (const Vec3& u : field) most = std::max(most, length(u));
  return most;
}

json describe_reference(const DeformInput& input, const DeformReference& reference) {
  const judge::ReferenceEstimate& estimate = reference.estimate;
  if (!reference.failure.empty()) return nullptr;
  json figures = {{"valid", true}, {"findings", json::array()}, {"level_reports", reference.levels}};
  figures["kind"] = judge::reference_kind_name(estimate.kind);
  figures["levels"] = estimate.levels;
  figures["order"] = or_null(estimate.order);
  figures["alignment"] = or_null(estimate.alignment);
  figures["differences"] = estimate.difference;
  figures["rule"] = estimate.rule;
  figures["reference_error"] = or_null(estimate.error.relative_l2);
  figures["reference_error_deformation"] = or_null(estimate.error.relative_deformation);
  figures["reference_error_max"] = or_null(estimate.error.relative_max);
  figures["reference_error_energy"] = or_null(estimate.error.relative_energy);
  figures["reference_error_energy_whole"] = or_null(reference.whole_energy);
  if (input.chosen) {
    figures["reference_error_l2_at"] = or_null(estimate.error.chosen_l2);
    figures["reference_error_deformation_at"] = or_null(estimate.error.chosen_deformation);
    figures["reference_error_max_at"] = or_null(estimate.error.chosen_max);
    figures["points_at"] = input.chosen->vertex.size();
  }
  if (!reference.pad_force_n.empty()) {
    figures["reference_error_pad_force"] = or_null(reference.pad_force_error);
    figures["pad_forces_n"] = json::array();
    for (const Vec3& force : reference.pad_force_n)
      figures["pad_forces_n"].push_back({force.x, force.y, force.z});
  }
  figures["max_displacement_m"] = largest(estimate.field);
  return figures;
}

/// The pads' forces of an answer, against those of the reference; nothing where no pad moves.
void judge_pad_force(const DeformReference& reference, const ProblemFiles& solved_on,
                     std::span<const Vec3> nodes, json& figures) {
  if (reference.pad_force_n.empty()) return;
  std::vector<Vec3> forces;
  for (const ElasticSupport& support : solved_on.problem.supports) {
    if (is_moved(support)) forces.push_back(measure_pad_force(solved_on.mesh, support, nodes));
  }
  const double error = relative_force_error(forces, reference.pad_force_n);
  if (std::isfinite(error)) figures["pad_force"] = error;
}

/// Figures of an answer: errors at the vertices of the scene's own mesh, whatever mesh it was solved on; of
/// the energy between them, too.
json judge_displacement(const DeformInput& input, const DeformReference& reference,
                        const ProblemFiles& solved_on, const json& report,
                        const std::filesystem::path& file) {
  json figures = {{"valid", false}, {"findings", json::array()}};
  const std::string outcome = report.at("outcome").get<std::string>();
  if (outcome != "converged") {
    figures["findings"].push_back("its outcome is " + outcome);
    return figures;
  }
  const std::size_t rows = solved_on.mesh.points.size();
  std::vector<Vec3> nodes = judge::with_midpoints(
      solved_on.mesh, reference::read_displacement(file, rows, build_edges(solved_on.mesh).size()));
  figures["max_displacement_m"] = largest({nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(rows)});
  judge_pad_force(reference, solved_on, nodes, figures);
  const std::size_t vertices = input.own.mesh.points.size();
  if (&solved_on != &input.own) {
    const std::vector<Vec3> points = judge::with_midpoints(input.own.mesh, input.own.mesh.points);
    const std::span<const Vec3> all = points;
    judge::TransferredField moved = judge::transfer_field(solved_on.mesh, nodes, all.first(vertices));
    figures["points_outside"] = moved.outside;
    figures["farthest_outside_m"] = moved.farthest_outside;
    const judge::TransferredField between =
        judge::transfer_field(solved_on.mesh, nodes, all.subspan(vertices));
    nodes = std::move(moved.value);
    nodes.insert(nodes.end(), between.value.begin(), between.value.end());
  }
  const std::span<const Vec3> field(nodes.data(), vertices);
  const Material& material = input.own.problem.material;
  const auto compare = [&](std::span<const Vec3> answer, std::span<const Vec3> truth) {
    return judge::compare_displacement(input.own.mesh, answer, truth, material.lambda_pa(), material.mu_pa());
  };
  const judge::DisplacementError error = compare(field, reference.estimate.field);
  figures["displacement_l2"] = error.relative_l2;
  figures["displacement_deformation"] = error.relative_deformation;
  figures["displacement_max"] = error.relative_max;
  figures["displacement_energy"] = error.relative_energy;
  if (input.chosen) {
    const judge::ChosenError there =
        judge::compare_chosen(input.own.mesh, field, reference.estimate.field, *input.chosen);
    figures["displacement_l2_at"] = there.relative_l2;
    figures["displacement_deformation_at"] = there.relative_deformation;
    figures["displacement_max_at"] = there.relative_max;
  }
  figures["displacement_energy_whole"] = compare(nodes, reference.field).relative_energy;
  figures["rigid_share"] = error.rigid_share;
  figures["worst_vertex"] = error.worst_point;
  const auto& own_error = reference.estimate.error.relative_l2;
  figures["reference_error"] = or_null(own_error);
  figures["reference_ratio"] = own_error && *own_error > 0.0 ? json(error.relative_l2 / *own_error) : json();
  figures["reference_too_coarse"] = judge::is_reference_too_coarse(error.relative_l2, own_error);
  figures["valid"] = true;
  return figures;
}

class DeformContest : public Contest {
 public:
  explicit DeformContest(const ContestSetting& setting) : setting_(setting) {}

  json prepare(const std::vector<const Case*>& cases, const json& earlier) override {
    json described = earlier.is_null() ? json::object() : earlier.value("problems", json::object());
    for (const Case* c : cases) {
      require_going_on(setting_);
      const std::string id = id_of(*c);
      if (inputs_.count(id) == 0) {
        setting_.progress.show("scene " + id);
        inputs_.emplace(id, build_input(setting_.plan.scenes[c->subject], c->sweep, folder_of(id)));
        order_.push_back(id);
        describe_problem(setting_.folder.paths(), id, inputs_.at(id).own, described);
      }
      if (is_simplified(*c) && simplified_.count(simplified_id(*c)) == 0) {
        setting_.progress.show("simplified scene " + simplified_id(*c));
        simplified_.emplace(simplified_id(*c),
                            simplify_input(inputs_.at(id), setting_.plan.simplifiers[*c->simplifier],
                                           c->simplifier_stop, folder_of(simplified_id(*c)), setting_));
      }
    }
    return {{"problems", described}};
  }

  bool record_inputs(const std::set<std::string>& recorded,
                     const std::function<void(json)>& append) override {
    for (const std::string& id : order_) {
      const DeformInput& input = inputs_.at(id);
      setting_.progress.show("reference of " + id);
      DeformReference reference = solve_reference(input, setting_, companions_of(id));
      if (reference.interrupted) return false;
      json record = build_reference_record(input, reference);
      if (reference.failure.empty()) keep_field(id, reference.field);
      if (recorded.count(record.at("case").get<std::string>()) == 0) append(std::move(record));
      references_.emplace(id, std::move(reference));
    }
    return true;
  }

  std::string fill_task(const Case& run_case, ContestantTask& task) const override {
    const DeformReference& reference = references_.at(id_of(run_case));
    if (!reference.failure.empty()) return "there is nothing to judge it by: " + reference.failure;
    if (is_simplified(run_case)) {
      const std::string& failure = simplified_.at(simplified_id(run_case)).failure;
      if (!failure.empty()) return failure;
    }
    const ProblemFiles& files = files_of(run_case);
    task.mesh_in = files.mesh_file;
    task.problem_in = files.problem_file;
    return "";
  }

  json build_record(const RepeatFacts& facts, const ContestantAnswer& answer,
                    const std::vector<json>& earlier) const override {
    const DeformInput& input = inputs_.at(id_of(facts.run_case));
    const DeformReference& reference = references_.at(input.id);
    const auto judge = [&](const std::filesystem::path& file) {
      return judge_displacement(input, reference, files_of(facts.run_case), answer.report, file);
    };
    json record = start_record(facts, mesh_facts(input.scene, input.own.mesh, input.own.mesh_hash), answer);
    record["scene"] = scene_facts(input);
    if (is_simplified(facts.run_case) && simplified_.at(simplified_id(facts.run_case)).failure.empty()) {
      const ProblemFiles& files = files_of(facts.run_case);
      record["solved_on"] = mesh_facts(simplified_id(facts.run_case), files.mesh, files.mesh_hash);
      if (const auto& taken = simplified_.at(simplified_id(facts.run_case)).kernel_s)
        record["solved_on"]["simplify_s"] = *taken;
    }
    judge_answer({judge, [](json&) {}, "displacement"}, facts, answer, earlier, record);
    return record;
  }

  std::filesystem::path kept_output(const Case& run_case) const override {
    return setting_.folder.paths().displacement(run_case.id);
  }

 private:
  static json scene_facts(const DeformInput& input) {
    const Material& material = input.own.problem.material;
    return {{"name", input.scene},
            {"problem_hash", input.own.problem_hash},
            {"strain", input.own.problem.strain == StrainSize::kSmall ? "small" : "large"},
            {"young_modulus_pa", material.young_modulus_pa},
            {"poisson_ratio", material.poisson_ratio}};
  }

  std::string id_of(const Case& run_case) const {
    return problem_id(setting_.plan.scenes[run_case.subject].name, run_case.sweep);
  }

  bool is_simplified(const Case& run_case) const {
    return experiments::is_simplified(setting_.plan, run_case);
  }

  std::string simplified_id(const Case& run_case) const {
    return experiments::simplified_id(setting_.plan, run_case, id_of(run_case));
  }

  const ProblemFiles& files_of(const Case& run_case) const {
    return is_simplified(run_case) ? simplified_.at(simplified_id(run_case)).files
                                   : inputs_.at(id_of(run_case)).own;
  }

  std::filesystem::path folder_of(const std::string& id) const { return setting_.folder.paths().problem(id); }

  /// The problems after this one that differ from it in their loads alone.
  std::vector<const DeformInput*> companions_of(const std::string& id) const {
    const std::string name = stiffness_name(inputs_.at(id).own);
    std::vector<const DeformInput*> found;
    if (name.empty()) return found;
    const auto at = std::find(order_.begin(), order_.end(), id);
    for (auto other = std::next(at); other != order_.end(); ++other) {
      const DeformInput& input = inputs_.at(*other);
      if (stiffness_name(input.own) == name) found.push_back(&input);
    }
    return found;
  }

  /// Keeps the field that answers are judged by with the run: anyone can judge again.
  void keep_field(const std::string& id, std::span<const Vec3> field) const {
    const std::filesystem::path file = setting_.folder.paths().reference(id);
    create_folder(file.parent_path());
    reference::write_displacement(file, field);
  }

  json build_reference_record(const DeformInput& input, const DeformReference& reference) const {
    json record =
        start_reference_record(setting_.plan, mesh_facts(input.scene, input.own.mesh, input.own.mesh_hash),
                               input.scene, input.sweep, reference.outcome, reference.failure);
    record["scene"] = scene_facts(input);
    record["judge"] = describe_reference(input, reference);
    if (reference.failure.empty())
      record["mesh_file"] = std::filesystem::relative(setting_.folder.paths().reference(input.id),
                                                      setting_.folder.paths().folder)
                                .string();
    for (const char* key : {"kernel_s", "wall_s", "user_s", "peak_rss_bytes"})
      record["null_reasons"][key] = "several runs: see judge.level_reports";
    return record;
  }

  ContestSetting setting_;
  std::vector<std::string> order_;
  std::map<std::string, DeformInput> inputs_;
  std::map<std::string, DeformReference> references_;
  std::map<std::string, SimplifiedInput> simplified_;
};

}  // namespace

const ContestKind& deform_contest() {
  static const ContestKind kind{
      "deform",
      {"scenes", "reference", "simplify", "scene_sets", "targets", "frontier", "beside", "charts"},
      {"scenes", "reference"},
      {},
      {"error_bars", "error_time", "convergence", "simplified_error", "error_count", "frontier"},
      read_deform_plan,
      cross_cases,
      [](const ContestSetting& setting) -> std::unique_ptr<Contest> {
        return std::make_unique<DeformContest>(setting);
      }};
  return kind;
}

}  // namespace palpate::experiments

#include "experiments/contests/verify/verify_contest.h"

#include <cmath>
#include <map>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/judge/displacement/solution_error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "experiments/contests/problem_files.h"
#include "experiments/contests/verify/plan_verify.h"
#include "reference/closed_form/known_cases.h"
#include "reference/door/deform_problem.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using reference::KnownValue;

/// A known case on one mesh, written for the requests.
struct KnownInput {
  reference::KnownCase known;
  ProblemFiles files;
};

std::string input_id(const Plan& plan, const Case& run_case) {
  return plan.subjects[run_case.subject] + "/cells=" + run_case.sweep.at("cells").dump();
}

/// The known value, of the contestant's field.
double read_value(const KnownInput& input, const std::vector<Vec3>& field) {
  const KnownValue& value = *input.known.value;
  if (value.kind == KnownValue::Kind::kDisplacement) return component(field[value.vertex], value.row);
  const Material& material = input.known.problem.material;
  const auto stress =
      judge::stress_at_vertex(input.known.mesh, field, value.vertex, material.lambda_pa(), material.mu_pa());
  return component(stress[value.row], value.column);
}

/// Below this, an error is rounding and has no order.
constexpr double kRounding = 1e-10;

void add_value_figures(const KnownInput& input, const std::vector<Vec3>& field, json& figures) {
  const double expected = input.known.value->value;
  const double found = read_value(input, field);
  figures["value"] = found;
  figures["value_known"] = expected;
  figures["value_error"] = std::fabs(found - expected) / std::fabs(expected);
}

judge::SolutionError solution_error(const KnownInput& input, const std::vector<Vec3>& field) {
  return judge::compare_with_solution(input.known.mesh, field, input.known.displacement);
}

std::vector<Vec3> read_field(const KnownInput& input, const std::filesystem::path& file) {
  const TetMesh& mesh = input.known.mesh;
  return reference::read_displacement(file, mesh.points.size(), build_edges(mesh).size());
}

class VerifyContest : public Contest {
 public:
  explicit VerifyContest(const ContestSetting& setting) : setting_(setting) {}

  json prepare(const std::vector<const Case*>& cases, const json& earlier) override {
    json described = earlier.is_null() ? json::object() : earlier.value("problems", json::object());
    for (const Case* c : cases) {
      require_going_on(setting_);
      prepare_input(*c, described);
      if (const auto coarser = coarser_case(*c)) prepare_input(*coarser, described);
    }
    return {{"problems", described}};
  }

  bool record_inputs(const std::set<std::string>&, const std::function<void(json)>&) override {
    return true;  // what is known needs no solution
  }

  std::string fill_task(const Case& run_case, ContestantTask& task) const override {
    const ProblemFiles& files = input_of(run_case).files;
    task.mesh_in = files.mesh_file;
    task.problem_in = files.problem_file;
    return "";
  }

  json build_record(const RepeatFacts& facts, const ContestantAnswer& answer,
                    const std::vector<json>& earlier) const override {
    const KnownInput& input = input_of(facts.run_case);
    const auto judge = [&](const std::filesystem::path& file) {
      return judge_answer_of(facts.run_case, answer.report, file);
    };
    const auto hold = [&](json& record) { add_expectation_violations(facts, record); };
    json record = start_record(
        facts, mesh_facts(known_of(facts.run_case).name, input.known.mesh, input.files.mesh_hash), answer);
    record["scene"] = {{"name", known_of(facts.run_case).name},
                       {"problem_hash", input.files.problem_hash},
                       {"strain", input.known.problem.strain == StrainSize::kSmall ? "small" : "large"},
                       {"young_modulus_pa", input.known.problem.material.young_modulus_pa},
                       {"poisson_ratio", input.known.problem.material.poisson_ratio}};
    judge_answer({judge, hold, "displacement"}, facts, answer, earlier, record);
    return record;
  }

  std::filesystem::path kept_output(const Case& run_case) const override {
    return setting_.folder.paths().displacement(run_case.id);
  }

 private:
  const PlanKnownCase& known_of(const Case& run_case) const {
    return part_of<VerifyPart>(setting_.plan).known_cases[run_case.subject];
  }

  const KnownInput& input_of(const Case& run_case) const {
    return inputs_.at(input_id(setting_.plan, run_case));
  }

  /// The case on the next coarser mesh; nothing on the first.
  std::optional<Case> coarser_case(const Case& run_case) const {
    const std::vector<int>& cells = known_of(run_case).cells;
    const int own = run_case.sweep.at("cells").get<int>();
    Case coarser = run_case;
    for (std::size_t i = 1; i < cells.size(); ++i) {
      if (cells[i] != own) continue;
      coarser.sweep["cells"] = cells[i - 1];
      coarser.id.replace(coarser.id.rfind('=') + 1, std::string::npos, std::to_string(cells[i - 1]));
      return coarser;
    }
    return std::nullopt;
  }

  void prepare_input(const Case& run_case, json& described) {
    const std::string id = input_id(setting_.plan, run_case);
    if (inputs_.count(id) > 0) return;
    setting_.progress.show("case " + id);
    KnownInput input;
    input.known = reference::build_known_case(known_of(run_case).name, run_case.sweep.at("cells").get<int>());
    input.files.mesh = input.known.mesh;
    input.files.problem = input.known.problem;
    write_problem(input.files, setting_.folder.paths().problem(id));
    describe_problem(setting_.folder.paths(), id, input.files, described);
    inputs_.emplace(id, std::move(input));
  }

  json judge_answer_of(const Case& run_case, const json& report, const std::filesystem::path& file) const {
    json figures = {{"valid", false}, {"findings", json::array()}};
    const std::string outcome = report.at("outcome").get<std::string>();
    if (outcome != "converged") {
      figures["findings"].push_back("its outcome is " + outcome);
      return figures;
    }
    const KnownInput& input = input_of(run_case);
    const std::vector<Vec3> field = read_field(input, file);
    if (input.known.value) add_value_figures(input, field, figures);
    if (input.known.displacement) {
      const judge::SolutionError error = solution_error(input, field);
      figures["solution_l2"] = error.relative_l2;
      figures["solution_max"] = error.relative_max;
      if (const auto order = order_of(run_case, error.relative_l2)) figures["solution_order"] = *order;
    }
    figures["valid"] = true;
    return figures;
  }

  /// From what the same contestant left on the next coarser mesh; nothing without one, or where rounding is
  /// all.
  std::optional<double> order_of(const Case& run_case, double error) const {
    const auto coarser = coarser_case(run_case);
    if (!coarser || error < kRounding || !std::filesystem::exists(kept_output(*coarser))) return std::nullopt;
    const KnownInput& before = input_of(*coarser);
    const double error_before = solution_error(before, read_field(before, kept_output(*coarser))).relative_l2;
    if (error_before < kRounding) return std::nullopt;
    return judge::observed_order(error_before, coarser->sweep.at("cells").get<double>(), error,
                                 run_case.sweep.at("cells").get<double>());
  }

  void add_expectation_violations(const RepeatFacts& facts, json& record) const {
    const PlanKnownCase& known = known_of(facts.run_case);
    if (facts.run_case.sweep.at("cells").get<int>() != known.cells.back()) return;
    const KnownCaseExpectation* expectation = find_expectation(known, facts.contestant.label);
    require(expectation != nullptr, "verify: a case that expects nothing");
    add_bound_violations(expectation->bounds, record);
  }

  ContestSetting setting_;
  std::map<std::string, KnownInput> inputs_;
};

}  // namespace

const ContestKind& verify_contest() {
  static const ContestKind kind{"verify",
                                {"cases"},
                                {"cases"},
                                {{"sweep", "the contest verify sweeps the cells of its cases"},
                                 {"accept", "the contest verify has its bounds in \"expect\""}},
                                {},
                                read_verify_plan,
                                build_verify_cases,
                                [](const ContestSetting& setting) -> std::unique_ptr<Contest> {
                                  return std::make_unique<VerifyContest>(setting);
                                }};
  return kind;
}

}  // namespace palpate::experiments

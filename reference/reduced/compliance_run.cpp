#include "reference/reduced/compliance_run.h"

#include <string>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/reduced/compliance_answer.h"
#include "reference/door/deform_problem.h"
#include "reference/door/request_options.h"
#include "reference/linear_systems/answer_cost.h"
#include "reference/linear_systems/factor.h"
#include "reference/reduced/table_file.h"

namespace palpate::reference {
namespace {

using dynamics::ComplianceTable;
using dynamics::HeldBody;
using nlohmann::json;

struct TableRunOptions {
  dynamics::ComplianceOptions table;
  bool single = true;
  std::string factor;
  std::string read;    ///< a table to read instead of making one
  bool write = false;  ///< beside the displacement
};

TableRunOptions take_table_options(const Request& request) {
  if (request.method != "reduced.compliance")
    throw InputError("method", 0, "reduced.compliance", request.method);
  json left = request.options;
  TableRunOptions options;
  options.table.element_order = take_choice(left, "elements", {"p2", "p1"}) == 0 ? 2 : 1;
  options.table.refine = static_cast<int>(take_whole(left, "refine", 0, 1, 0));
  options.table.reaction_order = take_choice(left, "reactions", {"linear", "quadratic"}) == 0 ? 1 : 2;
  options.table.midpoints = take_option<bool>(left, "midpoints", &json::is_boolean, "true or false", false);
  options.single = take_choice(left, "precision", {"single", "double"}) == 0;
  const std::vector<std::string> factors{"auto", "cholmod", "eigen"};
  options.factor = factors[take_choice(left, "factor", factors)];
  options.read = take_option<std::string>(left, "table", &json::is_string, "the path of a table", "");
  options.write = take_option<bool>(left, "write_table", &json::is_boolean, "true or false", false);
  require_all_taken(left);
  return options;
}

/// The table, made or read, with what that took in the report.
ComplianceTable obtain_table(const TableRunOptions& options, const DeformTask& task, Response& response) {
  json& report = response.report;
  const Stopwatch start;
  if (!options.read.empty()) {
    ComplianceTable table = read_table(options.read);
    const auto& made = table.options;
    if (made.element_order != options.table.element_order || made.refine != options.table.refine ||
        made.reaction_order != options.table.reaction_order || made.midpoints != options.table.midpoints ||
        table.is_single() != options.single)
      throw InputError(options.read, 0,
                       "a table of the elements, reactions, precision and midpoints that are asked for",
                       "another");
    report["read_s"] = start.seconds();
    report["identify_s"] = 0.0;
    return table;
  }
  dynamics::ComplianceOptions wanted = options.table;
  wanted.poisson_ratio = task.problem.material.poisson_ratio;
  dynamics::ComplianceSetup setup;
  ComplianceTable table = build_compliance_table(task.mesh, wanted, choose_factor(options.factor), setup);
  if (options.single) table = to_single(table);
  report["identify_s"] = start.seconds();
  report["unknowns"] = setup.unknowns;
  report["factor_entries"] = setup.factor_entries;
  report["assembly_s"] = setup.assembly_s;
  report["factor_s"] = setup.factor_s;
  report["columns_s"] = setup.solve_s;
  return table;
}

json to_json(const std::vector<Vec3>& forces) {
  json list = json::array();
  for (const Vec3& f : forces) list.push_back({f.x, f.y, f.z});
  return list;
}

/// What an answer costs once the holding is factored; outside the kernel.
void time_answers(const HeldBody& held, const BoundaryProblem& problem, json& report) {
  const auto load = held.prepare(problem);
  report["react_s"] = median_seconds([&] { held.react(*load); });
  report["move_skin_s"] = median_seconds([&] { held.move_skin(*load); });
  report["move_inside_s"] = median_seconds([&] { held.move_inside(*load); });
  report["answer_s"] = median_seconds([&] {
    held.react(*load);
    held.move_skin(*load);
  });
}

}  // namespace

Response run_compliance(const Request& request) {
  const TableRunOptions options = take_table_options(request);
  const DeformTask task = read_deform_task(request);
  if (task.problem.strain == StrainSize::kLarge)
    throw InputError("strain", 0, "small: reduced.compliance is linear", "large");
  Response response;
  response.report = {{"method", request.method}};
  json& report = response.report;

  const Stopwatch start;
  ComplianceTable table = obtain_table(options, task, response);
  const Stopwatch holding;
  const HeldBody held(table, task.mesh, task.problem);
  report["prepare_s"] = holding.seconds();
  const Stopwatch solving;
  const dynamics::ComplianceAnswer answer = held.solve(task.problem);
  report["solve_s"] = solving.seconds();
  response.kernel_s = start.seconds();

  time_answers(held, task.problem, report);
  report["outcome"] = "converged";
  report["energy_j"] = answer.energy_j;
  report["potential_j"] = answer.potential_j;
  report["iterations"] = 1;
  report["residual_relative"] = answer.residual_relative;
  report["support_forces_n"] = to_json(answer.support_forces_n);
  report["factor"] = options.factor == "auto" ? best_factor_name() : options.factor;
  report["precision"] = table.is_single() ? "single" : "double";
  report["skin_nodes"] = table.nodes.size();
  report["touched_components"] = held.touched();
  report["skin_table_bytes"] = table.skin_bytes();
  report["field_table_bytes"] = table.field_bytes();
  if (options.write) {
    const std::filesystem::path path = request.output.string() + ".compliance";
    write_table(path, table);
    report["table_file"] = path.string();
    report["table_format"] = "palpate/compliance_table/1";
  }
  write_displacement(request.output, answer.displacement_m);
  return response;
}

}  // namespace palpate::reference

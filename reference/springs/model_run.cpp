#include "reference/springs/model_run.h"

#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/motion/frozen_part.h"
#include "core/dynamics/statics/static_equilibrium.h"
#include "reference/door/deform_problem.h"
#include "reference/door/request_options.h"
#include "reference/elastic_models/model_cost.h"
#include "reference/elastic_models/model_request.h"
#include "reference/elastic_models/step_cost.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

dynamics::StaticOptions take_static_options(StrainSize strain, int threads, json& options) {
  dynamics::StaticOptions out;
  out.linearised = strain == StrainSize::kSmall;
  out.load_steps = static_cast<int>(take_whole(options, "load_steps", 1, 1000, 1));
  out.max_iterations = static_cast<std::size_t>(take_whole(options, "max_iterations", 1, 10000, 150));
  out.tolerance = take_number(options, "tolerance", 1e-13, 0.1, 1e-9);
  constexpr std::array kMethods{dynamics::LinearMethod::kAuto, dynamics::LinearMethod::kDirect,
                                dynamics::LinearMethod::kConjugateGradients};
  out.linear.method = kMethods[take_choice(options, "solver", {"auto", "direct", "conjugate_gradients"})];
  out.linear.threads = threads;
  return out;
}

/// Share of the elastic energy of a displacement that the springs hold: 1 for springs alone, 0 for smoothed
/// elements alone. Nothing where there is no energy.
std::optional<double> spring_share(const dynamics::ElasticModel& model, std::span<const Vec3> displacement) {
  const dynamics::ElasticModel springs{model.rest, model.springs, model.springs_are_linear, {}, {}};
  const double whole = dynamics::elastic_energy(model, displacement);
  if (!(whole > 0.0) || !std::isfinite(whole)) return std::nullopt;
  return dynamics::elastic_energy(springs, displacement) / whole;
}

void report_solution(const dynamics::StaticReport& report, Response& response) {
  response.report["outcome"] = dynamics::static_outcome_name(report.outcome);
  response.report["iterations"] = report.iterations;
  response.report["linear_iterations"] = report.linear_iterations;
  response.report["load_steps"] = report.load_steps;
  response.report["indefinite_tangents"] = report.indefinite_tangents;
  response.report["inverted_tets"] = report.inverted_tets;
  response.report["least_volume_ratio"] = report.least_volume_ratio;
  response.report["residual_relative"] = report.residual_relative;
  response.report["energy_j"] = report.elastic_energy_j;
  response.report["potential_j"] = report.potential_j;
}

}  // namespace

Response run_model(const Request& request) {
  const DeformTask task = read_deform_task(request);
  const StrainSize strain = task.problem.strain;
  json left = request.options;
  const ModelRequest wanted = take_model_request(request.method, strain, left);
  const dynamics::StaticOptions options = take_static_options(strain, request.threads, left);
  const bool with_cost = take_option<bool>(left, "cost", &json::is_boolean, "true or false", false);
  if (with_cost && strain == StrainSize::kLarge)
    throw InputError("cost", 0, "small strain: it is that of one linear system", "large");
  const bool with_steps = take_option<bool>(left, "step_cost", &json::is_boolean, "true or false", false);
  require_all_taken(left);

  Response response;
  response.report = {{"method", request.method}, {"vertices", task.mesh.points.size()}};
  const Stopwatch kernel;
  dynamics::Loads loads = dynamics::build_loads(task.mesh, task.problem);
  const std::vector<Index> frozen = read_frozen(wanted, task.mesh);
  dynamics::hold_frozen(frozen, loads);
  dynamics::require_no_rigid_motion(task.mesh, loads);
  const Stopwatch building;
  const dynamics::BuiltModel built =
      build_requested_model(task.mesh, task.problem.material, wanted, response);
  response.report["assembly_s"] = building.seconds() - response.report["identify_s"].get<double>();
  const Stopwatch solving;
  const dynamics::StaticSolution solution = dynamics::solve_static(task.mesh, built.model, loads, options);
  response.report["solve_s"] = solving.seconds();
  response.kernel_s = kernel.seconds();

  response.report["theta"] = built.theta;
  report_solution(solution.report, response);
  if (const auto share = spring_share(built.model, solution.displacement_m))
    response.report["stiffness_share_springs"] = *share;
  if (!frozen.empty()) {
    std::vector<Vec3> force(task.mesh.points.size());
    dynamics::add_elastic_forces(built.model, solution.displacement_m, force);
    dynamics::add_load_forces(loads, solution.displacement_m, 1.0, force);
    response.report["frozen_vertices"] = frozen.size();
    response.report["frozen_force_most_n"] = dynamics::frozen_force(frozen, force);
  }
  if (with_cost) report_cost(measure_model_cost(built.model, loads), response.report);
  if (with_steps) {
    report_step_cost(measure_step_cost(task.mesh, built.model, loads, task.problem.material.density_kg_m3,
                                       request.threads),
                     response.report);
  }
  if (solution.report.outcome == dynamics::StaticOutcome::kConverged)
    write_displacement(request.output, solution.displacement_m);
  return response;
}

}  // namespace palpate::reference

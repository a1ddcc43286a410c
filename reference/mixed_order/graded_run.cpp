#include "reference/mixed_order/graded_run.h"

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/dynamics/finite_elements/tet_locator.h"
#include "core/dynamics/statics/static_equilibrium.h"
#include "core/mesh/topology.h"
#include "reference/elastic_models/model_cost.h"
#include "reference/mixed_order/order_options.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

struct GradedOptions {
  AdaptOptions adapt;
  bool midpoints = false;
};

GradedOptions take_graded_options(const Request& request) {
  json left = request.options;
  GradedOptions options;
  options.adapt = take_adapt_options(left);
  options.midpoints = take_option<bool>(left, "midpoints", &json::is_boolean, "true or false", false);
  require_all_taken(left);
  return options;
}

/// smoothed.edge_node: shear over the edges, dilatation over the nodes, no parameter.
dynamics::BlendOptions edge_node_blend() {
  dynamics::BlendOptions blend;
  blend.theta = 0.0;
  blend.rest = dynamics::StrainDomain::kEdge;
  return blend;
}

}  // namespace

Response run_graded(const Request& request) {
  const GradedOptions options = take_graded_options(request);
  const DeformTask task = read_small_task(request);
  Response response;
  json& report = response.report;
  report = {{"method", request.method}, {"identify_s", 0.0}};

  const Stopwatch kernel;
  AdaptOptions adapt = options.adapt;
  adapt.vertices = task.mesh.points.size();
  const AdaptedBody body = adapt_body(task.mesh, task.problem, adapt);
  report["adapt_s"] = kernel.seconds();
  const dynamics::Loads loads = dynamics::build_loads(body.mesh, body.problem);
  const dynamics::BuiltModel built =
      dynamics::build_blend_model(body.mesh, body.problem.material, edge_node_blend());
  dynamics::StaticOptions solving_options;
  solving_options.linearised = true;
  solving_options.linear.threads = request.threads;
  const Stopwatch solving;
  const dynamics::StaticSolution solution =
      dynamics::solve_static(body.mesh, built.model, loads, solving_options);
  report["solve_s"] = solving.seconds();
  const dynamics::ElementSpace space = dynamics::build_element_space(body.mesh, 1);
  const dynamics::TetLocator locator(body.mesh);
  std::vector<Vec3> displacement;
  const auto add = [&](const Vec3& point) {
    displacement.push_back(evaluate(space, solution.displacement_m, locator.find(point)));
  };
  for (const Vec3& point : task.mesh.points) add(point);
  if (options.midpoints) {
    for (const auto& [a, b] : build_edges(task.mesh)) add(0.5 * (task.mesh.points[a] + task.mesh.points[b]));
  }
  response.kernel_s = kernel.seconds();

  report["outcome"] = dynamics::static_outcome_name(solution.report.outcome);
  report["iterations"] = solution.report.iterations;
  report["residual_relative"] = solution.report.residual_relative;
  report["energy_j"] = solution.report.elastic_energy_j;
  report["potential_j"] = solution.report.potential_j;
  report["vertices_solved"] = body.mesh.points.size();
  report["vertices_coarse"] = body.vertices_coarse;
  for (const std::string& warning : built.warnings) response.notes.push_back(warning);
  report_cost(measure_model_cost(built.model, loads), report);
  if (solution.report.outcome == dynamics::StaticOutcome::kConverged)
    write_displacement(request.output, displacement);
  return response;
}

}  // namespace palpate::reference

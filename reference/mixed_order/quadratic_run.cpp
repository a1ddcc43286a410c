#include "reference/mixed_order/quadratic_run.h"

#include <optional>
#include <string>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/finite_elements/tet_locator.h"
#include "core/mesh/topology.h"
#include "reference/door/deform_problem.h"
#include "reference/linear_systems/answer_cost.h"
#include "reference/linear_systems/factor.h"
#include "reference/mixed_order/adapted_body.h"
#include "reference/mixed_order/modulus_fit.h"
#include "reference/mixed_order/order_options.h"
#include "reference/mixed_order/solid_system.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

struct QuadraticOptions {
  bool is_patch = true;
  int rings = 1;
  AdaptOptions adapt;
  double added = 0.0;  ///< vertices that halving adds, over those of the organ
  bool fits_modulus = false;
  CommonOptions common;
};

QuadraticOptions take_quadratic_options(const Request& request) {
  json left = request.options;
  QuadraticOptions options;
  options.is_patch = request.method == "fem.p2_patch";
  if (options.is_patch) {
    options.rings = static_cast<int>(take_whole(left, "rings", -1, 1'000'000, options.rings));
  } else {
    options.adapt = take_adapt_options(left);
    options.added = take_number(left, "added", 0.0, 100.0, options.added);
  }
  options.fits_modulus = take_choice(left, "scale", {"none", "gravity"}) == 1;
  options.common = take_common_options(left);
  require_all_taken(left);
  return options;
}

/// The space that is solved in, and how its fields come to the organ's vertices.
struct QuadraticBody {
  SolidSpace solid;
  BoundaryProblem problem;
  std::size_t vertices_coarse = 0;
  std::vector<dynamics::TetPlace> places;  ///< of the organ's vertices, then of its edges' midpoints
};

/// fem.p2_patch: the organ's own mesh.
QuadraticBody build_patch(const DeformTask& task, int rings) {
  QuadraticBody body{{task.mesh, dynamics::build_element_space(task.mesh, 2), {}},
                     task.problem,
                     task.mesh.points.size(),
                     {}};
  const std::vector<std::uint8_t> touched = dynamics::find_touched(task.mesh.points.size(), task.problem);
  body.solid.map =
      follow_edges(body.solid.space, dynamics::find_edges_near(body.solid.space.edges, touched, rings));
  return body;
}

/// fem.p2_coarse: another mesh, all of it quadratic.
QuadraticBody build_coarse(const DeformTask& task, const QuadraticOptions& options) {
  AdaptOptions adapt = options.adapt;
  adapt.added = static_cast<std::size_t>(options.added * static_cast<double>(task.mesh.points.size()));
  AdaptedBody adapted = adapt_body(task.mesh, task.problem, adapt);
  QuadraticBody body;
  body.vertices_coarse = adapted.vertices_coarse;
  body.solid.mesh = std::move(adapted.mesh);
  body.problem = std::move(adapted.problem);
  body.solid.space = dynamics::build_element_space(body.solid.mesh, 2);
  body.solid.map =
      follow_edges(body.solid.space, std::vector<std::uint8_t>(body.solid.space.edges.edges.size(), 1));
  const dynamics::TetLocator locator(body.solid.mesh);
  for (const Vec3& point : task.mesh.points) body.places.push_back(locator.find(point));
  for (const auto& [a, b] : build_edges(task.mesh))
    body.places.push_back(locator.find(0.5 * (task.mesh.points[a] + task.mesh.points[b])));
  return body;
}

/// A field at the first `rows` of the organ's vertices and midpoints.
std::vector<Vec3> sample_rows(const QuadraticBody& body, std::span<const Vec3> all, std::size_t rows) {
  if (body.places.empty()) return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(rows)};
  std::vector<Vec3> out;
  out.reserve(rows);
  for (std::size_t i = 0; i < rows; ++i) out.push_back(evaluate(body.solid.space, all, body.places[i]));
  return out;
}

void report_fit(const ModulusFit& fit, json& report) {
  report["modulus_scale"] = fit.scale;
  report["fit_off_before"] = fit.off_before;
  report["fit_off_after"] = fit.off_after;
}

void report_size(const QuadraticBody& body, json& report) {
  std::size_t midpoints = body.solid.map.nodes.size() - body.solid.mesh.points.size();
  report["vertices_solved"] = body.solid.mesh.points.size();
  report["vertices_coarse"] = body.vertices_coarse;
  report["midpoints_solved"] = midpoints;
}

}  // namespace

Response run_quadratic(const Request& request) {
  const QuadraticOptions options = take_quadratic_options(request);
  const DeformTask task = read_small_task(request);
  const std::size_t vertices = task.mesh.points.size();
  const dynamics::FactorMaker make_factor = choose_factor(options.common.factor);
  Response response;
  json& report = response.report;
  report = {{"method", request.method}};

  const Stopwatch kernel;
  const QuadraticBody body =
      options.is_patch ? build_patch(task, options.rings) : build_coarse(task, options);
  report["adapt_s"] = kernel.seconds();
  ModulusFit fit;
  const Stopwatch fitting;
  if (options.fits_modulus) {
    const auto at_vertices = [&](std::span<const Vec3> all) { return sample_rows(body, all, vertices); };
    fit = fit_modulus({task.mesh, task.problem, body.solid, body.problem}, at_vertices, make_factor);
  }
  report["identify_s"] = options.fits_modulus ? fitting.seconds() : 0.0;
  const Stopwatch assembling;
  const dynamics::NodeLoads loads =
      build_node_loads(body.solid.mesh, body.solid.space, body.problem, dynamics::BodyForces::kInclude);
  const SolidSystem system = build_solid_system(body.solid, body.problem.material, loads);
  report["assembly_s"] = assembling.seconds();
  const Stopwatch solving;
  const dynamics::HeldElements held(system.body, system.stiffness(fit.scale), system.held, make_factor);
  const std::vector<Vec3> unknown = held.rest_under(
      apply_transposed(body.solid.map, sum_forces(loads, body.solid.space.order)), system.held_by_m);
  report["solve_s"] = solving.seconds();
  const std::vector<Vec3> all = apply_map(body.solid.map, unknown);
  const std::size_t rows = vertices + (options.common.midpoints ? build_edges(task.mesh).size() : 0);
  const std::vector<Vec3> displacement = sample_rows(body, all, rows);
  response.kernel_s = kernel.seconds();

  report_figures(measure_solid(body.solid, system, loads, fit.scale, unknown, body.problem.supports.size()),
                 report);
  report_size(body, report);
  if (options.fits_modulus) {
    report_fit(fit, report);
    response.notes.emplace_back(
        "the modulus was scaled by three gravity solves of quadratic elements on the whole mesh, on the "
        "scene's own supports: a scene under gravity is one of what it was fitted to");
  }
  report_cost(measure_cost(held.stiffness(), held.factor(), held.unknowns()), report);
  write_displacement(request.output, displacement);
  return response;
}

}  // namespace palpate::reference

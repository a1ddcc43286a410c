// Adapter of the method of finite spheres, in Galerkin form and by point collocation.
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "reference/door/deform_problem.h"
#include "reference/door/json_file.h"
#include "reference/door/request_options.h"
#include "reference/finite_spheres/collocation.h"
#include "reference/finite_spheres/sphere_field.h"
#include "reference/finite_spheres/sphere_system.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

struct Options {
  SphereFunctions functions = SphereFunctions::kLeastSquares;
  double radius = 1.5;
  IntegrationOptions integration;
  double nitsche = 100.0;
  double local_radius_m = 0.0;  ///< 0: all spheres move
  SphereSolverOptions solver;
  bool midpoints = false;
};

template <typename Enum, std::size_t kCount>
Enum take_name(json& left, const EnumNames<Enum, kCount>& names, Enum fallback) {
  return names.parse(take_option<std::string>(left, names.what, &json::is_string, names.known().c_str(),
                                              names.of(fallback)));
}

Options take_options(const Request& request) {
  if (request.method != "finite_spheres") throw InputError("method", 0, "finite_spheres", request.method);
  json left = request.options;
  Options options;
  options.functions = take_name(left, kSphereFunctionNames, options.functions);
  options.radius = take_number(left, "radius", 1.01, 4.0, options.radius);
  options.integration.kind = take_name(left, kSphereIntegrationNames, options.integration.kind);
  options.integration.points =
      static_cast<int>(take_whole(left, "points", 1, 14, options.integration.points));
  build_tet_rule(options.integration.points, 0);  // refuses what is no rule
  options.integration.subdivide =
      static_cast<int>(take_whole(left, "subdivide", 0, 2, options.integration.subdivide));
  if (options.functions == SphereFunctions::kShepard && options.integration.kind == SphereIntegration::kNodal)
    throw InputError("integration", 0,
                     "gauss for the functions of shepard: a point a vertex leaves half of them loose",
                     "nodal");
  options.nitsche = take_number(left, "nitsche", 1.0, 1e6, options.nitsche);
  options.local_radius_m = take_number(left, "local_radius_m", 0.0, 1e6, options.local_radius_m);
  options.solver.solver = take_name(left, kSphereSolverNames, options.solver.solver);
  options.solver.tolerance = take_number(left, "rtol", 1e-13, 1e-7, options.solver.tolerance);
  options.solver.most_iterations = static_cast<std::size_t>(take_whole(
      left, "iterations", 1, 10'000'000, static_cast<std::int64_t>(options.solver.most_iterations)));
  options.solver.threads = request.threads;
  options.midpoints =
      take_option<bool>(left, "midpoints", &json::is_boolean, "true or false", options.midpoints);
  require_all_taken(left);
  return options;
}

/// Where something presses: faces of tractions, of pads and held faces that are moved, and vertices with a
/// force.
std::vector<Triangle> loaded_places(const BoundaryProblem& problem) {
  std::vector<Triangle> loaded;
  const auto add = [&](const std::vector<Triangle>& faces) {
    loaded.insert(loaded.end(), faces.begin(), faces.end());
  };
  for (const Traction& traction : problem.tractions) add(traction.patch.faces);
  for (const ElasticSupport& support : problem.supports) {
    if (length_sq(support.by_m) > 0.0) add(support.patch.faces);
  }
  for (const HeldFaces& held : problem.held) {
    if (length_sq(held.by_m) > 0.0 || !problem.held_field_m.empty()) add(held.faces);
  }
  for (const NodalForce& force : problem.nodal_forces)
    loaded.push_back({force.vertex, force.vertex, force.vertex});
  return loaded;
}

/// The energies of an answer; what supports and held faces added to the matrix is taken off it.
void report_energies(const DeformTask& task, const Options& options, const SphereField& field,
                     const SphereSystem& system, const SphereSolution& found, json& report) {
  const std::vector<Vec3>& a = found.coefficients_m;
  const BoundaryFigures boundary =
      measure_boundary(field, task.problem, options.integration, options.nitsche, a);
  std::vector<Vec3> pull(a.size());
  dynamics::multiply(system.matrix, a, pull);
  const double energy_j = 0.5 * dynamics::dot_of(a, pull) - boundary.quadratic_j;
  report["energy_j"] = energy_j;
  report["potential_j"] = energy_j + boundary.supports_j - dynamics::dot_of(system.dead_n, a);
  if (!task.problem.held.empty()) report["held_error_m"] = boundary.held_error_m;
  json forces = json::array();
  for (const Vec3& f : boundary.supports_n) forces.push_back({f.x, f.y, f.z});
  report["support_forces_n"] = std::move(forces);
}

/// The force of each support on the body, from the displacement at the vertices of its faces.
json support_forces(const DeformTask& task, const std::vector<Vec3>& u) {
  json forces = json::array();
  for (const ElasticSupport& support : task.problem.supports) {
    Vec3 sum;
    for (std::size_t k = 0; k < support.patch.faces.size(); ++k) {
      const Triangle& f = support.patch.faces[k];
      const auto& p = task.mesh.points;
      const double area = 0.5 * length(cross(p[f[1]] - p[f[0]], p[f[2]] - p[f[0]]));
      for (const Index v : f)
        sum =
            sum + (support.patch.weight[k] * support.stiffness_pa_per_m * area / 3.0) * (support.by_m - u[v]);
    }
    forces.push_back({sum.x, sum.y, sum.z});
  }
  return forces;
}

/// Of the forces that act, out of balance: from here on the answer is not given, or given with a note. Chosen
/// on the bean and the ball (docs/finite_spheres.md).
constexpr double kWorthlessShare = 0.3;
constexpr double kDoubtfulShare = 0.05;

/// Whether an answer is worth giving by what it leaves out of balance; a note where that is much. A share
/// that is not known (of bodies with held faces) passes.
bool keeps_balance(double share, std::vector<std::string>& notes) {
  if (!(share > kDoubtfulShare)) return true;
  const bool is_given = share <= kWorthlessShare;
  notes.push_back(three_digits(100.0 * share) + "% of the forces are out of balance: " +
                  (is_given ? "the answer may be far off" : "the answer is worthless and not given") +
                  "; a larger radius helps, above all near nu 1/2");
  return is_given;
}

Response answer_by_collocation(const Request& request) {
  json left = request.options;
  const double radius = take_number(left, "radius", 1.01, 4.0, 1.5);
  const double local_radius_m = take_number(left, "local_radius_m", 0.0, 1e6, 0.0);
  require_all_taken(left);
  const DeformTask task = read_deform_task(request);
  if (task.problem.strain == StrainSize::kLarge)
    throw InputError("strain", 0, "small: finite_spheres.collocation is linear", "large");
  dynamics::require_no_rigid_motion(task.mesh, dynamics::build_loads(task.mesh, task.problem));

  const Stopwatch watch;
  SphereField field = build_sphere_field(task.mesh, radius, SphereFunctions::kLeastSquares);
  if (local_radius_m > 0.0) localise(field, loaded_places(task.problem), local_radius_m);
  const std::vector<DerivativeStencil> stencils = build_stencils(task.mesh, field.spheres);
  const double assembly_s = watch.seconds();
  const CollocationResult found = solve_collocation(task.mesh, task.problem, stencils, field.moving);
  Response response;
  response.kernel_s = watch.seconds();
  const bool is_given = found.converged && keeps_balance(found.net_force_share, response.notes);
  response.report = {{"method", request.method},
                     {"outcome", is_given ? "converged" : "not_converged"},
                     {"identify_s", 0.0},
                     {"assembly_s", assembly_s},
                     {"solve_s", response.kernel_s - assembly_s},
                     {"residual_relative", found.residual_relative},
                     {"spheres", field.moving_spheres},
                     {"unknowns", 3 * field.moving_spheres},
                     {"matrix_entries", found.entries},
                     {"factor_entries", found.factor_entries},
                     {"net_force_share", number_or_null(found.net_force_share)}};
  if (!is_given) return response;
  response.report["support_forces_n"] = support_forces(task, found.displacement_m);
  write_displacement(request.output, found.displacement_m);
  return response;
}

Response answer(const Request& request) {
  if (request.method == "finite_spheres.collocation") return answer_by_collocation(request);
  const Options options = take_options(request);
  const DeformTask task = read_deform_task(request);
  if (task.problem.strain == StrainSize::kLarge)
    throw InputError("strain", 0, "small: finite_spheres is linear", "large");
  dynamics::require_no_rigid_motion(task.mesh, dynamics::build_loads(task.mesh, task.problem));

  const Stopwatch watch;
  SphereField field = build_sphere_field(task.mesh, options.radius, options.functions);
  if (options.local_radius_m > 0.0) localise(field, loaded_places(task.problem), options.local_radius_m);
  SphereSystem system = build_body_system(field, task.problem, options.integration);
  add_boundary(field, task.problem, options.integration, options.nitsche, system);
  const double assembly_s = watch.seconds();
  const SphereSolution found = solve_spheres(system, options.solver);
  const double solved_s = watch.seconds();
  const std::vector<Vec3> displacement = sample_displacement(field, found.coefficients_m, options.midpoints);
  Response response;
  response.kernel_s = watch.seconds();

  const std::size_t blocks = system.matrix.blocks.size();
  response.report = {{"method", request.method},
                     {"outcome", found.converged ? "converged" : "not_converged"},
                     {"identify_s", 0.0},
                     {"assembly_s", assembly_s},
                     {"solve_s", solved_s - assembly_s},
                     {"sample_s", response.kernel_s - solved_s},
                     {"iterations", found.iterations},
                     {"residual_relative", found.residual_relative},
                     {"indefinite", found.indefinite},
                     {"solver", found.factored ? "direct" : "cg"},
                     {"spheres", field.moving_spheres},
                     {"unknowns", 3 * field.coefficients()},
                     {"points", system.points},
                     {"matrix_entries", 9 * blocks},
                     {"matrix_bytes", blocks * (sizeof(dynamics::Mat3) + sizeof(Index))},
                     {"factor_entries", found.factor_entries},
                     {"spheres_a_tet", static_cast<double>(field.spheres.members.size()) /
                                           static_cast<double>(task.mesh.tets.size())}};
  if (options.functions == SphereFunctions::kShepard && options.integration.points < 14) {
    response.notes.emplace_back(
        "four functions a sphere want more points of integration: errors of fewer than 14 a tet don't fall "
        "with the mesh");
  }
  if (found.indefinite) {
    response.notes.emplace_back(
        "the matrix is not positive definite: a larger `nitsche`, or more points of integration, may be "
        "needed");
  }
  if (!found.converged) return response;
  report_energies(task, options, field, system, found, response.report);
  write_displacement(request.output, displacement);
  return response;
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}

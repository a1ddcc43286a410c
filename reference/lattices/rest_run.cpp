#include "reference/lattices/rest_run.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/elasticity/tangent.h"
#include "core/dynamics/linear_algebra/linear_solver.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/mesh/topology.h"
#include "reference/door/deform_problem.h"
#include "reference/door/request_options.h"
#include "reference/lattices/embedded_loads.h"
#include "reference/lattices/lattice_body.h"

namespace palpate::reference {
namespace {

using dynamics::LinearStatus;
using nlohmann::json;

/// The lattice at rest under its loads.
struct RestSolution {
  std::vector<Vec3> u;
  bool converged = false;
  bool indefinite = false;
  std::size_t iterations = 0;
  double residual_relative = 0.0;
};

/// One solve, and one more of what it leaves.
RestSolution solve_at_rest(const LatticeBody& body, const EmbeddedLoads& loads,
                           const dynamics::LinearOptions& options) {
  constexpr double kMostResidual = 1e-6;
  const std::size_t n = body.elastic.rest.size();
  RestSolution found;
  found.u.resize(n);
  dynamics::BlockMatrix matrix = build_lattice_pattern(body);
  dynamics::add_tangent(body.elastic, found.u, dynamics::TangentKind::kExact, matrix);
  add_load_stiffness(loads, matrix);
  std::vector<Vec3> right(n);
  add_load_forces(loads, found.u, 1.0, right);
  const double size = dynamics::norm_of(right);
  const std::vector<std::uint8_t> held(n);
  dynamics::LinearSolver solver(options);
  found.indefinite = solver.prepare(matrix, held) != LinearStatus::kSolved;
  std::vector<Vec3> left = right;
  std::vector<Vec3> change(n);
  std::vector<Vec3> pull(n);
  for (int round = 0; round < 2 && !found.indefinite && size > 0.0; ++round) {
    const dynamics::LinearResult result = solver.solve(left, change);
    found.indefinite = result.status == LinearStatus::kIndefinite;
    found.iterations += solver.is_direct() ? 1 : result.iterations;
    dynamics::add_scaled(found.u, 1.0, change);
    dynamics::multiply(matrix, found.u, pull, options.threads);
    left = right;
    dynamics::add_scaled(left, -1.0, pull);
    found.residual_relative = dynamics::norm_of(left) / size;
    if (found.residual_relative < options.tolerance) break;
  }
  found.converged = !found.indefinite && found.residual_relative <= kMostResidual;
  return found;
}

/// The force of each support of the problem.
json support_forces(const LatticeBody& body, const DeformTask& task, std::span<const Vec3> u) {
  json forces = json::array();
  for (const ElasticSupport& support : task.problem.supports) {
    BoundaryProblem alone;
    alone.material = task.problem.material;
    alone.supports = {support};
    const Vec3 f = total_force(embed_loads(body, task.mesh, alone), u, 1.0);
    forces.push_back({f.x, f.y, f.z});
  }
  return forces;
}

/// How far the worst vertex of the held faces is from where it is held.
double worst_held_error(const DeformTask& task, std::span<const Vec3> displacement) {
  const dynamics::Loads loads = dynamics::build_loads(task.mesh, task.problem);
  double worst = 0.0;
  for (std::size_t v = 0; v < loads.held.size(); ++v) {
    Vec3 off = displacement[v] - loads.held_by_m[v];
    for (std::size_t i = 0; i < 3; ++i) {
      if (((static_cast<unsigned>(loads.held[v]) >> i) & 1U) == 0) component(off, i) = 0.0;
    }
    worst = std::max(worst, length(off));
  }
  return worst;
}

/// The lattice's field at the vertices, and at the midpoints of edges where they are asked for.
std::vector<Vec3> sample_field(const LatticeBody& body, const TetMesh& mesh, std::span<const Vec3> u,
                               bool midpoints) {
  std::vector<Vec3> out = interpolate(body.vertices, u);
  if (!midpoints) return out;
  std::vector<Vec3> middles;
  for (const auto& [a, b] : build_edges(mesh)) middles.push_back(0.5 * (mesh.points[a] + mesh.points[b]));
  const std::vector<Vec3> there = interpolate(build_embedding(body.lattice, middles), u);
  out.insert(out.end(), there.begin(), there.end());
  return out;
}

}  // namespace

Response run_lattice_at_rest(const Request& request) {
  const DeformTask task = read_deform_task(request);
  json left = request.options;
  const LatticeRequest wanted = take_lattice_request("lattice.", request.method, left);
  dynamics::LinearOptions linear;
  constexpr std::array kMethods{dynamics::LinearMethod::kAuto, dynamics::LinearMethod::kDirect,
                                dynamics::LinearMethod::kConjugateGradients};
  linear.method = kMethods[take_choice(left, "solver", {"auto", "direct", "conjugate_gradients"})];
  linear.threads = request.threads;
  const bool midpoints = take_option<bool>(left, "midpoints", &json::is_boolean, "true or false", false);
  require_all_taken(left);
  dynamics::require_no_rigid_motion(task.mesh, dynamics::build_loads(task.mesh, task.problem));

  const Stopwatch watch;
  const LatticeBody body = build_lattice_body(task.mesh, task.problem, wanted);
  const double identified_s = watch.seconds();
  const EmbeddedLoads loads = embed_loads(body, task.mesh, task.problem);
  const double assembled_s = watch.seconds();
  const RestSolution found = solve_at_rest(body, loads, linear);
  const double solved_s = watch.seconds();
  const std::vector<Vec3> displacement = sample_field(body, task.mesh, found.u, midpoints);
  Response response;
  response.kernel_s = watch.seconds();

  json& report = response.report;
  report = {{"method", request.method},          {"outcome", found.converged ? "converged" : "not_converged"},
            {"identify_s", identified_s},        {"assembly_s", assembled_s - identified_s},
            {"solve_s", solved_s - assembled_s}, {"sample_s", response.kernel_s - solved_s},
            {"iterations", found.iterations},    {"residual_relative", found.residual_relative},
            {"indefinite", found.indefinite}};
  report_lattice(body, report);
  if (const std::string note = material_note(task.problem.material, wanted); !note.empty())
    response.notes.push_back(note);
  if (!found.converged) return response;
  const double energy_j = dynamics::elastic_energy(body.elastic, found.u);
  report["energy_j"] = energy_j;
  report["potential_j"] = energy_j + load_energy(loads, found.u, 1.0);
  report["support_forces_n"] = support_forces(body, task, found.u);
  if (!task.problem.held.empty()) report["held_error_m"] = worst_held_error(task, displacement);
  write_displacement(request.output, displacement);
  return response;
}

}  // namespace palpate::reference

#include "reference/fenicsx/motion/motion_answer.h"

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/mesh/subdivision/refinement.h"
#include "reference/door/request_options.h"
#include "reference/fenicsx/motion/frequencies.h"
#include "reference/fenicsx/motion/newmark.h"
#include "reference/fenicsx/statics/mpi_processes.h"

namespace palpate::reference::fenicsx {
namespace {

using nlohmann::json;

constexpr std::int64_t kMostRefinements = 3;

struct Options {
  NewmarkOptions newmark;
  std::int64_t refine = 0;
};

Options read_options(const Request& request) {
  if (request.method != "moving_fem.p1" && request.method != "moving_fem.p2")
    throw InputError("method", 0, "moving_fem.p1 or moving_fem.p2", request.method);
  json left = request.options;
  Options options;
  options.newmark.time_step_s = take_number(left, "time_step_s", 1e-9, 1e6, options.newmark.time_step_s);
  if (left.contains("solver"))
    options.newmark.solver = static_cast<SolverChoice>(take_choice(left, "solver", {"auto", "mumps", "cg"}));
  options.newmark.tolerance_relative =
      take_number(left, "rtol", 1e-14, 0.1, options.newmark.tolerance_relative);
  options.refine = take_whole(left, "refine", 0, kMostRefinements, 0);
  take_whole(left, "processes", 1, kMostProcesses, 1);  // main() has started as many
  require_all_taken(left);
  return options;
}

}  // namespace

Response answer_motion(const Request& request) {
  const Options options = read_options(request);
  const MotionTask task = read_motion_task(request);
  TetMesh mesh = task.mesh;
  MotionProblem problem = task.problem;
  for (std::int64_t level = 0; level < options.refine; ++level) {
    TetMesh refined = refine_uniformly(mesh);
    problem = refine_motion(problem, mesh, refined);
    mesh = std::move(refined);
  }
  if (problem.body.strain != StrainSize::kSmall)
    throw InputError("strain", 0, "small: finite elements move by linear elasticity", "large");
  Response response;
  Motion found;
  together([&] {
    const Stopwatch watch;
    ElasticBody body(mesh, problem.body.material, problem.body.strain,
                     request.method == "moving_fem.p1" ? 1 : 2);
    const double setup_s = watch.seconds();
    found = find_motion(mesh, problem, body, options.newmark);
    response.kernel_s = watch.seconds();
    response.report = {{"method", request.method},
                       {"outcome", found.outcome},
                       {"refine", options.refine},
                       {"processes", process_count()},
                       {"dofs", 3 * body.global_nodes()},
                       {"integrator", "newmark"},
                       {"time_step_s", found.time_step_s},
                       {"steps", found.steps},
                       {"solver", found.solver},
                       {"iterations", found.linear_iterations},
                       {"residual_relative", found.residual_relative},
                       {"damping_stiffness_s", problem.damping_stiffness_s},
                       {"damping_mass_per_s", problem.damping_mass_per_s},
                       {"identify_s", 0.0},
                       {"assembly_s", setup_s + found.assembly_s},
                       {"solve_s", found.solve_s}};
    if (problem.frequencies > 0) {
      const Stopwatch frequencies_watch;
      response.report["frequencies_hz"] = find_frequencies(mesh, problem, body, problem.frequencies);
      response.report["frequencies_s"] = frequencies_watch.seconds();
    }
  });
  if (found.outcome == "completed" && process_rank() == 0) {
    write_history(request.output, found.history);
    if (options.refine == 0) found.states.write_beside(request.output);
  }
  return response;
}

}  // namespace palpate::reference::fenicsx

// Adapter of the tensor-mass model.

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/elasticity/loads.h"
#include "reference/door/deform_problem.h"
#include "reference/door/request_options.h"
#include "reference/tensor_mass/relaxation.h"
#include "reference/tensor_mass/tensors.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

Response answer(const Request& request) {
  if (request.method != "tensor_mass") throw InputError("method", 0, "tensor_mass", request.method);
  json left = request.options;
  RelaxationOptions options;
  options.tolerance = take_number(left, "rtol", 1e-14, 0.1, options.tolerance);
  options.most_iterations = static_cast<std::size_t>(
      take_whole(left, "iterations", 1, 10'000'000, static_cast<std::int64_t>(options.most_iterations)));
  require_all_taken(left);
  const DeformTask task = read_deform_task(request);
  Response response;
  if (task.problem.strain == StrainSize::kLarge) {
    response.notes.emplace_back(
        "tensor_mass is linear: large strains and rotations are taken for small ones");
  }

  const Stopwatch watch;
  const dynamics::Loads loads = dynamics::build_loads(task.mesh, task.problem);
  dynamics::require_no_rigid_motion(task.mesh, loads);
  const TensorMass elastic = build_tensor_mass(task.mesh, task.problem.material);
  TensorMass supported = elastic;
  add_supports(loads.supports, supported);
  const double assembly_s = watch.seconds();
  const Relaxation found = relax(supported, loads, options);
  response.kernel_s = watch.seconds();

  const double energy_j = elastic_energy(elastic, found.displacement_m);
  response.report = {{"method", request.method},
                     {"outcome", found.converged ? "converged" : "not_converged"},
                     {"energy_j", energy_j},
                     {"potential_j", energy_j + load_energy(loads, found.displacement_m, 1.0)},
                     {"assembly_s", assembly_s},
                     {"solve_s", response.kernel_s - assembly_s},
                     {"iterations", found.iterations},
                     {"residual_relative", found.residual_relative},
                     {"tensors", elastic.vertex.size() + elastic.edge.size()}};
  if (found.converged) write_displacement(request.output, found.displacement_m);
  return response;
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}

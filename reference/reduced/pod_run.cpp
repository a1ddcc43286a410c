#include "reference/reduced/pod_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/dynamics/pod/pod_body.h"
#include "core/dynamics/pod/training_loads.h"
#include "core/dynamics/statics/static_equilibrium.h"
#include "reference/door/deform_problem.h"
#include "reference/door/request_options.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

struct PodRunOptions {
  std::size_t training = 16;
  std::size_t validation = 4;
  std::size_t modes = 24;
  double basis_tolerance = 1e-4;
  double force_tolerance = 1e-2;
  std::uint64_t seed = 1;
  dynamics::BlendOptions model;
  bool all_domains = false;
  bool check = false;
};

PodRunOptions take_pod_options(const Request& request) {
  if (request.method != "reduced.pod") throw InputError("method", 0, "reduced.pod", request.method);
  json left = request.options;
  PodRunOptions out;
  const auto count = [&](const char* key, long long least, long long most, std::size_t fallback) {
    return static_cast<std::size_t>(take_whole(left, key, least, most, static_cast<long long>(fallback)));
  };
  out.training = count("training", 1, 1000, out.training);
  out.validation = count("validation", 0, 100, out.validation);
  out.modes = count("modes", 1, 1000, out.modes);
  out.basis_tolerance = take_number(left, "basis_tolerance", 0.0, 1.0, out.basis_tolerance);
  out.force_tolerance = take_number(left, "force_tolerance", 1e-12, 1.0, out.force_tolerance);
  out.seed = count("seed", 0, 1'000'000, 1);
  out.model.strain = StrainSize::kLarge;
  if (take_choice(left, "model", {"edge_node", "tets"}) == 0) {
    out.model.theta = 0.0;
    out.model.rest = dynamics::StrainDomain::kEdge;
  } else {
    out.model.theta = 1.0;
    out.model.domain = dynamics::StrainDomain::kTet;
  }
  out.all_domains = take_option<bool>(left, "all_domains", &json::is_boolean, "true or false", false);
  out.check = take_option<bool>(left, "check", &json::is_boolean, "true or false", false);
  require_all_taken(left);
  return out;
}

/// |a - b| / |b|.
double distance_of(std::span<const Vec3> a, std::span<const Vec3> b) {
  double off = 0.0;
  double size = 0.0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    off += length_sq(a[v] - b[v]);
    size += length_sq(b[v]);
  }
  return size > 0.0 ? std::sqrt(off / size) : 0.0;
}

/// The full model at rest under drawn loads.
class FullBody {
 public:
  FullBody(const DeformTask& task, const dynamics::ElasticModel& model, int threads)
      : task_(task), model_(model) {
    options_.linear.threads = threads;
  }

  /// Empty where no equilibrium was found.
  std::vector<Vec3> solve(const dynamics::Loads& loads) const {
    dynamics::StaticSolution found = dynamics::solve_static(task_.mesh, model_, loads, options_);
    if (found.report.outcome != dynamics::StaticOutcome::kConverged) return {};
    return std::move(found.displacement_m);
  }

 private:
  const DeformTask& task_;
  const dynamics::ElasticModel& model_;
  dynamics::StaticOptions options_;
};

/// Loads with the full model's answers to them; those that it had none for are left out.
struct Solved {
  std::vector<dynamics::Loads> loads;
  std::vector<std::vector<Vec3>> displacements_m;
};

Solved solve_drawn(const DeformTask& task, const FullBody& body, std::size_t count, SplitMix64& random) {
  Solved out;
  for (std::size_t k = 0; k < count; ++k) {
    dynamics::Loads loads =
        dynamics::build_loads(task.mesh, dynamics::draw_training_load(task.problem, random));
    std::vector<Vec3> u = body.solve(loads);
    if (u.empty()) continue;
    out.loads.push_back(std::move(loads));
    out.displacements_m.push_back(std::move(u));
  }
  return out;
}

/// The largest error of the reduced body over loads that it was not made of; null without any.
json measure_validation(const dynamics::PodBody& body, const Solved& held_back) {
  if (held_back.loads.empty()) return nullptr;
  double worst = 0.0;
  for (std::size_t k = 0; k < held_back.loads.size(); ++k) {
    const dynamics::PodAnswer answer = body.solve(held_back.loads[k], {});
    if (!answer.converged) return nullptr;
    worst =
        std::max(worst, distance_of(displacement_of(body.basis(), answer.q), held_back.displacements_m[k]));
  }
  return worst;
}

}  // namespace

Response run_pod(const Request& request) {
  const PodRunOptions options = take_pod_options(request);
  const DeformTask task = read_deform_task(request);
  if (task.problem.strain == StrainSize::kSmall)
    throw InputError("strain", 0, "large: reduced.compliance and reduced.modal are for small strain",
                     "small");
  const Stopwatch kernel;
  const dynamics::Loads asked = dynamics::build_loads(task.mesh, task.problem);
  dynamics::require_no_rigid_motion(task.mesh, asked);
  const dynamics::BuiltModel built =
      dynamics::build_blend_model(task.mesh, task.problem.material, options.model);
  const FullBody full(task, built.model, request.threads);
  SplitMix64 random(options.seed);
  const Solved training = solve_drawn(task, full, options.training, random);
  const Solved held_back = solve_drawn(task, full, options.validation, random);
  const double snapshots_s = kernel.seconds();
  if (training.loads.empty()) throw UnavailableError("the full model came to rest under no training load");
  dynamics::SnapshotBasis basis =
      dynamics::find_snapshot_basis(training.displacements_m, options.modes, options.basis_tolerance);
  const auto shapes = static_cast<std::size_t>(basis.shapes.cols());
  const dynamics::Cubature cubature =
      options.all_domains
          ? dynamics::take_all_domains(built.model)
          : dynamics::fit_cubature(built.model, basis, training.displacements_m, options.force_tolerance);
  const dynamics::PodBody body(built.model, std::move(basis), cubature, asked);
  const double set_up_s = kernel.seconds();
  const dynamics::PodAnswer answer = body.solve(asked, {});
  const double answered_s = kernel.seconds();
  const std::vector<Vec3> u = displacement_of(body.basis(), answer.q);

  Response response;
  response.kernel_s = kernel.seconds();
  response.report = {{"method", request.method},
                     {"outcome", answer.converged ? "converged" : "not_converged"},
                     {"identify_s", set_up_s},
                     {"snapshots_s", snapshots_s},
                     {"solve_s", answered_s - set_up_s},
                     {"react_s", answered_s - set_up_s},
                     {"move_inside_s", response.kernel_s - answered_s},
                     {"iterations", answer.iterations},
                     {"residual_relative", answer.residual_relative},
                     {"training_loads", training.loads.size()},
                     {"validation_loads", held_back.loads.size()},
                     {"modes", shapes},
                     {"domains", body.domains()},
                     {"domains_of_all", take_all_domains(built.model).domains.size()},
                     {"force_residual", cubature.residual_relative},
                     {"validation_error", measure_validation(body, held_back)},
                     {"table_bytes", body.bytes()}};
  if (options.check) {
    const std::vector<Vec3> wanted = full.solve(asked);
    response.report["test_error"] = wanted.empty() ? json(nullptr) : json(distance_of(u, wanted));
  }
  if (answer.converged) write_displacement(request.output, u);
  return response;
}

}  // namespace palpate::reference

#include "reference/reduced/pod_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/dynamics/pod/pod_body.h"
#include "core/dynamics/pod/training_loads.h"
#include "core/dynamics/reduced/compliance_table.h"
#include "core/dynamics/statics/static_equilibrium.h"
#include "reference/door/deform_problem.h"
#include "reference/door/request_options.h"
#include "reference/reduced/pod_file.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

struct PodRunOptions {
  PodTraining training;
  bool check = false;
  std::string read;    ///< a trained body to answer from instead of training one
  bool write = false;  ///< beside the displacement
};

/// The model that is reduced.
dynamics::BlendOptions model_options(const PodTraining& training) {
  dynamics::BlendOptions out;
  out.strain = StrainSize::kLarge;
  if (training.model == "edge_node") {
    out.theta = 0.0;
    out.rest = dynamics::StrainDomain::kEdge;
  } else {
    out.theta = 1.0;
    out.domain = dynamics::StrainDomain::kTet;
  }
  return out;
}

PodRunOptions take_pod_options(const Request& request) {
  if (request.method != "reduced.pod") throw InputError("method", 0, "reduced.pod", request.method);
  json left = request.options;
  PodRunOptions out;
  const auto count = [&](const char* key, long long least, long long most, std::size_t fallback) {
    return static_cast<std::size_t>(take_whole(left, key, least, most, static_cast<long long>(fallback)));
  };
  PodTraining& asked = out.training;
  asked.training = count("training", 1, 1000, asked.training);
  asked.validation = count("validation", 0, 100, asked.validation);
  asked.modes = count("modes", 1, 1000, asked.modes);
  asked.basis_tolerance = take_number(left, "basis_tolerance", 0.0, 1.0, asked.basis_tolerance);
  asked.force_tolerance = take_number(left, "force_tolerance", 1e-12, 1.0, asked.force_tolerance);
  asked.seed = count("seed", 0, 1'000'000, 1);
  asked.model = take_choice(left, "model", {"edge_node", "tets"}) == 0 ? "edge_node" : "tets";
  asked.all_domains = take_option<bool>(left, "all_domains", &json::is_boolean, "true or false", false);
  out.check = take_option<bool>(left, "check", &json::is_boolean, "true or false", false);
  out.read = take_option<std::string>(left, "body", &json::is_string, "the path of a trained body", "");
  out.write = take_option<bool>(left, "write_body", &json::is_boolean, "true or false", false);
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

/// The largest error of the reduced body over loads that it was not made of; nothing without any, or where it
/// finds no equilibrium.
std::optional<double> measure_validation(const dynamics::PodBody& body, const Solved& held_back) {
  if (held_back.loads.empty()) return {};
  double worst = 0.0;
  for (std::size_t k = 0; k < held_back.loads.size(); ++k) {
    const dynamics::PodAnswer answer = body.solve(held_back.loads[k], {});
    if (!answer.converged) return {};
    worst =
        std::max(worst, distance_of(displacement_of(body.basis(), answer.q), held_back.displacements_m[k]));
  }
  return worst;
}

/// Draws the loads, solves the full model under them and makes the body, with what that took in the report.
/// `held_back` gets the loads to try it on.
TrainedPod train(const DeformTask& task, const PodTraining& asked, const dynamics::Loads& loads, int threads,
                 Solved& held_back, json& report) {
  const Stopwatch start;
  const dynamics::BuiltModel built =
      dynamics::build_blend_model(task.mesh, task.problem.material, model_options(asked));
  const FullBody full(task, built.model, threads);
  SplitMix64 random(asked.seed);
  const Solved training = solve_drawn(task, full, asked.training, random);
  held_back = solve_drawn(task, full, asked.validation, random);
  report["snapshots_s"] = start.seconds();
  if (training.loads.empty()) throw UnavailableError("the full model came to rest under no training load");
  dynamics::SnapshotBasis basis =
      dynamics::find_snapshot_basis(training.displacements_m, asked.modes, asked.basis_tolerance);
  const dynamics::Cubature cubature =
      asked.all_domains
          ? dynamics::take_all_domains(built.model)
          : dynamics::fit_cubature(built.model, basis, training.displacements_m, asked.force_tolerance);
  TrainedPod out;
  out.body = dynamics::hash_body(task.mesh);
  out.places = dynamics::hash_load_places(task.problem);
  out.young_modulus_pa = task.problem.material.young_modulus_pa;
  out.poisson_ratio = task.problem.material.poisson_ratio;
  out.asked = asked;
  out.training_loads = training.loads.size();
  out.validation_loads = held_back.loads.size();
  out.domains_of_all = take_all_domains(built.model).domains.size();
  out.force_residual = cubature.residual_relative;
  out.parts = dynamics::collect_pod_parts(built.model, std::move(basis), cubature, loads);
  out.trained_force = dynamics::reduce_loads(out.parts.basis, loads);
  out.training_s = start.seconds();
  return out;
}

/// A body that was trained before, for this request.
TrainedPod read_for(const DeformTask& task, const PodRunOptions& options, json& report) {
  const Stopwatch start;
  TrainedPod out = read_pod(options.read);
  require_pod_fits(out, task.mesh, task.problem, options.training, options.read);
  report["read_s"] = start.seconds();
  return out;
}

json report_training(const TrainedPod& trained) {
  return {{"training_s", trained.training_s},
          {"training_loads", trained.training_loads},
          {"validation_loads", trained.validation_loads},
          {"modes", trained.parts.basis.shapes.cols()},
          {"domains", trained.parts.domains.size()},
          {"domains_of_all", trained.domains_of_all},
          {"force_residual", trained.force_residual},
          {"validation_error", trained.validation_error ? json(*trained.validation_error) : json(nullptr)}};
}

/// The full model's distance from the answer, outside the kernel; null where it found no equilibrium.
json measure_test(const DeformTask& task, const PodTraining& asked, const dynamics::Loads& loads, int threads,
                  std::span<const Vec3> u) {
  const dynamics::BuiltModel built =
      dynamics::build_blend_model(task.mesh, task.problem.material, model_options(asked));
  const std::vector<Vec3> wanted = FullBody(task, built.model, threads).solve(loads);
  return wanted.empty() ? json(nullptr) : json(distance_of(u, wanted));
}

}  // namespace

Response run_pod(const Request& request) {
  const PodRunOptions options = take_pod_options(request);
  const DeformTask task = read_deform_task(request);
  if (task.problem.strain == StrainSize::kSmall)
    throw InputError("strain", 0, "large: reduced.compliance and reduced.modal are for small strain",
                     "small");
  Response response;
  response.report = {{"method", request.method}};
  json& report = response.report;
  const Stopwatch kernel;
  const dynamics::Loads asked = dynamics::build_loads(task.mesh, task.problem);
  dynamics::require_no_rigid_motion(task.mesh, asked);
  const bool is_read = !options.read.empty();
  Solved held_back;
  TrainedPod trained = is_read ? read_for(task, options, report)
                               : train(task, options.training, asked, request.threads, held_back, report);
  const dynamics::PodBody body(trained.parts);
  const double set_up_s = kernel.seconds();
  const dynamics::PodAnswer answer = body.solve(asked, {});
  const double answered_s = kernel.seconds();
  const std::vector<Vec3> u = displacement_of(body.basis(), answer.q);
  response.kernel_s = kernel.seconds();

  if (!is_read) trained.validation_error = measure_validation(body, held_back);
  report.update(report_training(trained));
  report["outcome"] = answer.converged ? "converged" : "not_converged";
  report["identify_s"] = is_read ? 0.0 : set_up_s;
  report["solve_s"] = answered_s - set_up_s;
  report["react_s"] = answered_s - set_up_s;
  report["move_inside_s"] = response.kernel_s - answered_s;
  report["iterations"] = answer.iterations;
  report["residual_relative"] = answer.residual_relative;
  report["table_bytes"] = body.bytes();
  const double trained_size = trained.trained_force.norm();
  if (trained_size > 0.0)
    report["load_share"] = dynamics::reduce_loads(body.basis(), asked).norm() / trained_size;
  if (options.check) report["test_error"] = measure_test(task, options.training, asked, request.threads, u);
  if (options.write) {
    const std::filesystem::path path = request.output.string() + ".pod";
    write_pod(path, trained);
    report["body_file"] = path.string();
    report["body_format"] = "palpate/pod_body/1";
  }
  if (answer.converged) write_displacement(request.output, u);
  return response;
}

}  // namespace palpate::reference

#include "reference/springs/model_run.h"

#include <array>
#include <chrono>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/dynamics/calibration.h"
#include "core/dynamics/static_equilibrium.h"
#include "core/dynamics/volume_models.h"
#include "core/springs/identify.h"
#include "core/springs/moduli_csv.h"
#include "core/springs/springs_csv.h"
#include "reference/deform_problem.h"
#include "reference/fusion_options.h"

namespace palpate::reference {
namespace {

using dynamics::BuiltModel;
using nlohmann::json;

class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// What a method's springs come from, and what is added to them.
struct SpringRequest {
  std::optional<springs::SpringMethod> method;  ///< nothing: from a file
  std::string file;
  std::string moduli_file;  ///< beside `file`; empty: none
  springs::IdentifyOptions identify;
  bool calibrate = false;
  dynamics::SpringModelOptions model;
};

bool take_bool(json& options, const char* key, bool fallback) {
  return take_option<bool>(options, key, &json::is_boolean, "true or false", fallback);
}

dynamics::StrainLaw take_law(json& options, dynamics::StrainLaw fallback) {
  const std::string name =
      take_option<std::string>(options, "law", &json::is_string, "corotated or neo_hookean", "default");
  return name == "default" ? fallback : dynamics::parse_strain_law(name);
}

dynamics::StrainDomain take_domain(json& options, const char* key, dynamics::StrainDomain fallback) {
  return dynamics::parse_strain_domain(take_option<std::string>(
      options, key, &json::is_string, "tet, face, edge or node", dynamics::strain_domain_name(fallback)));
}

SpringRequest take_spring_request(const std::string& method, StrainSize strain, json& options) {
  SpringRequest out;
  const std::string name = method.substr(std::string("springs.").size());
  constexpr double kHuge = std::numeric_limits<double>::max();
  if (name == "trained") {
    out.file =
        take_option<std::string>(options, "springs", &json::is_string, "the path of a springs CSV", "");
    if (out.file.empty()) throw InputError("springs", 0, "the path of a springs CSV", "none");
    out.moduli_file =
        take_option<std::string>(options, "moduli", &json::is_string, "the path of a moduli CSV", "");
  } else {
    out.method = springs::parse_spring_method(name);
    out.identify.face_opposite = take_bool(options, "face_opposite", false);
    out.calibrate = take_bool(options, "calibrate", false);
    if (*out.method == springs::SpringMethod::kUniform) {
      const double stiffness = take_number(options, "stiffness_n_per_m", 0.0, kHuge, 0.0);
      if (stiffness > 0.0) out.identify.uniform_stiffness_n_per_m = stiffness;
    }
    if (*out.method == springs::SpringMethod::kThesisPrinted ||
        *out.method == springs::SpringMethod::kThesisCorrected)
      out.identify.stiffness_row_weight = take_number(options, "row_weight", 0.0, kHuge, 1.0);
    if (*out.method == springs::SpringMethod::kIsotropyPatch)
      out.identify.patch_length = take_number(options, "patch_length", 0.0, kHuge, 1.0);
  }
  out.model.strain = strain;
  out.model.volume = dynamics::parse_volume_model(
      take_option<std::string>(options, "volume", &json::is_string, "a volume model", "none"));
  out.model.theta = take_number(options, "theta", 0.0, 1.0, out.model.theta);
  out.model.shear = take_domain(options, "shear", out.model.shear);
  out.model.volume_force_ratio = take_number(options, "volume_force_ratio", 0.0, kHuge, 1.0);
  out.model.large_law = take_law(options, out.model.large_law);
  if (!out.moduli_file.empty() && out.model.volume != dynamics::VolumeModel::kNone)
    throw InputError("moduli", 0, "volume=none beside trained moduli: they are the volume model",
                     dynamics::volume_model_name(out.model.volume));
  return out;
}

dynamics::BlendOptions take_blend(const std::string& method, StrainSize strain, json& options) {
  dynamics::BlendOptions blend;
  blend.strain = strain;
  if (method == "smoothed.edge_node") {
    blend.theta = 0.0;
    blend.rest = dynamics::StrainDomain::kEdge;
  } else if (method != "smoothed.blend") {
    throw InputError("method", 0, "springs.NAME, smoothed.blend or smoothed.edge_node", method);
  }
  blend.theta = take_number(options, "theta", 0.0, 1.0, blend.theta);
  blend.domain = take_domain(options, "domain", blend.domain);
  blend.rest = take_domain(options, "rest", blend.rest);
  blend.large_law = take_law(options, blend.large_law);
  return blend;
}

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

/// Adds the energy 1/2 m V (tr eps)^2 of each vertex or tet, with the moduli m of a file.
void add_trained_dilatation(const TetMesh& mesh, const std::string& file,
                            const dynamics::SpringModelOptions& options, dynamics::ElasticModel& model) {
  const springs::DilatationModuli moduli = springs::read_moduli_csv(file, mesh);
  const auto domain = moduli.at_vertices ? dynamics::StrainDomain::kNode : dynamics::StrainDomain::kTet;
  dynamics::StrainTerm term{dynamics::build_strain_operator(mesh, domain), {1.0, 0.0}, options.large_law};
  if (options.strain == StrainSize::kSmall) term.law = dynamics::StrainLaw::kLinear;
  // The laws are linear in their moduli, so a domain's modulus can stand in its volume.
  for (std::size_t s = 0; s < term.op.domains(); ++s) term.op.volume_m3[s] *= moduli.modulus_pa[s];
  model.strain_terms.push_back(std::move(term));
}

/// Identified or read springs with their figures in the report, and their volume model.
BuiltModel build_springs(const DeformTask& task, const SpringRequest& wanted, Response& response) {
  const Material& material = task.problem.material;
  const Stopwatch identify_watch;
  SpringNetwork net;
  if (wanted.method) {
    springs::IdentifyReport report;
    const Material fitted = dynamics::spring_material(material, wanted.model.volume);
    net = springs::identify_springs(task.mesh, fitted, *wanted.method, wanted.identify, report);
    response.report["zero_springs"] = report.zero_springs;
    response.report["kkt_relative"] = report.kkt_relative;
    response.report["identify_iterations"] = report.iterations;
    response.report["stiffness_ratio_mean"] = report.stiffness_ratio_mean;
    response.report["degenerate_vertices"] = report.degenerate_vertices.size();
    response.notes.insert(response.notes.end(), report.warnings.begin(), report.warnings.end());
    if (wanted.calibrate) {
      dynamics::ElasticModel model{task.mesh.points, net, true, {}, {}};
      const dynamics::MeasuredModuli moduli = dynamics::measure_moduli(task.mesh, model, {});
      const double factor = dynamics::calibration_factor(moduli, fitted.young_modulus_pa / 2.5);
      for (double& stiffness : net.stiffness_n_per_m) stiffness *= factor;
      response.report["calibration_factor"] = factor;
    }
  } else {
    net = springs::read_springs_csv(wanted.file, task.mesh);
  }
  response.report["springs"] = net.springs.size();
  response.report["identify_s"] = identify_watch.seconds();
  BuiltModel built = dynamics::build_spring_model(task.mesh, std::move(net), material, wanted.model);
  if (!wanted.moduli_file.empty())
    add_trained_dilatation(task.mesh, wanted.moduli_file, wanted.model, built.model);
  return built;
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
  const bool has_springs = request.method.starts_with("springs.");
  SpringRequest wanted;
  dynamics::BlendOptions blend;
  if (has_springs) {
    wanted = take_spring_request(request.method, strain, left);
  } else {
    blend = take_blend(request.method, strain, left);
  }
  const dynamics::StaticOptions options = take_static_options(strain, request.threads, left);
  require_all_taken(left);

  Response response;
  response.report = {{"method", request.method}, {"vertices", task.mesh.points.size()}, {"identify_s", 0.0}};
  const Stopwatch kernel;
  const dynamics::Loads loads = dynamics::build_loads(task.mesh, task.problem);
  dynamics::require_no_rigid_motion(task.mesh, loads);
  const Stopwatch building;
  const BuiltModel built = has_springs ? build_springs(task, wanted, response)
                                       : dynamics::build_blend_model(task.mesh, task.problem.material, blend);
  response.report["assembly_s"] = building.seconds() - response.report["identify_s"].get<double>();
  const Stopwatch solving;
  const dynamics::StaticSolution solution = dynamics::solve_static(task.mesh, built.model, loads, options);
  response.report["solve_s"] = solving.seconds();
  response.kernel_s = kernel.seconds();

  response.notes.insert(response.notes.end(), built.warnings.begin(), built.warnings.end());
  response.report["theta"] = built.theta;
  report_solution(solution.report, response);
  if (solution.report.outcome == dynamics::StaticOutcome::kConverged)
    write_displacement(request.output, solution.displacement_m);
  return response;
}

}  // namespace palpate::reference

#include "reference/elastic_models/model_request.h"

#include <chrono>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "core/base/error.h"
#include "core/dynamics/motion/frozen_part.h"
#include "core/dynamics/statics/calibration.h"
#include "core/springs/identification/identify_options.h"
#include "core/springs/network/moduli_csv.h"
#include "core/springs/network/springs_csv.h"
#include "reference/door/json_file.h"
#include "reference/door/request_options.h"

namespace palpate::reference {
namespace {

constexpr double kLeastConstant = 1e-12;  ///< N/m; a spring of less is a mistake

using dynamics::BuiltModel;
using nlohmann::json;

bool take_bool(json& options, const char* key, bool fallback) {
  return take_option<bool>(options, key, &json::is_boolean, "true or false", fallback);
}

dynamics::StrainLaw take_law(json& options, dynamics::StrainLaw fallback) {
  const std::string name = take_option<std::string>(
      options, "law", &json::is_string, "corotated, neo_hookean or stable_neo_hookean", "default");
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
    if (options.contains("mean_n_per_m"))
      out.mean_n_per_m = take_number(options, "mean_n_per_m", kLeastConstant, kHuge, 0.0);
    if (out.calibrate && out.mean_n_per_m)
      throw InputError("mean_n_per_m", 0, "calibrate or mean_n_per_m, not both", "both");
    if (*out.method == springs::SpringMethod::kUniform) {
      if (options.contains("stiffness_n_per_m"))
        out.identify.uniform_stiffness_n_per_m =
            take_number(options, "stiffness_n_per_m", kLeastConstant, kHuge, 0.0);
    }
    if (*out.method == springs::SpringMethod::kThesisPrinted ||
        *out.method == springs::SpringMethod::kThesisCorrected)
      out.identify.stiffness_row_weight = take_number(options, "row_weight", 0.0, kHuge, 1.0);
    if (*out.method == springs::SpringMethod::kThesisPrinted)
      out.identify.printed_rows = springs::parse_thesis_rows(
          take_option<std::string>(options, "rows", &json::is_string, "a reading of appendix B", "letter"),
          "rows");
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
  blend.stabilise = take_number(options, "stabilise", 0.0, 1.0, 0.0);
  blend.large_law = take_law(options, blend.large_law);
  return blend;
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

/// All springs times one factor, so that their mean is `mean_n_per_m`.
void scale_to_mean(double mean_n_per_m, SpringNetwork& net) {
  std::vector<double>& stiffness = net.stiffness_n_per_m;
  const double sum = std::accumulate(stiffness.begin(), stiffness.end(), 0.0);
  if (!(sum > 0.0)) throw InputError("mean_n_per_m", 0, "springs with a stiffness", "none");
  const double factor = mean_n_per_m * static_cast<double>(stiffness.size()) / sum;
  for (double& k : stiffness) k *= factor;
}

/// Identified or read springs with their figures in the report, and their volume model.
BuiltModel build_springs(const TetMesh& mesh, const Material& material, const SpringRequest& wanted,
                         Response& response) {
  const auto start = std::chrono::steady_clock::now();
  SpringNetwork net;
  if (wanted.method) {
    const springs::IdentifyOptions& identify = wanted.identify;
    springs::IdentifyReport report;
    const Material fitted = dynamics::spring_material(material, wanted.model.volume);
    net = springs::identify_springs(mesh, fitted, *wanted.method, identify, report);
    response.report["zero_springs"] = report.zero_springs;
    response.report["kkt_relative"] = report.kkt_relative;
    response.report["identify_iterations"] = report.iterations;
    response.report["stiffness_ratio_mean"] = report.stiffness_ratio_mean;
    response.report["degenerate_vertices"] = report.degenerate_vertices.size();
    response.notes.insert(response.notes.end(), report.warnings.begin(), report.warnings.end());
    if (wanted.calibrate) {
      dynamics::ElasticModel model{mesh.points, net, true, {}, {}};
      const dynamics::MeasuredModuli moduli = dynamics::measure_moduli(mesh, model, {});
      const double factor = dynamics::calibration_factor(moduli, fitted.young_modulus_pa / 2.5);
      for (double& stiffness : net.stiffness_n_per_m) stiffness *= factor;
      response.report["calibration_factor"] = factor;
    }
    if (wanted.mean_n_per_m) scale_to_mean(*wanted.mean_n_per_m, net);
  } else {
    net = springs::read_springs_csv(wanted.file, mesh);
  }
  response.report["springs"] = net.springs.size();
  response.report["identify_s"] =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  BuiltModel built = dynamics::build_spring_model(mesh, std::move(net), material, wanted.model);
  if (!wanted.moduli_file.empty())
    add_trained_dilatation(mesh, wanted.moduli_file, wanted.model, built.model);
  return built;
}

}  // namespace

ModelRequest take_model_request(const std::string& method, StrainSize strain, json& options) {
  const auto frozen = take_option<std::string>(options, "frozen", &json::is_string,
                                               "the path of a file of frozen vertices", "");
  if (method.starts_with("springs.")) return {take_spring_request(method, strain, options), {}, frozen};
  return {std::nullopt, take_blend(method, strain, options), frozen};
}

std::vector<Index> read_frozen(const ModelRequest& wanted, const TetMesh& mesh) {
  std::vector<Index> frozen;
  if (wanted.frozen_file.empty()) return frozen;
  const json root = read_json_file(wanted.frozen_file);
  const auto fail = [&](const std::string& expected, const json& found) {
    throw InputError(wanted.frozen_file, 0, expected, found.dump().substr(0, 80));
  };
  if (!root.is_object() || root.value("schema", json()) != "palpate/frozen/1") fail("palpate/frozen/1", root);
  const json& of = root.value("of_vertices", json());
  if (of != mesh.points.size())
    fail("a mesh of " + std::to_string(mesh.points.size()) + " vertices, which this one is", of);
  const json vertices = root.value("vertices", json());
  if (!vertices.is_array()) fail("a list of vertices", vertices);
  frozen.reserve(vertices.size());
  for (const json& vertex : vertices) {
    if (!vertex.is_number_unsigned() || vertex.get<std::uint64_t>() >= mesh.points.size())
      fail("a vertex of the mesh", vertex);
    frozen.push_back(vertex.get<Index>());
  }
  return frozen;
}

BuiltModel build_requested_model(const TetMesh& mesh, const Material& material, const ModelRequest& wanted,
                                 Response& response) {
  response.report["identify_s"] = 0.0;
  BuiltModel built = wanted.springs ? build_springs(mesh, material, *wanted.springs, response)
                                    : dynamics::build_blend_model(mesh, material, wanted.blend);
  response.notes.insert(response.notes.end(), built.warnings.begin(), built.warnings.end());
  const dynamics::FrozenCount dropped = drop_frozen(read_frozen(wanted, mesh), built.model);
  if (!wanted.frozen_file.empty()) {
    response.report["frozen_springs"] = dropped.springs;
    response.report["frozen_domains"] = dropped.domains;
  }
  return built;
}

}  // namespace palpate::reference

#include "reference/springs/identify_run.h"

#include "core/base/stopwatch.h"
#include "core/dynamics/statics/calibration.h"
#include "core/mesh/io/medit.h"
#include "core/springs/identification/identify.h"
#include "core/springs/network/springs_csv.h"
#include "reference/door/json_file.h"

namespace palpate::reference {

Material material_of(const Request& request) {
  const nlohmann::json& material = request.options.at("material");
  return {material.at("young_modulus_pa").get<double>(), material.at("poisson_ratio").get<double>(),
          material.at("density_kg_m3").get<double>()};
}

double calibrate_springs(const TetMesh& mesh, double mu_pa, SpringNetwork& network) {
  const dynamics::ElasticModel model{mesh.points, network, true, {}, {}};
  const double factor = dynamics::calibration_factor(dynamics::measure_moduli(mesh, model, {}), mu_pa);
  for (double& stiffness : network.stiffness_n_per_m) stiffness *= factor;
  return factor;
}

Response run_identification(const Request& request) {
  const springs::SpringMethod method = springs::parse_spring_method(request.method);
  springs::IdentifyOptions options;
  for (const auto& [name, text] : request.options.at("set").items())
    springs::set_spring_option(method, name, text.get<std::string>(), "set", options);
  const Material material = material_of(request);
  const TetMesh mesh = read_medit(request.input, ReadOrientation::kKeep).mesh;
  Response response;
  springs::IdentifyReport report;
  const Stopwatch kernel;
  SpringNetwork network = springs::identify_springs(mesh, material, method, options, report);
  if (request.options.at("calibrate").get<bool>())
    response.report["calibration_factor"] = calibrate_springs(mesh, material.young_modulus_pa / 2.5, network);
  response.kernel_s = kernel.seconds();
  springs::write_springs_csv(request.output, network);
  response.report.update({{"zero_springs", report.zero_springs},
                          {"kkt_relative", number_or_null(report.kkt_relative)},
                          {"iterations", report.iterations},
                          {"converged", report.converged},
                          {"stiffness_ratio_mean", number_or_null(report.stiffness_ratio_mean)},
                          {"degenerate_vertices", report.degenerate_vertices},
                          {"hanging_vertices", report.hanging_vertices}});
  response.notes = report.warnings;
  return response;
}

}  // namespace palpate::reference

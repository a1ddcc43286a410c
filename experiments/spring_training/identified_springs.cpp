#include "experiments/spring_training/identified_springs.h"

#include <limits>

#include "core/mesh/io/medit.h"
#include "core/springs/network/springs_csv.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/meshes/mesh_tools.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// A number, which JSON has as null if it is not finite.
double number_of(const json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

springs::IdentifyReport read_report(const json& response, springs::SpringMethod method) {
  const json& figures = response.at("report");
  springs::IdentifyReport report;
  report.method = method;
  report.zero_springs = figures.at("zero_springs").get<std::size_t>();
  report.kkt_relative = number_of(figures.at("kkt_relative"));
  report.iterations = figures.at("iterations").get<std::size_t>();
  report.converged = figures.at("converged").get<bool>();
  report.stiffness_ratio_mean = number_of(figures.at("stiffness_ratio_mean"));
  report.degenerate_vertices = figures.at("degenerate_vertices").get<std::vector<Index>>();
  report.hanging_vertices = figures.at("hanging_vertices").get<std::vector<Index>>();
  report.warnings = response.at("notes").get<std::vector<std::string>>();
  return report;
}

}  // namespace

json material_to_json(const Material& material) {
  return {{"young_modulus_pa", material.young_modulus_pa},
          {"poisson_ratio", material.poisson_ratio},
          {"density_kg_m3", material.density_kg_m3}};
}

IdentifiedSprings obtain_springs(const TetMesh& mesh, const SpringWish& wish) {
  const ScratchFolder scratch;
  ToolCall call{"springs", springs::spring_method_name(wish.method), scratch.file("in.mesh"),
                scratch.file("springs.csv")};
  write_medit(call.input, mesh);
  call.options = {
      {"material", material_to_json(wish.material)}, {"set", json(wish.set)}, {"calibrate", wish.calibrate}};
  call.timeout_s = kAnyLongTime;
  const json response = run_tool(kSpringsTool, call);
  return {springs::read_springs_csv(call.output, mesh), read_report(response, wish.method),
          response.at("report").value("calibration_factor", 1.0), response.at("kernel_s").get<double>()};
}

}  // namespace palpate::experiments

// A contestant for the tests of the contest deform: a real process that answers with a linear field, scaled
// by the modulus and the Poisson ratio that it read, or misbehaves as it is told.
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/topology.h"
#include "reference/door/adapter.h"
#include "reference/door/deform_problem.h"
#include "reference/door/json_file.h"

namespace {

using namespace palpate;
using reference::DeformTask;
using reference::Request;
using reference::Response;

std::vector<Vec3> linear_field(const DeformTask& task, double factor, bool midpoints) {
  std::vector<Vec3> points = task.mesh.points;
  if (midpoints) {
    for (const Edge& e : build_edges(task.mesh))
      points.push_back(0.5 * (task.mesh.points[e[0]] + task.mesh.points[e[1]]));
  }
  const double size = factor * (1.0 + task.problem.material.poisson_ratio);
  std::vector<Vec3> field;
  field.reserve(points.size());
  for (const Vec3& p : points)
    field.push_back(size * Vec3{0.1 * p.x + 0.02 * p.z, -0.03 * p.y, 0.05 * p.x + 0.001});
  return field;
}

/// The pull of each support, exact for a field that is linear on each face.
nlohmann::json support_forces(const DeformTask& task, const std::vector<Vec3>& field) {
  nlohmann::json forces = nlohmann::json::array();
  for (const ElasticSupport& support : task.problem.supports) {
    Vec3 sum;
    for (std::size_t k = 0; k < support.patch.faces.size(); ++k) {
      const auto [a, b, c] = support.patch.faces[k];
      const std::vector<Vec3>& p = task.mesh.points;
      const double area = 0.5 * length(cross(p[b] - p[a], p[c] - p[a]));
      sum = sum + (support.stiffness_pa_per_m * support.patch.weight[k] * area) *
                      (support.by_m - (1.0 / 3.0) * (field[a] + field[b] + field[c]));
    }
    forces.push_back({sum.x, sum.y, sum.z});
  }
  return forces;
}

Response answer(const Request& request) {
  const std::string behave = request.options.value("behave", "field");
  if (behave == "refuse") throw InputError("not this problem");
  const DeformTask task = reference::read_deform_task(request);
  Response response;
  response.kernel_s = request.options.value("takes_s", 1e-6);
  response.report = {
      {"method", request.method}, {"outcome", "converged"}, {"identify_s", 0.0}, {"solve_s", 0.0}};
  if (behave == "no_outcome") response.report.erase("outcome");
  if (behave == "diverge") {
    response.report["outcome"] = "diverged";
    return response;
  }
  if (behave == "no_file") return response;
  const double error = request.options.value("bias", 0.0) / std::pow(4.0, request.options.value("refine", 0));
  std::vector<Vec3> field = linear_field(task, request.options.value("factor", 1.0) * (1.0 + error),
                                         request.options.value("midpoints", false));
  response.report["support_forces_n"] = support_forces(task, field);
  if (behave == "short_file") field.pop_back();
  if (behave == "nan_file") field.back().x = std::numeric_limits<double>::quiet_NaN();
  const std::string further = request.options.value("further", "");
  if (!further.empty()) {
    for (const nlohmann::json& item : reference::read_json_file(further)) {
      Request one = request;
      one.options["further"] = "";
      one.problem = item.at("problem_in").get<std::string>();
      one.output = item.at("displacement_out").get<std::string>();
      response.report["further"].push_back(answer(one).report);
    }
  }
  std::ofstream file(request.output);  // write_displacement would refuse what is not finite
  file.precision(17);
  file << "vertex,ux_m,uy_m,uz_m\n";
  for (std::size_t i = 0; i < field.size(); ++i)
    file << i << ',' << field[i].x << ',' << field[i].y << ',' << field[i].z << '\n';
  return response;
}

}  // namespace

int main(int argc, char** argv) {
  return reference::run_adapter(argc, argv, answer);
}

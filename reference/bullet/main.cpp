// Adapter of Bullet's soft body and of its springs: steps over the edges of a mesh, timed.
#include <algorithm>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/motion/motion_model.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/topology.h"
#include "reference/bullet/mass_springs.h"
#include "reference/bullet/soft_body.h"
#include "reference/door/adapter.h"
#include "reference/door/request_options.h"

namespace palpate::reference {
namespace {

constexpr double kDensity = 1000.0;  // kg/m^3

/// What both methods are asked.
struct Steps {
  std::int64_t count = 200;
  double step_s = 1e-3;
  double speed_m_s = 0.01;
};

Steps take_steps(nlohmann::json& left) {
  Steps steps;
  steps.count = take_whole(left, "steps", 1, 10'000'000, steps.count);
  steps.step_s = take_number(left, "time_step_s", 1e-9, 1.0, steps.step_s);
  steps.speed_m_s = take_number(left, "speed_m_s", 0.0, 1e6, steps.speed_m_s);
  return steps;
}

/// A spring an edge; its constants are the body's.
SpringNetwork build_network(const TetMesh& mesh) {
  SpringNetwork net;
  net.springs = build_edges(mesh);
  for (const Edge& e : net.springs) {
    net.rest_length_m.push_back(length(mesh.points[e[1]] - mesh.points[e[0]]));
    net.stiffness_n_per_m.push_back(0.0);
  }
  return net;
}

/// Throws a body at random, times its steps and writes where it ends.
template <typename Body>
Response time_steps(const Request& request, TetMesh mesh, std::size_t springs, const Steps& steps,
                    Body body) {
  SplitMix64 random(1);
  std::vector<Vec3> velocity(mesh.points.size());
  for (Vec3& v : velocity) {
    v = {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    v = 2.0 * steps.speed_m_s * v;
  }
  body.set_velocities(velocity);
  const Stopwatch watch;
  for (std::int64_t k = 0; k < steps.count; ++k) body.step(steps.step_s);
  Response response;
  response.kernel_s = watch.seconds();
  mesh.points = body.positions();
  if (!std::all_of(mesh.points.begin(), mesh.points.end(), is_finite))
    throw InputError("time_step_s", 0, "a step at which the body stays finite", std::to_string(steps.step_s));
  const double spring_steps = static_cast<double>(springs) * static_cast<double>(steps.count);
  response.report = {{"method", request.method},
                     {"vertices", mesh.points.size()},
                     {"springs", springs},
                     {"steps", steps.count},
                     {"ns_per_spring", 1e9 * response.kernel_s / spring_steps}};
  write_medit(request.output, mesh);
  return response;
}

Response answer_soft_body(const Request& request) {
  nlohmann::json left = request.options;
  BulletOptions options;
  options.iterations = static_cast<int>(take_whole(left, "iterations", 1, 1000, options.iterations));
  options.stiffness = take_number(left, "stiffness", 1e-6, 1.0, options.stiffness);
  options.damping = take_number(left, "damping", 0.0, 1.0, options.damping);
  const Steps steps = take_steps(left);
  require_all_taken(left);
  const TetMesh mesh = read_medit(request.input).mesh;
  const SpringNetwork net = build_network(mesh);
  BulletBody body(mesh.points, net, dynamics::build_lumped_masses(mesh, kDensity), options);
  Response response = time_steps(request, mesh, net.springs.size(), steps, std::move(body));
  response.notes.emplace_back(
      "links are constraints of position, not springs in N/m: the motion is another one, only the cost of a "
      "step over the same network compares");
  return response;
}

Response answer_mass_springs(const Request& request) {
  nlohmann::json left = request.options;
  BulletSpringOptions options;
  options.stiffness_n_per_m = take_number(left, "stiffness_n_per_m", 1e-12, 1e12, options.stiffness_n_per_m);
  options.damping_n_s_per_m = take_number(left, "damping_n_s_per_m", 0.0, 1e12, options.damping_n_s_per_m);
  const Steps steps = take_steps(left);
  require_all_taken(left);
  const TetMesh mesh = read_medit(request.input).mesh;
  const SpringNetwork net = build_network(mesh);
  BulletSprings body(mesh.points, net, dynamics::build_lumped_masses(mesh, kDensity), options);
  return time_steps(request, mesh, net.springs.size(), steps, std::move(body));
}

Response answer(const Request& request) {
  if (request.contest != "step") throw InputError("contest", 0, "step", request.contest);
  if (request.method == "bullet.soft_body") return answer_soft_body(request);
  if (request.method == "bullet.mass_springs") return answer_mass_springs(request);
  throw InputError("method", 0, "bullet.soft_body or bullet.mass_springs", request.method);
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}

// Adapter of Bullet's soft body: steps over the edges of a mesh, timed.
#include <chrono>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/motion_model.h"
#include "core/mesh/medit.h"
#include "core/mesh/topology.h"
#include "reference/adapter.h"
#include "reference/bullet/soft_body.h"
#include "reference/fusion_options.h"

namespace palpate::reference {
namespace {

constexpr double kDensity = 1000.0;  // kg/m^3: all that it decides is how corrections are shared

Response answer(const Request& request) {
  if (request.contest != "step") throw InputError("contest", 0, "step", request.contest);
  if (request.method != "bullet.soft_body") throw InputError("method", 0, "bullet.soft_body", request.method);
  nlohmann::json left = request.options;
  BulletOptions options;
  options.iterations = static_cast<int>(take_whole(left, "iterations", 1, 1000, options.iterations));
  options.stiffness = take_number(left, "stiffness", 1e-6, 1.0, options.stiffness);
  options.damping = take_number(left, "damping", 0.0, 1.0, options.damping);
  const std::int64_t steps = take_whole(left, "steps", 1, 10'000'000, 200);
  const double step_s = take_number(left, "time_step_s", 1e-9, 1.0, 1e-3);
  const double speed = take_number(left, "speed_m_s", 0.0, 1e6, 0.01);
  require_all_taken(left);

  TetMesh mesh = read_medit(request.input).mesh;
  SpringNetwork net;
  net.springs = build_edges(mesh);
  for (const Edge& e : net.springs) {
    net.rest_length_m.push_back(length(mesh.points[e[1]] - mesh.points[e[0]]));
    net.stiffness_n_per_m.push_back(0.0);  // of no meaning to a link
  }
  BulletBody body(mesh.points, net, dynamics::build_lumped_masses(mesh, kDensity), options);
  SplitMix64 random(1);
  std::vector<Vec3> velocity(mesh.points.size());
  for (Vec3& v : velocity) {
    v = {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    v = 2.0 * speed * v;
  }
  body.set_velocities(velocity);

  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  for (std::int64_t k = 0; k < steps; ++k) body.step(step_s);
  Response response;
  response.kernel_s = std::chrono::duration<double>(Clock::now() - start).count();
  const double spring_steps = static_cast<double>(net.springs.size()) * static_cast<double>(steps);
  response.report = {{"method", request.method},
                     {"vertices", mesh.points.size()},
                     {"springs", net.springs.size()},
                     {"steps", steps},
                     {"ns_per_spring", 1e9 * response.kernel_s / spring_steps}};
  response.notes.emplace_back(
      "links are constraints of position, not springs in N/m: the motion is another one, only the cost of a "
      "step over the same network compares");
  mesh.points = body.positions();
  write_medit(request.output, mesh);
  return response;
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}

#include "tests/support/engine_comparison.h"

#include "core/dynamics/elasticity/loads.h"

namespace palpate::testing_support {

void add_palpation(const TetMesh& mesh, dynamics::MotionModel& model) {
  const std::size_t n = mesh.points.size();
  model.loads.front().loads = {std::vector<Vec3>(n), {}, std::vector<std::uint8_t>(n), std::vector<Vec3>(n)};
  const auto patch = [&](int axis, double at) {
    FacePatch out{find_faces_at(mesh, axis, at), {}};
    for (std::size_t k = 0; k < out.faces.size(); ++k) out.weight.push_back(k % 3 == 0 ? 0.25 : 1.0);
    return out;
  };
  BoundaryProblem still;
  still.supports.push_back({patch(2, 0.0), 5e3, {}});
  BoundaryProblem pad;
  pad.supports.push_back({patch(0, 1.0), 2e4, {-0.05, 0.01, 0.0}});
  pad.nodal_forces.push_back({7, {0.0, 0.5, 0.0}});
  BoundaryProblem weight;
  weight.material.density_kg_m3 = 1000.0;
  weight.gravity_m_s2 = {0.0, 0.3, -0.5};
  model.loads.push_back({dynamics::build_loads(mesh, still), {}});
  model.loads.push_back({dynamics::build_loads(mesh, pad), {{0.0, 0.15}, {0.0, 1.0}, true}});
  model.loads.push_back({dynamics::build_loads(mesh, weight), {{0.0, 0.05, 0.1}, {0.0, 1.0, 0.5}, false}});
}

}  // namespace palpate::testing_support

#include "tests/support/live_cases.h"

#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"

namespace palpate::testing_support {

live::BodySetup make_live_cube(int cells_per_side) {
  constexpr double kSideM = 0.06;
  live::BodySetup setup;
  setup.mesh = build_kuhn_cube(cells_per_side, 0.2, 5);
  const std::vector<Triangle> bottom = find_faces_at(setup.mesh, 2, 0.0);
  for (Vec3& p : setup.mesh.points) p = kSideM * p;
  setup.holding.material = {10000.0, 0.45, 1050.0};
  setup.holding.supports.push_back({{bottom, std::vector<double>(bottom.size(), 1.0)}, 1e6, {}});
  setup.springs = make_edge_springs(setup.mesh, 10000.0);
  setup.damping_mass_per_s = 60.0;
  return setup;
}

Index top_vertex(const TetMesh& mesh) {
  const BoundingBox box = bounding_box(mesh.points);
  const Vec3 middle = 0.5 * (box.low + box.high);
  return nearest_point(mesh.points, {middle.x, middle.y, box.high.z});
}

live::ModelChoice linear_tets() {
  live::ModelChoice choice;
  choice.is_smoothed = true;
  choice.blend = {.strain = StrainSize::kSmall, .theta = 1.0, .domain = dynamics::StrainDomain::kTet};
  return choice;
}

}  // namespace palpate::testing_support

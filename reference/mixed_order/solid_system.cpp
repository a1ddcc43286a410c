#include "reference/mixed_order/solid_system.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/dynamics/reduced/rigid_frame.h"
#include "core/mesh/geometry.h"

namespace palpate::reference {

dynamics::BlockMatrix SolidSystem::stiffness(double modulus_scale) const {
  dynamics::BlockMatrix sum = body.stiffness;
  for (std::size_t k = 0; k < sum.blocks.size(); ++k)
    sum.blocks[k] = modulus_scale * sum.blocks[k] + supports.blocks[k];
  return sum;
}

SolidSystem build_solid_system(const SolidSpace& solid, const Material& material,
                               const dynamics::NodeLoads& loads) {
  SolidSystem system;
  dynamics::BlockMatrix whole = build_element_matrices(solid.mesh, solid.space, material).stiffness;
  system.body.stiffness = restrict_matrix(solid.map, solid.space, whole);
  std::fill(whole.blocks.begin(), whole.blocks.end(), dynamics::Mat3{});
  add_support_stiffness(loads, solid.space.order, whole);
  system.supports = restrict_matrix(solid.map, solid.space, whole);
  for (const Index node : solid.map.nodes) {
    system.held.push_back(loads.held[node]);
    system.held_by_m.push_back(loads.held_by_m[node]);
  }
  return system;
}

std::vector<Vec3> sum_forces(const dynamics::NodeLoads& loads, int order) {
  std::vector<Vec3> force = loads.force_n;
  add_support_pull(loads, order, force);
  return force;
}

SolidFigures measure_solid(const SolidSpace& solid, const SolidSystem& system,
                           const dynamics::NodeLoads& loads, double modulus_scale,
                           std::span<const Vec3> unknown_m, std::size_t supports) {
  SolidFigures figures;
  std::vector<Vec3> pull(unknown_m.size());
  multiply(system.body.stiffness, unknown_m, pull);
  figures.energy_j = 0.5 * modulus_scale * dynamics::dot_of(unknown_m, pull);
  const std::vector<Vec3> all = apply_map(solid.map, unknown_m);
  dynamics::SupportFigures held = measure_supports(loads, solid.space.order, all, supports);
  figures.potential_j = figures.energy_j + held.energy_j - dynamics::dot_of(loads.force_n, all);
  figures.support_forces_n = std::move(held.forces_n);

  const std::vector<Vec3> force = apply_transposed(solid.map, sum_forces(loads, solid.space.order));
  std::vector<Vec3> support_pull(unknown_m.size());
  multiply(system.supports, unknown_m, support_pull);
  std::vector<Vec3> left(force);
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = left[i] - modulus_scale * pull[i] - support_pull[i];
  std::vector<Vec3> reactions = left;
  dynamics::clear_held(system.held, left);
  dynamics::add_scaled(reactions, -1.0, left);
  const double acting = dynamics::norm_of(force) + dynamics::norm_of(reactions);
  figures.residual_relative = acting > 0.0 ? dynamics::norm_of(left) / acting : 0.0;
  return figures;
}

void report_figures(const SolidFigures& figures, nlohmann::json& report) {
  report["outcome"] = "converged";
  report["iterations"] = 1;
  report["energy_j"] = figures.energy_j;
  report["potential_j"] = figures.potential_j;
  report["residual_relative"] = figures.residual_relative;
  nlohmann::json forces = nlohmann::json::array();
  for (const Vec3& f : figures.support_forces_n) forces.push_back({f.x, f.y, f.z});
  report["support_forces_n"] = std::move(forces);
}

BoundaryProblem holding_of(const BoundaryProblem& problem) {
  BoundaryProblem holding;
  holding.material = problem.material;
  holding.held = problem.held;
  holding.supports = problem.supports;
  for (HeldFaces& held : holding.held) held.by_m = {};
  for (ElasticSupport& support : holding.supports) support.by_m = {};
  return holding;
}

Deformation::Deformation(const TetMesh& mesh) : weights_(mesh.points.size(), 0.0) {
  for (const Tet& t : mesh.tets) {
    const double volume =
        signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
    for (const Index v : t) weights_[v] += 0.25 * volume;
  }
  const dynamics::RigidFrame frame = dynamics::build_rigid_frame(mesh);
  for (std::size_t k = 0; k < 6; ++k) {
    std::vector<Vec3>& motion = motions_.at(k);
    for (const Vec3& point : mesh.points) motion.push_back(frame.motion(k, point));
    for (std::size_t j = 0; j < k; ++j)
      dynamics::add_scaled(motion, -product(motions_.at(j), motion), motions_.at(j));
    const double size = std::sqrt(product(motion, motion));
    for (Vec3& at : motion) at = (1.0 / size) * at;
  }
}

void Deformation::take_off_rigid(std::vector<Vec3>& field) const {
  for (const std::vector<Vec3>& motion : motions_)
    dynamics::add_scaled(field, -product(motion, field), motion);
}

double Deformation::product(std::span<const Vec3> a, std::span<const Vec3> b) const {
  double sum = 0.0;
  for (std::size_t v = 0; v < weights_.size(); ++v) sum += weights_[v] * dot(a[v], b[v]);
  return sum;
}

}  // namespace palpate::reference

#include "reference/mixed_order/modulus_fit.h"

#include <array>
#include <cmath>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::reference {
namespace {

using Fields = std::array<std::vector<Vec3>, 3>;

/// The forces of a body's weight along each axis at the unknowns of a space. Its density does not matter.
Fields weigh(const SolidSpace& solid, const BoundaryProblem& problem) {
  Fields forces;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    BoundaryProblem weight = holding_of(problem);
    weight.material.density_kg_m3 = 1000.0;
    component(weight.gravity_m_s2, axis) = 9.81;
    const dynamics::NodeLoads loads =
        build_node_loads(solid.mesh, solid.space, weight, dynamics::BodyForces::kInclude);
    forces.at(axis) = apply_transposed(solid.map, loads.force_n);
  }
  return forces;
}

/// The deformation of quadratic elements on the whole mesh.
Fields solve_whole(const FitTask& task, const Deformation& deformation,
                   const dynamics::FactorMaker& make_factor) {
  SolidSpace whole{task.organ, dynamics::build_element_space(task.organ, 2), {}};
  whole.map = follow_edges(whole.space, std::vector<std::uint8_t>(whole.space.edges.edges.size(), 1));
  const dynamics::NodeLoads loads =
      build_node_loads(whole.mesh, whole.space, holding_of(task.problem), dynamics::BodyForces::kLeaveOut);
  const SolidSystem system = build_solid_system(whole, task.problem.material, loads);
  const dynamics::HeldElements held(system.body, system.stiffness(1.0), system.held, make_factor);
  Fields truth = weigh(whole, task.problem);
  const std::vector<Vec3> nothing(system.held.size());
  for (std::vector<Vec3>& field : truth) {
    field = held.rest_under(field, nothing);
    field.resize(task.organ.points.size());
    deformation.take_off_rigid(field);
  }
  return truth;
}

/// Sums over the three loads at one scale.
struct FitSums {
  double left_sq = 0.0;   ///< |r|^2, r = u - u_s
  double along = 0.0;     ///< r . du_s/ds
  double slope_sq = 0.0;  ///< |du_s/ds|^2
};

}  // namespace

ModulusFit fit_modulus(const FitTask& task, const SampleVertices& sample,
                       const dynamics::FactorMaker& make_factor) {
  constexpr int kRounds = 6;
  constexpr double kDone = 1e-6;
  const Deformation deformation(task.organ);
  const Fields truth = solve_whole(task, deformation, make_factor);
  double size_sq = 0.0;
  for (const std::vector<Vec3>& field : truth) size_sq += deformation.product(field, field);
  const dynamics::NodeLoads loads = build_node_loads(
      task.model.mesh, task.model.space, holding_of(task.model_problem), dynamics::BodyForces::kLeaveOut);
  const SolidSystem system = build_solid_system(task.model, task.model_problem.material, loads);
  const Fields forces = weigh(task.model, task.model_problem);
  const std::vector<Vec3> nothing(system.held.size());

  const auto sum_at = [&](double scale) {
    const dynamics::HeldElements held(system.body, system.stiffness(scale), system.held, make_factor);
    FitSums sums;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::vector<Vec3> u = held.rest_under(forces.at(axis), nothing);
      std::vector<Vec3> pull(u.size());
      multiply(system.body.stiffness, u, pull);
      for (Vec3& f : pull) f = -1.0 * f;
      std::vector<Vec3> left = truth.at(axis);
      dynamics::add_scaled(left, -1.0, sample(apply_map(task.model.map, u)));
      deformation.take_off_rigid(left);
      std::vector<Vec3> slope = sample(apply_map(task.model.map, held.rest_under(pull, nothing)));
      deformation.take_off_rigid(slope);
      sums.left_sq += deformation.product(left, left);
      sums.along += deformation.product(left, slope);
      sums.slope_sq += deformation.product(slope, slope);
    }
    return sums;
  };

  ModulusFit fit;
  for (fit.rounds = 0; fit.rounds < kRounds; ++fit.rounds) {
    const FitSums sums = sum_at(fit.scale);
    fit.off_after = std::sqrt(sums.left_sq / size_sq);
    if (fit.rounds == 0) fit.off_before = fit.off_after;
    const double step = sums.along / sums.slope_sq;
    if (!(fit.scale + step > 0.0))
      throw UnavailableError("no positive modulus fits the three solves of the whole mesh");
    fit.scale += step;
    if (std::fabs(step) < kDone * fit.scale) break;
  }
  return fit;
}

}  // namespace palpate::reference

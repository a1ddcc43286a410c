#include "reference/reduced/modes/modal_body.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/mesh/rigid_motion.h"
#include "reference/linear_systems/factor.h"

namespace palpate::reference {

using dynamics::BodyForces;
using dynamics::ModalGroup;

ModalBody::ModalBody(const TetMesh& mesh, const MotionProblem& problem, int order, std::string factor)
    : mesh_(mesh),
      problem_(problem),
      order_(order),
      factor_(std::move(factor)),
      space_(dynamics::build_element_space(mesh, order)),
      matrices_(build_element_matrices(mesh, space_, problem.body.material)) {}

void ModalBody::require_held(const LoadPhase& phase) const {
  BoundaryProblem all = problem_.body;  // what holds in this phase
  for (const std::size_t k : phase.loads) {
    const BoundaryProblem& part = problem_.loads[k].part;
    all.supports.insert(all.supports.end(), part.supports.begin(), part.supports.end());
    all.held.insert(all.held.end(), part.held.begin(), part.held.end());
  }
  const auto free = find_free_motions(mesh_, resisted_axes(mesh_, all));
  if (!free.empty())
    throw InputError(
        "problem", 0, "supports or held faces that stop every rigid motion in each phase",
        rigid_motion_text(free[0]) + " left free from " + nlohmann::json(phase.from_s).dump() + " s");
}

dynamics::ModalPhase ModalBody::build_phase(const LoadPhase& phase, dynamics::ModalOptions modal) const {
  require_held(phase);
  const auto group_of = [&](const BoundaryProblem& part, const dynamics::TimeProfile& profile) {
    return ModalGroup{build_node_loads(mesh_, space_, part, BodyForces::kInclude), profile};
  };
  std::vector<ModalGroup> groups{group_of(problem_.body, {})};
  for (const std::size_t k : phase.loads)
    groups.push_back(group_of(problem_.loads[k].part, problem_.loads[k].profile));
  modal.modes = std::max(modal.modes, problem_.frequencies);
  modal.damping_stiffness_s = problem_.damping_stiffness_s;
  modal.damping_mass_per_s = problem_.damping_mass_per_s;
  return {matrices_, order_, std::move(groups), modal, choose_factor(factor_)};
}

}  // namespace palpate::reference

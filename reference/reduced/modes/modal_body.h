// A finite-element body that is taken through the phases of a motion by its modes.
#pragma once

#include <string>

#include "core/dynamics/finite_elements/elements.h"
#include "core/dynamics/reduced/modal_phase.h"
#include "core/mesh/tet_mesh.h"
#include "reference/door/motion_problem.h"

namespace palpate::reference {

/// Of a motion.
inline constexpr double kMostModalSteps = 1e8;

/// Elements with consistent mass, and how each phase of their loads is reduced.
class ModalBody {
 public:
  /// `order` 1 or 2; `factor` as choose_factor reads it. Mesh and problem must outlive it.
  ModalBody(const TetMesh& mesh, const MotionProblem& problem, int order, std::string factor);

  /// Throws: InputError for a body that is left free in a phase.
  void require_held(const LoadPhase& phase) const;

  /// The modes of the body in what holds it in a phase; group 0 are the loads of the body itself, group k + 1
  /// is the phase's load k. `modal` has modes and correction; damping comes from the problem, and there are
  /// as many modes as it asks frequencies of. Throws: InputError for a body that is left free, and as
  /// ModalPhase.
  dynamics::ModalPhase build_phase(const LoadPhase& phase, dynamics::ModalOptions modal) const;

  const dynamics::ElementSpace& space() const { return space_; }

 private:
  const TetMesh& mesh_;
  const MotionProblem& problem_;
  int order_;
  std::string factor_;
  dynamics::ElementSpace space_;
  dynamics::ElementMatrices matrices_;
};

}  // namespace palpate::reference

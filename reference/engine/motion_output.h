// What our engine's run of a moving body writes: rows and frames of its states.
#pragma once

#include <filesystem>
#include <span>

#include "core/dynamics/motion/motion_forces.h"
#include "core/mesh/tet_mesh.h"
#include "reference/elastic_models/motion_files.h"
#include "reference/engine/motion_setup.h"

namespace palpate::reference {

/// Takes rows and frames from the states of a motion to its files.
class MotionOutput {
 public:
  MotionOutput(std::filesystem::path folder, const MotionProblem& problem, const TetMesh& mesh)
      : files_(std::move(folder), problem, mesh) {}

  /// Also measures what acts on these vertices, which are held at rest, at each row. They have to live as
  /// long as this.
  void watch_frozen(std::span<const Index> frozen) { frozen_ = frozen; }

  /// A row of the history for the state of a phase.
  void add_row(const MotionPhase& phase, dynamics::MotionForces& forces, const dynamics::MotionState& state);

  /// A frame, unless there is one of that time.
  void add_frame(const dynamics::MotionState& state) { files_.add_frame(state.time_s, state.displacement_m); }

  const MotionFiles& files() const { return files_; }
  /// The most of dynamics::frozen_force over the rows, in N.
  double max_frozen_force_n() const { return max_frozen_force_n_; }

 private:
  MotionFiles files_;
  std::span<const Index> frozen_;
  double max_frozen_force_n_ = 0.0;
};

}  // namespace palpate::reference

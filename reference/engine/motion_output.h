// What a run of a moving body writes: frames for ParaView and a history.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/dynamics/motion/motion_forces.h"
#include "core/mesh/tet_mesh.h"
#include "reference/door/motion_problem.h"
#include "reference/engine/motion_setup.h"

namespace palpate::reference {

/// How much a run may write, in bytes, unless told otherwise.
inline constexpr double kMostOutputBytes = 2e9;

/// An estimate of the bytes of so many frames and rows, from above: numbers at their longest.
double estimate_output_bytes(const TetMesh& mesh, std::uint64_t frames, std::uint64_t rows,
                             std::size_t columns);

/// Throws InputError that names the estimate if a run would write more than `most_bytes`, or more than what
/// is left on the disk of `folder`.
void require_room(const std::filesystem::path& folder, double bytes, double most_bytes);

/// Displacements at one time, in m, one a vertex.
struct MotionFrame {
  double time_s = 0.0;
  std::vector<Vec3> displacement_m;
};

/// Writes frames as frame_00000.vtu ..., with frames.pvd that gives ParaView their times, and history.csv.
/// Its columns:
///
///   time_s, kinetic_j, elastic_j, load_j, total_j, volume_m3, inverted_tets, largest_speed_m_s,
///   tool_K_fx_n, ... the force of load K (from 1) on the body, of those that are tools; 0 while it is not
///   there,
///   probe_K_ux_m, ... the displacement of probe K,
///   largest_displacement_m, rms_displacement_m  over all vertices
///
/// An energy that is not finite is left empty. With an empty folder nothing is written: history and frames
/// are kept in memory.
class MotionOutput {
 public:
  MotionOutput(std::filesystem::path folder, const MotionProblem& problem, const TetMesh& mesh);

  /// Also measures what acts on these vertices, which are held at rest, at each row. They have to live as
  /// long as this.
  void watch_frozen(std::span<const Index> frozen) { frozen_ = frozen; }

  /// A row of the history for the state of a phase.
  void add_row(const MotionPhase& phase, dynamics::MotionForces& forces, const dynamics::MotionState& state);

  /// A frame, unless there is one of that time.
  void add_frame(const dynamics::MotionState& state);

  /// Writes history.csv and, if there are frames, frames.pvd. Without a folder it does nothing.
  void finish() const;

  const std::string& history_csv() const { return history_; }
  /// Of an output in memory.
  const std::vector<MotionFrame>& frames() const { return frames_; }
  std::size_t columns() const { return columns_; }
  std::size_t frame_count() const { return frame_times_.size(); }
  double max_displacement_m() const { return max_displacement_m_; }
  double max_kinetic_j() const { return max_kinetic_j_; }
  /// The most of dynamics::frozen_force over the rows, in N.
  double max_frozen_force_n() const { return max_frozen_force_n_; }

 private:
  std::filesystem::path folder_;
  const TetMesh* mesh_;
  std::vector<std::size_t> tools_;  ///< loads that are tools, by their place in the problem
  std::vector<Index> probes_;
  std::size_t columns_ = 0;
  std::string history_;
  std::vector<MotionFrame> frames_;
  std::vector<double> frame_times_;
  double max_displacement_m_ = 0.0;
  double max_kinetic_j_ = 0.0;
  std::span<const Index> frozen_;
  double max_frozen_force_n_ = 0.0;
};

}  // namespace palpate::reference

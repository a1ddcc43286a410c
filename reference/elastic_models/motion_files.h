// What a run of a moving body writes, whoever steps it: frames for ParaView and a history.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "reference/door/motion_problem.h"

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

/// How often rows and frames are taken, in steps.
struct Strides {
  std::uint64_t row = 1;
  std::uint64_t frame = 0;  ///< 0: none

  /// At most `samples` intervals between rows in `steps` steps, and about `frames` between frames.
  Strides(std::uint64_t samples, std::uint64_t frames, std::uint64_t steps);
};

/// What a row of the history is made of.
///
/// Shape:  tool_n has one force a tool of the problem (MotionLoad::is_tool), in order; displacement_m one
/// entry a vertex.
struct MotionRow {
  double time_s = 0.0;
  double kinetic_j = 0.0;
  double elastic_j = 0.0;
  double load_j = 0.0;
  double volume_m3 = 0.0;
  std::size_t inverted_tets = 0;
  double largest_speed_m_s = 0.0;
  std::vector<Vec3> tool_n;
  std::span<const Vec3> displacement_m;
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
class MotionFiles {
 public:
  MotionFiles(std::filesystem::path folder, const MotionProblem& problem, const TetMesh& mesh);

  void add_row(const MotionRow& row);

  /// A frame, unless there is one of that time.
  void add_frame(double time_s, std::span<const Vec3> displacement_m);

  /// Writes history.csv and, if there are frames, frames.pvd. Without a folder it does nothing.
  void finish() const;

  /// The loads that are tools, by their place in the problem.
  const std::vector<std::size_t>& tools() const { return tools_; }
  const std::string& history_csv() const { return history_; }
  /// Of an output in memory.
  const std::vector<MotionFrame>& frames() const { return frames_; }
  std::size_t columns() const { return columns_; }
  std::size_t frame_count() const { return frame_times_.size(); }
  double max_displacement_m() const { return max_displacement_m_; }
  double max_kinetic_j() const { return max_kinetic_j_; }

 private:
  std::filesystem::path folder_;
  const TetMesh* mesh_;
  std::vector<std::size_t> tools_;
  std::vector<Index> probes_;
  std::size_t columns_ = 0;
  std::string history_;
  std::vector<MotionFrame> frames_;
  std::vector<double> frame_times_;
  double max_displacement_m_ = 0.0;
  double max_kinetic_j_ = 0.0;
};

/// What a replay is asked beside its body.
struct ReplayOptions {
  double stop_after_s = 0.0;  ///< 0: never
  double most_output_bytes = kMostOutputBytes;
  bool setup_only = false;
  std::uint64_t frames = 0;  ///< in place of the scene's; 0: the scene's
};

/// Takes stop_after_s, max_output_gb, setup_only and frames. Throws: InputError.
ReplayOptions take_replay_options(nlohmann::json& left);

/// Makes a folder ready for `rows` and `frames`: room enough, and nothing of an earlier run. Throws:
/// InputError.
void clear_folder(const std::filesystem::path& folder, const TetMesh& mesh, const MotionFiles& files,
                  std::uint64_t rows, std::uint64_t frames, double most_bytes);

/// The answer of a replay (palpate/engine/1): columns, rows and frames; empty ones where they are in a
/// folder.
nlohmann::json describe_replay(const MotionFiles& files, bool is_in_folder);

}  // namespace palpate::reference

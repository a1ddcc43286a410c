// A fitted scene in motion: how it ends, what it takes, and what its step adds to the motion.
#pragma once

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/registry/registry.h"
#include "experiments/scene_reader/scene.h"

namespace palpate::experiments {

/// Displacements of the probes over time.
struct ProbeHistory {
  std::vector<double> time_s;
  std::vector<std::vector<double>> row;  ///< a component of a probe each
};

/// One run as `simulate` would do it.
struct MotionTrial {
  std::string outcome;  ///< "completed", "diverged", "inverted", "unsolved", "timed_out", "interrupted"
  double step_s = 0.0;
  double kernel_s = 0.0;        ///< of the clock, for its steps with all that they factor
  double simulated_s = 0.0;     ///< how far it came
  double frozen_force_n = 0.0;  ///< the most on a part that is held at rest
  double setup_s = 0.0;         ///< before the first step; reported, and in no other time
  double pictures_s = 0.0;      ///< of modes: the displacement of all vertices, 60 times a simulated second
  std::vector<double> again_s;  ///< the steps' time of further runs through the same motion
  std::uint64_t memory_bytes = 0;  ///< the most that it took
  ProbeHistory history;            ///< of a completed one

  /// Time of the clock for a simulated second.
  double second_s() const { return second_of(kernel_s); }
  double second_of(double kernel) const { return kernel / simulated_s + pictures_s; }
};

/// A trial's scene on its mesh.
struct PlacedTrial {
  Scene scene;
  TetMesh mesh;
};

/// What a run is asked for beside its scene.
struct TrialSettings {
  std::filesystem::path mesh;    ///< in m
  std::filesystem::path folder;  ///< is made; scene and answer go there
  double timeout_s = 120.0;      ///< of the clock
  const volatile std::sig_atomic_t* stop_flag = nullptr;
  int timings = 0;  ///< of modes: further runs through the motion, for their time
};

/// |u_h - u_h/4| is 3/4 of the error that a step of h leaves of a motion stepped with order 1, and nearer to
/// all of it with a higher one.
inline constexpr double kRestOfOrderOne = 4.0 / 3.0;
/// A step is held against the same motion in steps of this share.
inline constexpr double kFinerStep = 0.25;
/// Vertices at which motions are held against each other.
inline constexpr std::size_t kTrialProbes = 64;

/// A moving scene with this step, however long it is, at these probes alone (m), without frames.
nlohmann::json with_fixed_step(const nlohmann::json& scene, double step_s, const nlohmann::json& probes_m);

/// At most `count` of the points, spread over them: the first is point 0, each next one the farthest from all
/// before. [[x, y, z], ...] in the points' unit.
nlohmann::json spread_probes(std::span<const Vec3> points, std::size_t count);

/// Where a fitted scene's motion is looked at: at vertices spread over the fitted mesh; where the scene asks
/// for its error at some places alone, at those vertices of its own mesh. In m. `scene` is as it was before
/// it was fitted, moving or at rest. Throws: InputError for a mesh that cannot be read.
nlohmann::json choose_probes(const Scene& scene, const std::filesystem::path& fitted_mesh, std::size_t count);

/// The columns time_s and probe_* of an engine's answer (palpate/engine/1). What is no number is NaN. Throws:
/// InputError with the file for one that is not as it should be.
ProbeHistory read_probe_history(const std::filesystem::path& file);

/// sqrt(sum over the rows and components of `coarse` of (c - f)^2 / sum of f^2), f between two rows of `fine`
/// by a straight line; rows past the end of `fine` are left out. 0 where neither moves; infinite where only
/// `coarse` does, or it has something that is no number. Cost: linear.
double history_difference(const ProbeHistory& coarse, const ProbeHistory& fine);

/// The same at the rows of `truth`, with `of` between its own rows by a straight line: what is not seen
/// between two rows counts. Relative to `truth`; infinite where `of` ends before it does.
double difference_at_rows(const ProbeHistory& of, const ProbeHistory& truth);

/// Makes the folder, writes the scene to it with the mesh in place of its own, and reads it back. Throws: as
/// read_scene.
PlacedTrial place_trial(const nlohmann::json& scene, const TrialSettings& settings);

/// Runs the scene, which is written below the folder. Throws: as simulate.
MotionTrial run_motion_trial(const nlohmann::json& scene, const TrialSettings& settings,
                             const Registry& registry);

}  // namespace palpate::experiments

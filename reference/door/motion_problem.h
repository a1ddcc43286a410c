// The door of the contest `motion`: a body that moves as a file, and its history as a file. See PROTOCOL.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/dynamics/motion/time_profile.h"
#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "reference/door/adapter.h"

namespace palpate::reference {

/// One load with its times. Dead loads, and how far supports and held faces are moved, are multiplied by the
/// profile's share; a support is there, and a face held, whatever the share, but from `from_s` to `until_s`
/// alone.
struct MotionLoad {
  BoundaryProblem part;  ///< gravity, supports, held faces, tractions and nodal forces of this load alone
  dynamics::TimeProfile profile;
  double from_s = 0.0;
  std::optional<double> until_s;  ///< nothing: to the end

  /// Whether the load moves a tool: something supported or held, whose force on the body is written down.
  bool is_tool() const { return !part.supports.empty() || !part.held.empty(); }
};

/// A body at rest at time zero, then moved by its loads, with Rayleigh damping
///
///   M a + (mass_per_s M + stiffness_s K) v + K u + supports = loads(t),
///
/// K the stiffness of the body alone: supports don't damp.
struct MotionProblem {
  BoundaryProblem body;  ///< material, size of strain, and what holds it all the time
  std::vector<MotionLoad> loads;
  double damping_stiffness_s = 0.0;
  double damping_mass_per_s = 0.0;
  double duration_s = 0.0;
  std::uint64_t samples = 1000;  ///< intervals between rows of the history, at most
  std::vector<Index> probes;     ///< vertices whose displacement is written down
  std::size_t frequencies = 0;   ///< how many of the lowest natural frequencies are asked for
};

/// The problem as JSON (palpate/motion_problem/1):
///
///   {"schema": "palpate/motion_problem/1", "body": {palpate/problem/1},
///    "loads": [{"part": {palpate/problem/1}, "from_s": 0, "until_s": 0.15,
///               "profile": {"times_s": [0, 0.1], "shares": [0, 1], "smooth": true}}],
///    "damping": {"stiffness_s": 2e-4, "mass_per_s": 5}, "duration_s": 0.3, "samples": 1000,
///    "probes": [7], "frequencies": 10}
nlohmann::json motion_to_json(const MotionProblem& problem);

/// Reads it back and checks it against the mesh: each part as problem_from_json, one material for all,
/// profiles that increase, times and damping that are not negative, a duration above zero. Throws:
/// InputError that starts with `where`.
MotionProblem motion_from_json(const nlohmann::json& json, const TetMesh& mesh, const std::string& where);

/// What a request of the contest motion asks: the mesh in metres and its problem.
struct MotionTask {
  TetMesh mesh;
  MotionProblem problem;
};

/// Reads both files of a request. Throws: InputError, also for a request of another contest.
MotionTask read_motion_task(const Request& request);

/// The problem on the uniform refinement of `mesh`, with the same faces, supports and probes.
MotionProblem refine_motion(const MotionProblem& problem, const TetMesh& mesh, const TetMesh& refined);

/// A stretch of time in which the same loads are there.
struct LoadPhase {
  double from_s = 0.0;
  double to_s = 0.0;
  std::vector<std::size_t> loads;  ///< places in the list of loads
};

/// The phases of a problem, in order, from 0 to its duration.
std::vector<LoadPhase> find_phases(const MotionProblem& problem);

/// Rows of numbers with named columns: time_s, kinetic_j, elastic_j, load_j, total_j, then tool_K_fx_n,
/// ...fy,
/// ...fz (the force of load K, from 1, on the body; 0 while it is not there) for each tool, and probe_K_ux_m,
/// ... for each probe.
///
/// Shape:  one number a column in each row; times rise from 0 to the duration.
struct MotionHistory {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
};

/// The columns that the history of a problem has.
std::vector<std::string> history_columns(const MotionProblem& problem);

/// What a row is made of.
///
/// Shape:  push_n holds the force of what holds the body all the time, then that of each of the phase's
/// loads; probe_m one
///         displacement a probe.
struct HistoryMoment {
  double time_s = 0.0;
  double kinetic_j = 0.0;
  double elastic_j = 0.0;
  double load_j = 0.0;
  std::vector<Vec3> push_n;
  std::vector<Vec3> probe_m;
};

/// The row of a moment in `phase`, in the order of history_columns. Throws: ContractError for other sizes.
std::vector<double> history_row(const MotionProblem& problem, const LoadPhase& phase,
                                const HistoryMoment& moment);

/// Writes it as CSV, with numbers that read back to the same bits. Throws: ContractError unless all are
/// finite.
void write_history(const std::filesystem::path& path, const MotionHistory& history);

/// Reads it. Throws: InputError unless the columns are those of the problem, all numbers are finite, and the
/// times rise from 0 to the duration (to 1e-9 of it).
MotionHistory read_history(const std::filesystem::path& path, const MotionProblem& problem);

/// At most kMostStates states of a motion, spread evenly over its duration, and fewer of large bodies. They
/// are looked at and never judged: they lie in states.json beside the history (palpate/states/1):
///
///   {"schema": "palpate/states/1", "states": [{"time_s": 0.1, "displacement_m": [x, y, z, x, ...]}]}
class MotionStates {
 public:
  static constexpr std::size_t kMostStates = 25;
  static constexpr std::size_t kMostNumbers = 1'500'000;  ///< of all states together

  MotionStates() : MotionStates(0.0, 0) {}
  MotionStates(double duration_s, std::size_t vertices);

  /// Whether the state at `time_s` is to be added. The first and the last moment always are.
  bool is_due(double time_s) const;

  /// Adds a state. Shape: one displacement a vertex, in m. Throws: ContractError for another number.
  void add(double time_s, std::vector<Vec3> displacement_m);

  /// Writes them, to a nanometre, beside a history; nothing if a body is too large for two, or one is not
  /// finite. Throws: InputError if the file cannot be written.
  void write_beside(const std::filesystem::path& history) const;

 private:
  struct State {
    double time_s = 0.0;
    std::vector<Vec3> displacement_m;
  };

  double duration_s_;
  std::size_t vertices_;
  std::size_t most_;
  std::vector<State> states_;
};

}  // namespace palpate::reference

// A body that moves, whole: what moves it, the model it is to have, and how it is stepped. See PROTOCOL.md.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/dynamics/motion/integrator_kind.h"
#include "core/dynamics/motion/spring_damping.h"
#include "core/mesh/tet_mesh.h"
#include "reference/door/motion_problem.h"

namespace palpate::reference {

/// What steps a body: kPlain is core/dynamics/spring_engine/plain_engine.h, for springs, loads and symplectic
/// Euler alone; kTets core/dynamics/tet_engine/tet_engine.h, for strain energies in place of springs; kAuto
/// takes the one that can.
enum class EngineChoice { kAuto, kGeneral, kPlain, kTets };

/// "auto", "general", "plain" or "tets".
const char* engine_name(EngineChoice engine);

/// How a body is stepped, and what it has beside the problem's masses and shares of damping.
struct MotionStepping {
  dynamics::IntegratorKind integrator = dynamics::IntegratorKind::kSymplecticEuler;
  bool is_exponential = false;        ///< the exact steps of modes; `integrator` says nothing then
  std::optional<double> time_step_s;  ///< nothing: the predicted bound times `safety`
  double safety = 0.9;
  EngineChoice engine = EngineChoice::kAuto;
  bool single_precision = false;  ///< of the plain engine or the tet engine
  bool allow_unstable = false;    ///< take a step over the predicted bound all the same
  std::optional<double> speed_limit_m_s;
  std::uint64_t frames = 50;  ///< intervals between frames; 0: none
  /// Of the integrators that iterate within a step: here each step is to be solved.
  dynamics::StepSolverOptions solver{1000, 1e-8};
  std::size_t substeps = 1;  ///< xpbd, vbd: each step is taken as so many

  std::optional<double> mass_per_vertex_kg;  ///< nothing: a quarter of each tet's mass at its vertices
  double damping_spring_n_s_per_m = 0.0;     ///< of each spring, beside the share of its stiffness
  double damping_vertex_n_s_per_m = 0.0;     ///< of each vertex, beside the share of its mass
  dynamics::SpringDamping spring_damping = dynamics::SpringDamping::kAxial;
};

/// What the stepping of modes is called where an integrator is named.
inline constexpr const char* kExponential = "exponential";
/// The model of modes.
inline constexpr const char* kModalModel = "reduced.modal";

/// The model that moves: springs.NAME, smoothed.NAME or reduced.modal with the options that make it.
struct MovingModel {
  std::string method;
  nlohmann::json options = nlohmann::json::object();
  /// The volume force is that of springs of this stiffness, in N/m, whatever springs the model has.
  std::optional<double> volume_force_of_n_per_m;
  bool is_material = true;  ///< false: its constants are not meant to be the material's, and nothing is noted
};

struct MovingBody {
  MotionProblem motion;
  MovingModel model;
  MotionStepping stepping;
};

/// The body as JSON (palpate/moving_body/1):
///
///   {"schema": "palpate/moving_body/1", "motion": {palpate/motion_problem/1},
///    "model": {"method": "springs.van_gelder", "options": {...}, "volume_force_of_n_per_m": 100,
///              "is_material": true},
///    "stepping": {"integrator": "symplectic_euler", "time_step_s": 1e-4, "safety": 0.9, "engine": "auto",
///                 "precision": "double", "allow_unstable": false, "speed_limit_m_s": 1, "frames": 50,
///                 "mass_per_vertex_kg": 1, "damping_spring_n_s_per_m": 0, "damping_vertex_n_s_per_m": 0,
///                 "spring_damping": "axial", "iterations": 1000, "tolerance": 1e-8, "substeps": 1}}
///
/// What is optional and not there is left out; the last three may be, too. The integrator of modes is
/// "exponential".
nlohmann::json moving_body_to_json(const MovingBody& body);

/// Reads it back and checks it: the motion as motion_from_json, names that are known, numbers that are finite
/// and have a sense. The model's own options are checked by who builds it. Throws: InputError that starts
/// with `where`.
MovingBody moving_body_from_json(const nlohmann::json& json, const TetMesh& mesh, const std::string& where);

/// What a request of the contest engine asks: the mesh in metres and its body.
struct MovingTask {
  TetMesh mesh;
  MovingBody body;
};

/// Reads both files of a request. Throws: InputError, also for a request of another contest.
MovingTask read_moving_task(const Request& request);

}  // namespace palpate::reference

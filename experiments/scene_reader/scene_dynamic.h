// The dynamic part of a scene: how a body moves and what is written of it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/dynamics/motion/time_profile.h"
#include "experiments/text/yaml_value.h"
#include "reference/door/moving_body.h"

namespace palpate::experiments {

/// `analysis: {dynamic: ...}`: how the body is stepped, and what is written of its motion.
struct SceneDynamic : reference::MotionStepping {
  double duration_s = 0.0;
  /// Damping by shares: c = stiffness_s x k of each spring and strain energy, gamma = mass_per_s x m of each
  /// vertex (Rayleigh's).
  double damping_stiffness_s = 0.0;
  double damping_mass_per_s = 0.0;
  std::uint64_t samples = 1000;  ///< intervals between rows of history.csv, at most
  std::vector<Vec3> probes_m;    ///< the vertices nearest to these points are written to history.csv
  std::string preset;            ///< empty: none
  bool has_solver = false;       ///< that is given
  bool has_safety = false;       ///< that is given
};

/// The name of the thesis's parameters, Table 4.1, as a preset.
inline constexpr const char* kThesisPreset = "thesis_table_4_1";

/// Table 4.1 of the thesis, which has no units. Read in SI, with the unit of length of the volume force and
/// of the speed limit being half the longest side of the mesh's box (positions in [-1, 1], 4.2.2): forces of
/// springs, damping and masses are the same whatever the unit of length.
struct ThesisTable {
  static constexpr double kMassKg = 1.0;
  static constexpr double kStiffnessNPerM = 100.0;
  static constexpr double kSpringDampingNSPerM = 500.0;
  static constexpr double kVertexDampingNSPerM = 800.0;
  static constexpr double kVolumeForceRatio = 1.0;  ///< m_kv / k_s = 100 / 100
  static constexpr double kTimeStepS = 3e-4;
  static constexpr double kSpeedLimit = 20.0;  ///< halves of the longest side a second
};

/// Reads the mapping below `dynamic`. Throws: InputError for a step, mass, duration or damping that makes no
/// sense, an unknown integrator or preset (with the nearest), and keys that a preset sets by itself.
SceneDynamic read_dynamic(const YamlValue& value);

/// Reads {times_s: [...], shares: [...], smooth: true}. Throws: InputError.
dynamics::TimeProfile read_profile(const YamlValue& value);

}  // namespace palpate::experiments

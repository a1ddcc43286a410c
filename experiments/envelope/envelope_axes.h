// The axes along which a fitted scene is taken to extremes, and the scene at a place on one.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace palpate::experiments {

enum class EnvelopeAxis {
  kStiffer,  ///< Young's modulus times the factor
  kLighter,  ///< density over the factor
  kLarger,   ///< all loads times the factor, at large strain
  kFaster,   ///< times of the loads over the factor
  kStep      ///< time step times the factor
};

inline constexpr std::array kEnvelopeAxes{EnvelopeAxis::kStiffer, EnvelopeAxis::kLighter,
                                          EnvelopeAxis::kLarger, EnvelopeAxis::kFaster, EnvelopeAxis::kStep};

/// "stiffer", "lighter", "larger", "faster", "step".
const char* axis_name(EnvelopeAxis axis);

/// What is changed, for people: "Young's modulus times".
const char* axis_text(EnvelopeAxis axis);

/// The greatest factor that is looked at.
double most_factor(EnvelopeAxis axis);

/// Whether the factor changes the body at rest, and whether it changes its motion.
bool changes_rest(EnvelopeAxis axis, const nlohmann::json& scene);

/// The axes that mean something for a scene (palpate/scene/1): at rest stiffer and larger; in motion all, but
/// faster only where a load has times.
std::vector<EnvelopeAxis> axes_of(const nlohmann::json& scene);

/// The scene at `factor` along an axis. A time step is in it only if the scene has one in seconds: see
/// with_fixed_step (experiments/trials/motion_trial.h). Requires: a scene that read_scene accepts.
nlohmann::json scaled_scene(const nlohmann::json& scene, EnvelopeAxis axis, double factor);

/// What a scene is in the units of its axes; what a scene is compared by.
struct EnvelopePlace {
  double young_modulus_pa = 0.0;
  double density_kg_m3 = 0.0;
  double poisson_ratio = 0.0;
  std::vector<std::string> load_kinds;  ///< "gravity", "displace", "force", in order
  std::vector<double> load_sizes;       ///< m/s^2, m, N
  std::optional<double> rise_s;         ///< the shortest time between two shares of a load that differ
  std::optional<double> step_s;
};

/// Of a scene that read_scene accepts. `auto` steps are none.
EnvelopePlace place_of(const nlohmann::json& scene);

/// The factor along each axis from one place to another, 1 or less where it is not beyond:
///
///   stiffer  E / E0
///   lighter  rho0 / rho
///   larger   the greatest over the loads of size / size0, a force's also times E0 / E, gravity's times
///            (E0 / E) (rho / rho0): what it does to the strain
///   faster   rise0 / rise
///   step     (h / h0) sqrt((E / E0) (rho0 / rho)): a step is long for the waves of the body
///
/// Nothing where the two are of different kinds (other loads, another Poisson's ratio).
struct EnvelopeFactors {
  std::array<std::optional<double>, kEnvelopeAxes.size()> factor;
  std::string why_none;  ///< empty if the places can be compared
};
EnvelopeFactors factors_between(const EnvelopePlace& from, const EnvelopePlace& to);

}  // namespace palpate::experiments

// How a fitted scene's motion is stepped: which integrator, at which step, and what that costs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace palpate::experiments {

/// What all others are held against.
inline constexpr const char* kExplicitIntegrator = "symplectic_euler";

/// An integrator as a fit tries it; of a model of modes, how many of them.
struct FitStepping {
  std::string label;
  std::string integrator;                 ///< as a scene names it
  bool single_precision = false;          ///< of the plain engine or the tet engine
  nlohmann::json solver;                  ///< as a scene has it; null: its own
  std::optional<std::size_t> modes{};     ///< of reference::kExponential: how many of the lowest
  std::vector<std::string> may_change{};  ///< what may change without a new set-up: of changeable_things()

  /// What of `needs` may not change without a new set-up, the first; empty if all may. What is no thing that
  /// changes (large_strain) is a matter of models.
  std::string cannot(const std::vector<std::string>& needs) const;

  /// Puts it into a moving scene, with this step (s, or "auto") in place of the scene's. Integrator,
  /// precision, engine and solver of the scene are replaced, and the number of its model's modes.
  void apply(const nlohmann::json& step, nlohmann::json& scene) const;
};

/// What a run of the motion at one step came to.
struct SteppedMotion {
  double cost_s = 0.0;  ///< time of the clock for a simulated second; of one that was cut short, at least
  std::optional<double>
      error;           ///< what the step leaves of the motion, relative; nothing where it did not end
  std::string ending;  ///< empty, or what ended it: "diverged", "timed_out", why it was refused
  std::uint64_t memory_bytes = 0;  ///< the most that the run took; 0: not measured
};

/// What came of an integrator.
struct SteppingTry {
  FitStepping stepping;
  double step_s = 0.0;              ///< the last that was looked at
  bool is_auto = false;             ///< it is the one that `time_step_s: auto` takes
  std::optional<double> error;      ///< of that step
  std::vector<double> cost_s;       ///< of that step, one a run
  std::string why_not;              ///< empty: verified at that step
  std::optional<double> setup_s{};  ///< of modes: what they take to be found, which is in no cost
  std::uint64_t memory_bytes = 0;   ///< the most that its runs took; 0: not measured

  /// The median; infinite without a run.
  double cost() const;
};

/// Looks for the longest step of an integrator that leaves at most `most_error`: from `longest_s` on by
/// halves, no shorter than `shortest_s`. It is given up where a run cannot be started, or takes more than
/// `most_cost_s` a simulated second with an error that is too large: shorter ones take longer still. Errors
/// decide what holds, times alone what is not looked at any more.
SteppingTry find_step(const FitStepping& stepping, double longest_s, double shortest_s, double most_error,
                      double most_cost_s, const std::function<SteppedMotion(double step_s)>& run);

/// "takes 900000 bytes, over 500000"; empty where it does not, or nothing was measured or asked.
std::string over_memory(std::uint64_t bytes, const std::optional<std::uint64_t>& most);

/// The cheapest that is verified, the first of equals; null if none is.
const SteppingTry* choose_stepping(const std::vector<SteppingTry>& tries);

}  // namespace palpate::experiments

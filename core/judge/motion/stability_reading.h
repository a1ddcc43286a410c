// The judge's reading of a run at one time step: what became of the body, and whether the step was too long.
// It sees the run's history and its last displacement, never what the contestant calls them, and shares
// nothing with core/dynamics.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// A body at one step of a run, and the greatest energies since the row before. NaN: there is no number.
struct HistoryRow {
  std::uint64_t step = 0;
  double time_s = 0.0;
  double kinetic_j = 0.0;
  double elastic_j = 0.0;
  double load_j = 0.0;
  double most_kinetic_j = 0.0;  ///< since the row before, this step too
  double most_total_j = 0.0;    ///< of kinetic + elastic + load, alike
  double least_total_j = 0.0;
  double farthest_m = 0.0;     ///< largest displacement
  std::uint64_t inverted = 0;  ///< tets that are not positive
  bool is_finite = true;       ///< all displacements and velocities are numbers
  std::uint64_t unsolved = 0;  ///< steps so far whose solver did not come to its tolerance
};

/// A run of `steps` steps of `step_s`, as an answer has it. Its rows begin with step 0 and end where the run
/// ended.
struct RunHistory {
  double step_s = 0.0;
  std::uint64_t steps = 0;    ///< that it was to take
  bool says_growing = false;  ///< the contestant itself says that small motions grow with this step
  std::vector<HistoryRow> rows;
  std::vector<Vec3> displacement_m;  ///< at the last row, one a vertex; NaN where there is no number
};

/// How a run ended. E is the total energy over the least of the run, K the greatest kinetic energy of a
/// stretch, the quarters are those of the steps; the first that holds is the ending:
///
///   kNonFinite      the last displacement or the last row has something that is no number
///   kDiverged       a vertex of the last displacement is more than 1000 sizes of the body away
///   kTooSlow        the rows end before the steps do
///   kEnergyGrowing  E ever exceeds `energy_factor` times what the start had (its E, or its kinetic and
///                   elastic energy if that is more) by more than `noise_j`. Or the body is not still
///                   (below), the greatest E of the last quarter is over 1.1 times that of each earlier one
///                   and over the start's by 0.1% of what it had or moves, and K has grown 1.1 times too
///   kInverted       tets of the last displacement are not positive, by the judge's own count
///   kGrowingSlowly  none of these, but the contestant itself says that small motions grow
///   kSteady         the body is still: K of the last quarter is at most 1e-6 of that of the run, or noise_j
///   kOscillating    it moves on
enum class Ending {
  kSteady,
  kOscillating,
  kEnergyGrowing,
  kDiverged,
  kInverted,
  kNonFinite,
  kTooSlow,
  kGrowingSlowly
};

/// "steady", "oscillating", "energy_growing", "diverged", "inverted", "non_finite", "too_slow",
/// "growing_slowly".
const char* ending_name(Ending ending);

/// Whether the ending says that the step was too long. An inverted body was not driven so by its step alone.
bool is_unstable(Ending ending);

/// Where a run's motion counts as growth, and where as noise.
struct RunBounds {
  double energy_factor = 100.0;  ///< nothing adds energy to a run; bounded ones come to some 25 times
  double noise_j = 0.0;          ///< kinetic energy of a motion that rounding alone explains
};

/// What the history of a run says.
struct RunReading {
  Ending ending = Ending::kSteady;
  std::uint64_t steps = 0;      ///< taken
  std::size_t inverted = 0;     ///< of the last displacement; 0 where that has no numbers
  double farthest_m = 0.0;      ///< of the last displacement; NaN where that has no numbers
  Index vertex = kNoIndex;      ///< the first that is no number or too far away
  double energy_start_j = 0.0;  ///< NaN where there is no number
  double energy_most_j = 0.0;
  double kinetic_end_j = 0.0;  ///< the greatest of the last quarter; NaN if the run did not come so far
};

/// Throws: InputError, which starts with `where`, unless step and rows make a history of this mesh: a step
///         above zero, rows from step 0 on that rise, at least one in each twentieth of the steps up to the
///         last, times that are steps times step_s (to 1e-9), energies of motion that are not negative and
///         not above the greatest, no more inverted tets than there are, a displacement of each vertex,
///         whose farthest is the last row's (to 1e-9).
void check_history(const RunHistory& history, const TetMesh& rest, const std::string& where);

/// Requires: a history that check_history accepts. Cost: O(rows + vertices + tets).
RunReading read_run(const RunHistory& history, const TetMesh& rest, const RunBounds& bounds);

/// Tets with ((b - a) x (c - a)) . (d - a) <= 0 where they are displaced to. Edges are added to differences
/// of displacements, so that a body far from the origin loses nothing. A tet with no numbers counts.
std::size_t count_inverted(const TetMesh& rest, std::span<const Vec3> displacement_m);

/// The longest side of the box around the mesh.
double longest_side(const TetMesh& mesh);

/// The energy of a body that is strained by `rounding` throughout, in J: 3 (lambda + 2 mu) V rounding^2, with
/// Lame's constants of young_pa and poisson, times `stiffness_factor`. A body whose springs carry the
/// material at Poisson's ratio 1/4 has 2.5 times (lambda + 2 mu) V in them, at strain 1.
double rounding_energy(const TetMesh& rest, double young_pa, double poisson, double stiffness_factor,
                       double rounding);

/// A stretch of a trial: its last step, the mean and the greatest kinetic energy over its steps. NaN: no
/// number.
struct TrialStretch {
  std::uint64_t until = 0;
  double mean_kinetic_j = 0.0;
  double most_kinetic_j = 0.0;
};

/// A trial of one step about rest: small random motions, watched in stretches that end at 256, 512, 1024, ...
/// steps.
struct TrialHistory {
  double step_s = 0.0;
  double start_j = 0.0;   ///< kinetic and elastic energy of the start; NaN: there is no number
  bool is_linear = true;  ///< forces are linear, so that growth never ends
  std::vector<TrialStretch> stretches;
};

/// Where a trial's motion counts as growth.
struct TrialBounds {
  double growth_factor = 1e6;     ///< kinetic energy over the start's that is growth for certain
  std::uint64_t horizon = 16384;  ///< steps after which a growth that slows down is none
};

/// What a trial says of its step; kTooShort: nothing yet.
enum class TrialEnding { kStable, kGrows, kTooShort };

/// With M the mean kinetic energy of a stretch and r its ratio to that of the stretch before:
///
///   grows      M is no number or over 1e200 J; a step had over growth_factor times the energy of the start,
///              or one of the two is no number; or, of a linear body, r > 1000 anywhere, or r > 1.02 in the
///              end and no less than the one before
///   stable     M fell below 1e-24 of its greatest; r <= 1.02 in the end, or no linear body; or r is less
///              than the one before at the horizon
///   too short  r is less than the one before sooner, or there is no second stretch
///
/// Throws: InputError, which starts with `where`, unless the stretches end at 256, 512, 1024, ... steps.
TrialEnding read_trial(const TrialHistory& trial, const TrialBounds& bounds, const std::string& where);

}  // namespace palpate::judge

#include "core/judge/motion/stability_reading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/error.h"

namespace palpate::judge {
namespace {

constexpr std::array<const char*, 8> kEndingNames{"steady",   "oscillating",   "energy_growing",
                                                  "diverged", "inverted",      "non_finite",
                                                  "too_slow", "growing_slowly"};
constexpr double kEscapeSizes = 1000.0;
constexpr double kGrowth = 1.1;
constexpr double kVisible = 1e-3;
constexpr double kStill = 1e-6;
constexpr std::uint64_t kFewestParts = 20;
constexpr double kSame = 1e-9;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

bool is_same(double one, double other) {
  return std::abs(one - other) <= kSame * std::max(std::abs(one), std::abs(other));
}

/// Fails unless `holds`.
void check(bool holds, const std::string& where, const std::string& expected, const std::string& found) {
  if (!holds) throw InputError(where, 0, expected, found);
}

void check_row(const HistoryRow& row, const RunHistory& history, std::size_t tets, const std::string& where) {
  const std::string at = where + ", step " + std::to_string(row.step);
  check(row.step <= history.steps, at, "at most " + std::to_string(history.steps) + " steps", "more");
  const double time = static_cast<double>(row.step) * history.step_s;
  check(!std::isfinite(time) || is_same(row.time_s, time), at, "the time " + std::to_string(time) + " s",
        std::to_string(row.time_s) + " s");
  const bool has_sense = !(row.kinetic_j < 0.0) && !(row.most_kinetic_j < row.kinetic_j) &&
                         !(row.most_total_j < row.least_total_j) && !(row.farthest_m < 0.0);
  check(has_sense, at, "energies and lengths that are not negative, none above its greatest", "others");
  check(row.inverted <= tets, at, "at most " + std::to_string(tets) + " inverted tets",
        std::to_string(row.inverted));
}

/// The largest displacement; NaN if one is no number.
double find_farthest(std::span<const Vec3> displacement_m) {
  double farthest = 0.0;
  for (const Vec3& u : displacement_m) {
    if (!is_finite(u)) return kNone;
    farthest = std::max(farthest, length(u));
  }
  return farthest;
}

/// The first vertex that is no number or farther away than `bound`.
Index find_offender(std::span<const Vec3> displacement_m, double bound) {
  for (std::size_t v = 0; v < displacement_m.size(); ++v) {
    if (!is_finite(displacement_m[v]) || !(length(displacement_m[v]) <= bound)) return static_cast<Index>(v);
  }
  return kNoIndex;
}

/// What the rows say of the energies. Rows whose energy is no number are left out.
struct Energies {
  double start = kNone;    ///< total
  double own_start = 0.0;  ///< kinetic and elastic
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
  double most_kinetic = 0.0;
  std::array<double, 4> total{};  ///< greatest of each quarter
  std::array<double, 4> kinetic{};

  explicit Energies(const RunHistory& history) {
    total.fill(-std::numeric_limits<double>::max());
    for (const HistoryRow& row : history.rows) {
      const std::size_t quarter = std::min<std::uint64_t>(3, 4 * row.step / history.steps);
      if (std::isfinite(row.most_kinetic_j))
        kinetic.at(quarter) = std::max(kinetic.at(quarter), row.most_kinetic_j);
      most_kinetic = std::max(most_kinetic, kinetic.at(quarter));
      if (!std::isfinite(row.most_total_j) || !std::isfinite(row.least_total_j)) continue;
      if (row.step == 0) {
        start = row.most_total_j;
        own_start = row.kinetic_j + row.elastic_j;
      }
      total.at(quarter) = std::max(total.at(quarter), row.most_total_j);
      least = std::min(least, row.least_total_j);
      most = std::max(most, row.most_total_j);
    }
  }

  /// What the start had to give.
  double had() const { return std::max((std::isfinite(start) ? start : 0.0) - least, own_start); }

  bool is_still(double noise) const { return kinetic[3] <= std::max(kStill * most_kinetic, noise); }

  bool exceeds(const RunBounds& bounds) const {
    return most - least > bounds.energy_factor * had() + bounds.noise_j && most_kinetic > bounds.noise_j;
  }

  bool grows() const {
    const double before = std::max({total[0], total[1], total[2]}) - least;
    const double moved = std::max(had(), most_kinetic);
    const double first = std::isfinite(start) ? start : 0.0;
    return total[3] - least > kGrowth * std::max(0.0, before) && total[3] - first > kVisible * moved &&
           kinetic[3] > kGrowth * std::max({kinetic[0], kinetic[1], kinetic[2]});
  }
};

Ending find_ending(const RunHistory& history, const RunReading& reading, const Energies& energies,
                   const RunBounds& bounds) {
  const HistoryRow& last = history.rows.back();
  if (!last.is_finite || std::isnan(reading.farthest_m)) return Ending::kNonFinite;
  if (reading.vertex != kNoIndex) return Ending::kDiverged;
  if (last.step < history.steps) return Ending::kTooSlow;
  const bool is_still = energies.is_still(bounds.noise_j);
  if (energies.exceeds(bounds) || (!is_still && energies.grows())) return Ending::kEnergyGrowing;
  if (reading.inverted > 0) return Ending::kInverted;
  if (history.says_growing) return Ending::kGrowingSlowly;
  return is_still ? Ending::kSteady : Ending::kOscillating;
}

}  // namespace

const char* ending_name(Ending ending) {
  return kEndingNames.at(static_cast<std::size_t>(ending));
}

bool is_unstable(Ending ending) {
  return ending == Ending::kEnergyGrowing || ending == Ending::kDiverged || ending == Ending::kNonFinite ||
         ending == Ending::kGrowingSlowly;
}

void check_history(const RunHistory& history, const TetMesh& rest, const std::string& where) {
  check(history.step_s > 0.0 && std::isfinite(history.step_s), where, "a step above zero",
        std::to_string(history.step_s));
  check(history.steps > 0, where, "at least one step", "none");
  check(!history.rows.empty() && history.rows.front().step == 0, where, "rows from step 0 on",
        "none at step 0");
  const std::uint64_t widest = std::max<std::uint64_t>(1, history.steps / kFewestParts);
  for (std::size_t k = 0; k < history.rows.size(); ++k) {
    const HistoryRow& row = history.rows[k];
    check_row(row, history, rest.tets.size(), where);
    if (k == 0) continue;
    const std::uint64_t before = history.rows[k - 1].step;
    check(row.step > before, where, "steps that rise",
          std::to_string(row.step) + " after " + std::to_string(before));
    check(row.step - before <= widest, where, "a row at least every " + std::to_string(widest) + " steps",
          "none between " + std::to_string(before) + " and " + std::to_string(row.step));
    check(history.rows[k - 1].is_finite, where, "no row after one that is not finite", "one");
    check(row.unsolved >= history.rows[k - 1].unsolved, where, "unsolved steps that do not become fewer",
          "fewer");
  }
  check(history.displacement_m.size() == rest.points.size(), where,
        "displacements of " + std::to_string(rest.points.size()) + " vertices",
        std::to_string(history.displacement_m.size()));
  const double farthest = find_farthest(history.displacement_m);
  const double said = history.rows.back().farthest_m;
  check(!std::isfinite(farthest) || is_same(said, farthest), where,
        "the farthest vertex of its last displacement, " + std::to_string(farthest) + " m",
        std::to_string(said) + " m");
}

RunReading read_run(const RunHistory& history, const TetMesh& rest, const RunBounds& bounds) {
  const Energies energies(history);
  RunReading out;
  out.steps = history.rows.back().step;
  out.farthest_m = find_farthest(history.displacement_m);
  out.vertex = find_offender(history.displacement_m, kEscapeSizes * longest_side(rest));
  if (std::isfinite(out.farthest_m)) out.inverted = count_inverted(rest, history.displacement_m);
  out.energy_start_j = energies.start;
  out.energy_most_j = energies.most;
  out.kinetic_end_j = out.steps == history.steps ? energies.kinetic[3] : kNone;
  out.ending = find_ending(history, out, energies, bounds);
  return out;
}

std::size_t count_inverted(const TetMesh& rest, std::span<const Vec3> displacement_m) {
  require(displacement_m.size() == rest.points.size(), "a displacement of each vertex");
  std::size_t count = 0;
  for (const Tet& tet : rest.tets) {
    const auto edge = [&](std::size_t k) {
      return (rest.points[tet.at(k)] - rest.points[tet[0]]) +
             (displacement_m[tet.at(k)] - displacement_m[tet[0]]);
    };
    if (!(dot(cross(edge(1), edge(2)), edge(3)) > 0.0)) ++count;
  }
  return count;
}

double longest_side(const TetMesh& mesh) {
  if (mesh.points.empty()) return 0.0;
  Vec3 low = mesh.points.front();
  Vec3 high = low;
  for (const Vec3& p : mesh.points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

double rounding_energy(const TetMesh& rest, double young_pa, double poisson, double stiffness_factor,
                       double rounding) {
  double six_volumes = 0.0;
  for (const auto& [a, b, c, d] : rest.tets) {
    const Vec3 origin = rest.points[a];
    six_volumes += dot(cross(rest.points[b] - origin, rest.points[c] - origin), rest.points[d] - origin);
  }
  const double lambda = young_pa * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
  const double mu = young_pa / (2.0 * (1.0 + poisson));
  return 3.0 * (std::abs(lambda) + 2.0 * mu) * stiffness_factor * (six_volumes / 6.0) * rounding * rounding;
}

TrialEnding read_trial(const TrialHistory& trial, const TrialBounds& bounds, const std::string& where) {
  constexpr std::uint64_t kFirst = 256;
  constexpr double kFast = 1000.0;
  constexpr double kSlow = 1.02;
  constexpr double kGone = 1e-24;
  constexpr double kHuge = 1e200;
  std::uint64_t until = kFirst;
  for (const TrialStretch& stretch : trial.stretches) {
    check(stretch.until == until, where, "a stretch that ends at step " + std::to_string(until),
          std::to_string(stretch.until));
    until *= 2;
  }
  double greatest = 0.0;
  double before = 0.0;
  double last_ratio = kSlow;
  for (std::size_t k = 0; k < trial.stretches.size(); ++k) {
    const TrialStretch& stretch = trial.stretches[k];
    const double now = stretch.mean_kinetic_j;
    if (!(now < kHuge) || !(stretch.most_kinetic_j <= bounds.growth_factor * trial.start_j))
      return TrialEnding::kGrows;
    greatest = std::max(greatest, now);
    if (k == 0) {
      before = now;
      continue;
    }
    if (trial.is_linear && now > kFast * before) return TrialEnding::kGrows;
    if (now <= kGone * greatest) return TrialEnding::kStable;
    const bool is_last = k + 1 == trial.stretches.size();
    if (is_last && (!trial.is_linear || now <= kSlow * before)) return TrialEnding::kStable;
    if (is_last && now >= last_ratio * before) return TrialEnding::kGrows;
    if (is_last && stretch.until >= bounds.horizon) return TrialEnding::kStable;
    last_ratio = std::max(kSlow, now / before);
    before = now;
  }
  return TrialEnding::kTooShort;
}

}  // namespace palpate::judge

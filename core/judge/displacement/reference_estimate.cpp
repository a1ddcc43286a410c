#include "core/judge/displacement/reference_estimate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/error.h"
#include "core/judge/mesh/compensated_sum.h"

namespace palpate::judge {
namespace {

constexpr double kLowestOrder = 1.0;
constexpr double kHighestOrder = 4.0;
/// Of the maximum and the energy: half of that of the L2 norm where a singular edge decides.
constexpr double kLowestLocalOrder = 0.5;
constexpr double kLeastAlignment = 0.5;
/// Differences this small beside the field are the solvers' own noise: there is nothing to extrapolate.
constexpr double kNoise = 1e-7;

std::vector<Vec3> subtract(std::span<const Vec3> a, std::span<const Vec3> b) {
  std::vector<Vec3> difference(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) difference[i] = a[i] - b[i];
  return difference;
}

/// x = 2^p - 1 of an order.
double growth_of(double order) {
  return std::exp2(order) - 1.0;
}

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

/// What the last three (or fewer) levels say, in absolute terms.
struct Differences {
  std::vector<Vec3> last;      ///< finest - next
  DisplacementSize last_size;  ///< of it
  bool has_previous = false;
  DisplacementSize previous;  ///< of the difference before
  double alignment = 0.0;     ///< cosine between the two; 0 if one of them is 0
};

Differences measure_differences(const TetMesh& mesh, std::span<const std::vector<Vec3>> levels, double lambda,
                                double mu) {
  const std::size_t count = levels.size();
  Differences found;
  found.last = subtract(levels[count - 1], levels[count - 2]);
  found.last_size = measure_displacement(mesh, found.last, lambda, mu);
  if (count < 3) return found;
  const std::vector<Vec3> before = subtract(levels[count - 2], levels[count - 3]);
  found.has_previous = true;
  found.previous = measure_displacement(mesh, before, lambda, mu);
  const std::vector<double> share = volume_shares(mesh, before.size());
  CompensatedSum product;
  for (std::size_t i = 0; i < before.size(); ++i) product.add(share[i] * dot(before[i], found.last[i]));
  const double lengths = found.previous.l2 * found.last_size.l2;
  if (lengths > 0.0) found.alignment = std::clamp(product.value() / lengths, -1.0, 1.0);
  return found;
}

/// What is done with the levels, and the line that says so.
struct Decision {
  enum class Bound { kNone, kMixture, kLargerDifference } bound = Bound::kNone;
  std::optional<double> growth;  ///< x = 2^p - 1 by which to extrapolate
  std::optional<double> order;
  std::string rule;
};

Decision decide_two(const ReferenceOptions& options) {
  Decision decision;
  decision.bound = Decision::Bound::kMixture;
  if (!options.stated_order) {
    decision.rule = "two levels, no order stated: the finer one, with their difference as its error";
    return decision;
  }
  decision.order = *options.stated_order;
  decision.growth = growth_of(*options.stated_order);
  decision.rule = "two levels, extrapolated with the stated order " + text_of(*options.stated_order);
  return decision;
}

Decision decide_three(const Differences& found, double whole) {
  Decision decision;
  const double previous = found.previous.l2;
  const double last = found.last_size.l2;
  if (std::max(previous, last) <= kNoise * whole) {
    decision.bound = Decision::Bound::kLargerDifference;
    decision.rule = "the levels agree to solver noise: the finest, with the larger difference as its error";
    return decision;
  }
  if (!(previous > last) || last <= kNoise * whole) {
    decision.rule = previous > last ? "the two finest levels are the same: no estimate"
                                    : "the differences do not shrink: the finest, without an estimate";
    return decision;
  }
  decision.order = std::log2(previous / last);
  if (!(found.alignment >= kLeastAlignment)) {
    decision.bound = Decision::Bound::kLargerDifference;
    decision.rule = "the differences point elsewhere (alignment " + text_of(found.alignment) +
                    "): the finest, with the larger difference as its error";
    return decision;
  }
  decision.bound = Decision::Bound::kMixture;
  const std::string order = "observed order " + text_of(*decision.order);
  if (*decision.order < kLowestOrder || *decision.order > kHighestOrder) {
    decision.rule = order + " is not within 1 and 4: the finest";
    return decision;
  }
  decision.growth = growth_of(*decision.order);
  decision.rule = "extrapolated with the " + order;
  return decision;
}

/// The error in one figure, of which `last` and `previous` (nothing of two levels) are the differences and
/// `lowest_order` is the least order of any part of the error.
std::optional<double> bound_of(const Decision& decision, double last, std::optional<double> before,
                               double lowest_order) {
  const double previous = before.value_or(0.0);
  if (decision.bound == Decision::Bound::kNone) return std::nullopt;
  if (decision.bound == Decision::Bound::kLargerDifference) return std::max(last, previous);
  if (before) {
    if (!(previous > last)) return std::nullopt;
    last = std::max(last, previous / std::exp2(kHighestOrder));
    lowest_order = std::min(lowest_order, std::log2(previous / last));
  }
  const double lowest = growth_of(lowest_order);
  if (!decision.growth) return last / lowest;
  const double x = *decision.growth;
  return last * std::max(1.0 / x, 1.0 / lowest - 1.0 / x);
}

std::optional<double> over(std::optional<double> value, double whole) {
  if (!value || !(whole > 0.0)) return std::nullopt;
  return *value / whole;
}

/// The errors at the chosen points, by the same decision: how the levels converge is told by the whole body.
void bound_chosen(const TetMesh& mesh, std::span<const std::vector<Vec3>> levels, const Decision& decision,
                  const ChosenPoints& chosen, ReferenceEstimate& estimate) {
  const std::size_t count = levels.size();
  const ChosenSize whole = measure_chosen(mesh, estimate.field, chosen);
  const ChosenSize last = measure_chosen(mesh, subtract(levels[count - 1], levels[count - 2]), chosen);
  std::optional<ChosenSize> previous;
  if (count >= 3) previous = measure_chosen(mesh, subtract(levels[count - 2], levels[count - 3]), chosen);
  const auto bound = [&](double ChosenSize::*figure) {
    const auto before = previous ? std::optional((*previous).*figure) : std::nullopt;
    return over(bound_of(decision, last.*figure, before, kLowestLocalOrder), whole.*figure);
  };
  estimate.error.chosen_l2 = bound(&ChosenSize::l2);
  estimate.error.chosen_deformation = bound(&ChosenSize::deformation);
  estimate.error.chosen_max = bound(&ChosenSize::max);
}

void check_levels(std::span<const std::vector<Vec3>> levels, const ReferenceOptions& options) {
  require(!levels.empty(), "estimate_reference: no level");
  for (const std::vector<Vec3>& level : levels) {
    require(level.size() == levels[0].size(), "estimate_reference: levels of different sizes");
    require_finite(level, "reference displacement");
  }
  if (options.stated_order &&
      !(*options.stated_order >= kLowestOrder && *options.stated_order <= kHighestOrder))
    throw InputError("stated order of the reference", 0, "a number from 1 to 4",
                     text_of(*options.stated_order));
}

}  // namespace

std::string reference_kind_name(ReferenceKind kind) {
  return kind == ReferenceKind::kExtrapolated ? "extrapolated" : "finest";
}

ReferenceEstimate estimate_reference(const TetMesh& mesh, std::span<const std::vector<Vec3>> levels,
                                     double lambda_pa, double mu_pa, const ReferenceOptions& options) {
  check_levels(levels, options);
  ReferenceEstimate estimate;
  estimate.levels = levels.size();
  estimate.field = levels.back();
  const double finest = measure_displacement(mesh, estimate.field, lambda_pa, mu_pa).l2;
  if (!(finest > 0.0))
    throw InputError("reference displacement", 0, "a body that moves", "zero displacements");
  if (levels.size() == 1) {
    estimate.rule = "one level: as it is, without an estimate";
    return estimate;
  }

  const Differences found = measure_differences(mesh, levels, lambda_pa, mu_pa);
  const Decision decision = found.has_previous ? decide_three(found, finest) : decide_two(options);
  if (decision.growth) {
    estimate.kind = ReferenceKind::kExtrapolated;
    for (std::size_t i = 0; i < estimate.field.size(); ++i)
      estimate.field[i] = estimate.field[i] + (1.0 / *decision.growth) * found.last[i];
  }
  estimate.order = decision.order;
  if (found.has_previous) estimate.alignment = found.alignment;
  estimate.rule = decision.rule;

  const DisplacementSize whole = measure_displacement(mesh, estimate.field, lambda_pa, mu_pa);
  const auto bound = [&](double DisplacementSize::*figure, double lowest_order) {
    const auto before = found.has_previous ? std::optional(found.previous.*figure) : std::nullopt;
    return over(bound_of(decision, found.last_size.*figure, before, lowest_order), whole.*figure);
  };
  estimate.error.relative_l2 = bound(&DisplacementSize::l2, kLowestOrder);
  estimate.error.relative_deformation = bound(&DisplacementSize::deformation, kLowestOrder);
  estimate.error.relative_max = bound(&DisplacementSize::max, kLowestLocalOrder);
  estimate.error.relative_energy = bound(&DisplacementSize::energy, kLowestLocalOrder);
  if (options.chosen) bound_chosen(mesh, levels, decision, *options.chosen, estimate);
  if (found.has_previous) estimate.difference.push_back(found.previous.l2 / whole.l2);
  estimate.difference.push_back(found.last_size.l2 / whole.l2);
  return estimate;
}

ReferenceAgreement compare_references(const TetMesh& mesh, const ReferenceEstimate& first,
                                      const ReferenceEstimate& second, double lambda_pa, double mu_pa) {
  ReferenceAgreement found;
  found.relative_l2 = compare_displacement(mesh, second.field, first.field, lambda_pa, mu_pa).relative_l2;
  if (!first.error.relative_l2 || !second.error.relative_l2) return found;
  // The second error is relative to the second field, which is at most so much larger.
  found.expected = *first.error.relative_l2 + *second.error.relative_l2 * (1.0 + found.relative_l2);
  found.agree = found.relative_l2 <= *found.expected;
  return found;
}

bool is_reference_too_coarse(double judged_error, const std::optional<double>& reference_error) {
  return !reference_error || !(judged_error >= kReferenceMargin * *reference_error);
}

}  // namespace palpate::judge

// How good is the reference? From the same problem solved on a mesh and its uniform refinements.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/judge/displacement/chosen_points.h"
#include "core/judge/displacement/displacement.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// What the reference is.
enum class ReferenceKind {
  kExtrapolated,  ///< Richardson: finest + (finest - next) / (2^p - 1)
  kFinest,        ///< the finest level as it is
};

/// "extrapolated", "finest".
std::string reference_kind_name(ReferenceKind kind);

/// The error of a reference in the figures of DisplacementError and ChosenError, each relative to the
/// reference itself; nothing where there is no estimate.
struct ReferenceError {
  std::optional<double> relative_l2;
  std::optional<double> relative_deformation;
  std::optional<double> relative_max;
  std::optional<double> relative_energy;
  /// Those of ChosenError; nothing, too, where no points were chosen.
  std::optional<double> chosen_l2{};
  std::optional<double> chosen_deformation{};
  std::optional<double> chosen_max{};
};

/// The reference and what is known of its error.
struct ReferenceEstimate {
  std::vector<Vec3> field;  ///< to judge by, at the points of the levels
  ReferenceKind kind = ReferenceKind::kFinest;
  std::size_t levels = 0;
  std::optional<double> order;      ///< observed (three levels) or stated (two), in the L2 norm
  std::optional<double> alignment;  ///< cosine between the last two differences: 1 if they point the same way
  std::vector<double> difference;   ///< |u_(k+1) - u_k| / |field| in L2, one fewer than levels
  ReferenceError error;
  std::string rule;  ///< one line: which rule was taken, and why
};

/// What a caller knows beforehand.
struct ReferenceOptions {
  /// Order for two levels, from 1 to 4; without it they are not extrapolated. Three levels observe their own.
  std::optional<double> stated_order;
  /// Vertices at which alone the error is wanted, too.
  std::optional<ChosenPoints> chosen{};
};

/// Makes the reference from the displacements of one method on h, h/2 (and h/4, ...), all given at the same
/// points, coarsest first: the vertices of `mesh` (n rows) or its quadratic nodes (n + e rows, see
/// displacement.h). Only the last three levels are used.
///
/// With D = |u_f - u_c| (the two finest), R = |previous difference| / D, p = log2 R, x = 2^p - 1:
///   three levels: extrapolated if 1 <= p <= 4 and the differences point the same way (alignment >= 1/2);
///   two levels:   extrapolated if an order is stated; else the finest;
///   one level:    that level, and no estimate.
/// Error: extrapolated, max(1/x, 1/x0 - 1/x) D; finest, D / x0; x0 = 2^p0 - 1. It is no less than the true
/// error for any sum of terms a_i h^(p_i) with p_i >= p0 whose a_i point the same way or across. p0 is 1 in
/// the L2 norm, with rigid motions or without, 1/2 for maximum, energy and chosen points (the edge of a hard
/// clamp), or the order observed in that figure if it is less. A last difference below 1/16 of the one before
/// counts as 1/16 of it (order 4). Where the differences point elsewhere, the error is the larger one; where
/// they do not shrink, there is no estimate. docs/judge.md has the proof.
///
/// Throws: ContractError for no level or other sizes; InputError for values that are not finite, a field that
/// is zero, or a stated order outside [1, 4].
ReferenceEstimate estimate_reference(const TetMesh& mesh, std::span<const std::vector<Vec3>> levels,
                                     double lambda_pa, double mu_pa, const ReferenceOptions& options = {});

/// Two references that were made by different ways, such as P1 and P2, on the same mesh and its refinements.
struct ReferenceAgreement {
  double relative_l2 = 0.0;        ///< |first - second| / |first|
  std::optional<double> expected;  ///< the sum of their errors, if both have one
  /// False if they are farther apart than their errors allow: then at least one of them solves another
  /// problem, or its error is too small.
  bool agree = false;
};

/// Holds two references against each other. A reference that is wrong in a way that refining does not change
/// (another material, another load, a factor) has an estimate as small as a right one: only this finds it.
/// Throws: ContractError for other sizes, InputError for a field that is zero or not finite.
ReferenceAgreement compare_references(const TetMesh& mesh, const ReferenceEstimate& first,
                                      const ReferenceEstimate& second, double lambda_pa, double mu_pa);

/// A reference must be so many times better than the error that it judges.
inline constexpr double kReferenceMargin = 5.0;

/// Whether a row has to be marked: its reference has no estimate, or is not kReferenceMargin times better.
bool is_reference_too_coarse(double judged_error, const std::optional<double>& reference_error);

}  // namespace palpate::judge

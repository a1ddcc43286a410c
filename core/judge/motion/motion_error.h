// The judge's figures of a motion: how far a history is from that of a reference, by arithmetic of its own.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace palpate::judge {

/// Values at `at`, from samples at rising times: straight between neighbours. Before the first and after the
/// last time the first and the last value. Throws: ContractError for other sizes or no samples.
std::vector<double> sample_straight(std::span<const double> time_s, std::span<const double> value,
                                    std::span<const double> at_s);

/// The same with the cubic polynomial through the two samples on each side, for smooth signals: the error
/// falls with the fourth power of the time between samples.
std::vector<double> sample_smooth(std::span<const double> time_s, std::span<const double> value,
                                  std::span<const double> at_s);

/// sqrt( integral |x - r|^2 dt / integral |r|^2 dt ) of signals with one or several components, all sampled
/// at `time_s`; integrals by the trapezoidal rule. Nothing if the reference is zero throughout. Throws:
/// ContractError for other sizes.
std::optional<double> history_error(std::span<const double> time_s,
                                    std::span<const std::vector<double>> signal,
                                    std::span<const std::vector<double>> reference);

/// The direction, of length 1, along which a path spreads most about its mean: the eigenvector of its
/// covariance with the largest eigenvalue, its largest component positive. Nothing if the path stands still.
std::optional<Vec3> main_direction(std::span<const Vec3> path);

/// f / r - 1 for each pair, in order; a reference frequency below `rigid_hz` counts as a rigid motion and is
/// left out. Throws: ContractError for other sizes.
std::vector<double> frequency_errors(std::span<const double> found_hz, std::span<const double> reference_hz,
                                     double rigid_hz);

}  // namespace palpate::judge

// The two ends of the spectrum of a stiffness, without its rigid motions.
#pragma once

#include <optional>
#include <span>

#include "core/judge/linear_elements/elastic_blocks.h"

namespace palpate::judge {

/// The greatest eigenvalue of K x = lambda B x, B of diagonal blocks that are symmetric and positive, by
/// Lanczos's method in the inner product of B (no reorthogonalisation: copies of an eigenvalue do no harm at
/// the end of a spectrum). Good to 1e-4: it stops where ten steps change it by less than 1e-6.
double greatest_eigenvalue(const BlockRows& stiffness, std::span<const Block> blocks);

/// The least eigenvalue of K x = lambda B x that is not zero, K being the stiffness of one free body at
/// `points`, by subspace iteration from `start`, fields that are not all rigid motions. Good to 1e-3.
///
/// Returns:  nothing if a solve or the iteration did not converge.
std::optional<double> least_elastic_eigenvalue(const BlockRows& stiffness,
                                               std::span<const Block> inverse_diagonal,
                                               std::span<const Block> blocks, std::span<const Vec3> points,
                                               const FieldBlock& start);

}  // namespace palpate::judge

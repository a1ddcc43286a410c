// The lowest natural modes of a body at rest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/dynamics/motion/motion_model.h"

namespace palpate::dynamics {

/// Undamped modes K x = omega^2 M x.
///
/// Shape:  as many frequencies (in Hz, rising) as modes; each mode has one vector a vertex, and x^T M x = 1.
struct NaturalModes {
  std::vector<double> frequency_hz;
  std::vector<std::vector<Vec3>> modes;
  bool converged = false;
};

/// The `count` lowest modes of small motions about rest, with all supports and without the held components;
/// rigid motions come first, at zero. Spectra's restarted Lanczos method on (K - s)^-1 of the mass-scaled
/// stiffness, s slightly below zero, factored by Eigen's sparse Cholesky method. The volume force has no part
/// in it.
///
/// Throws: InputError for count = 0 or more modes than the body has components that are free, less one;
///         as validate(MotionModel).
NaturalModes find_lowest_modes(const MotionModel& model, std::size_t count);

/// The same of a stiffness in N/m; bit i of held[v]: axis i of row v is held. Requires: one mass above zero a
/// row.
NaturalModes find_lowest_modes(const BlockMatrix& stiffness, std::span<const double> mass_kg,
                               std::span<const std::uint8_t> held, std::size_t count);

/// x^T D x of damping matrices in the shape of a mode, in N s/m: of springs with 1 N s/m each, along their
/// directions at rest; of vertices with 1 N s/m each; x^T M x is 1. `stiffness` is x^T K x of the body
/// without its supports, in N/m.
struct ModeShares {
  double springs = 0.0;
  double vertices = 0.0;
  double stiffness = 0.0;
};
/// The shares of a mode (one entry a vertex) that has x^T M x = 1.
ModeShares measure_mode(const MotionModel& model, const std::vector<Vec3>& mode);

}  // namespace palpate::dynamics

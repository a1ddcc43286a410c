// Bodies in motion that the tests of core/dynamics share.
#pragma once

#include <cstdint>
#include <vector>

#include "core/dynamics/elasticity/volume_models.h"
#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/motion/motion_model.h"

namespace palpate::testing_support {

/// A mass on a spring along x whose other end (vertex 0) is held:  x'' = -omega^2 x - damping x'. Mass 2 kg,
/// length 1 m.
dynamics::MotionModel make_oscillator(double omega_per_s, double damping_per_s);

/// Its displacement at time t after it was let go at `start_m` without speed. Underdamped alone.
double oscillator_at(double omega_per_s, double damping_per_s, double start_m, double time_s);

/// No loads: a free body of `mesh` with springs of E = 1 kPa, density 1000 kg/m^3 and axial damping
/// `damping_s` x stiffness. Large strain. `volume` needs nu = 0.4, so that springs carry their share.
dynamics::MotionModel make_free_body(const TetMesh& mesh, double damping_s,
                                     dynamics::VolumeModel volume = dynamics::VolumeModel::kNone);

/// The body under gravity with its lowest layer (z = 0) held and its top (z = 1) moved by (0.1, 0, -0.1)
/// along a smooth profile in `duration_s`. The mesh is a unit cube.
dynamics::MotionModel make_pressed_body(const TetMesh& mesh, double duration_s,
                                        dynamics::VolumeModel volume = dynamics::VolumeModel::kNone);

/// Energies of a continuum: linear tets, or the dilatation averaged at nodes and the shear over edges.
enum class Continuum { kTets, kEdgeNode };

/// The model with a continuum of E = 1 kPa, nu = 0.4 in place of its springs; damping stays.
dynamics::MotionModel make_continuum(dynamics::MotionModel model, const TetMesh& mesh, Continuum kind,
                                     dynamics::StrainLaw law);

/// Steps from `state` to the end.
dynamics::MotionState march(const dynamics::MotionModel& model, const dynamics::IntegratorOptions& options,
                            dynamics::MotionState state, double duration_s, std::uint64_t steps);

}  // namespace palpate::testing_support

// A body that moves: masses, an elastic model, damping, loads and prescribed motions that change with time.
#pragma once

#include <cstdint>
#include <vector>

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/motion/spring_damping.h"
#include "core/dynamics/motion/time_profile.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::dynamics {

/// Loads that grow and shrink together: dead loads, and how far supports and held vertices are moved, are
/// multiplied by the profile's share. A support is there, and a vertex held, whatever the share.
struct TimedLoads {
  Loads loads;
  TimeProfile profile;
};

/// Everything that decides the motion but its start:
///
///   m_v a_v = elastic forces + spring damping - gamma_v v_v + loads(t)
///
/// Shape:  mass_kg one entry a vertex of elastic.rest; spring_damping_n_s_per_m one a spring, or empty for
///         none; environment_damping_n_s_per_m (gamma) one a vertex, or empty for none.
struct MotionModel {
  std::vector<Tet> tets;  ///< of the mesh, to count inverted ones; may be empty
  ElasticModel elastic;
  std::vector<double> mass_kg;
  std::vector<double> spring_damping_n_s_per_m;
  SpringDamping spring_damping = SpringDamping::kAxial;
  std::vector<double> environment_damping_n_s_per_m;
  double strain_damping_s = 0.0;  ///< b: the strain terms resist the rate of their own strain with b x their
                                  ///< moduli (damping_stress in core/dynamics/elasticity/elastic_law.h)
  std::vector<TimedLoads> loads;
};

/// Throws: InputError for a mass that is not above zero, negative damping, a bad profile, sizes that do not
/// fit, or a component of a vertex that two groups of loads hold.
void validate(const MotionModel& model);

/// A quarter of each tet's mass at each of its vertices, in kg. Throws: InputError for a density that is not
/// above zero, or a vertex of no tet: it would have no mass.
std::vector<double> build_lumped_masses(const TetMesh& mesh, double density_kg_m3);

/// A component of a vertex that a group of loads holds: its displacement is share(t) x by_m.
struct HeldComponent {
  Index vertex = 0;
  std::uint8_t axis = 0;
  std::uint32_t group = 0;
  double by_m = 0.0;
};

/// All held components, by vertex and axis.
std::vector<HeldComponent> find_held(const MotionModel& model);

/// Where the body is and how it moves.
///
/// Shape:  one displacement (in m, from elastic.rest) and one velocity (in m/s) a vertex.
struct MotionState {
  double time_s = 0.0;
  std::vector<Vec3> displacement_m;
  std::vector<Vec3> velocity_m_s;
};

/// At rest at time zero, but for held components: they are where their profiles have them, with the profiles'
/// velocities.
MotionState start_at_rest(const MotionModel& model);

/// Energies in J, momentum in kg m/s. The energy of loads is that of the supports and of the dead loads as
/// they stand at the state's time.
struct MotionEnergy {
  double kinetic_j = 0.0;
  double elastic_j = 0.0;
  double load_j = 0.0;
  double total_j() const { return kinetic_j + elastic_j + load_j; }
};
/// Energies of a state, in J.
MotionEnergy measure_energy(const MotionModel& model, const MotionState& state);
/// Sum over the vertices of m v, in kg m/s.
Vec3 measure_momentum(const MotionModel& model, const MotionState& state);

/// Deformed volume in m^3 and the tets that are not positive.
struct VolumeCount {
  double volume_m3 = 0.0;
  std::size_t inverted = 0;
  Index first_inverted = kNoIndex;
};
/// Volume and inverted tets of a state, by the rounded volume of each tet.
VolumeCount count_volume(const MotionModel& model, const MotionState& state);

/// A hash (FNV-1a, 64 bits) of the bits of time, displacements and velocities: equal states have equal
/// hashes, and states that differ in one bit nearly never.
std::uint64_t hash_state(const MotionState& state);

}  // namespace palpate::dynamics

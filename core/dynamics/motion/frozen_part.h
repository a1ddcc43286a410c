// A part of a body that is held at rest: its springs and strain energies store nothing and are left out.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/elasticity/loads.h"

namespace palpate::dynamics {

/// Holds vertices at rest in all directions, beside what the loads hold already. Throws: InputError for a
/// vertex out of range, or one that the loads move.
void hold_frozen(std::span<const Index> frozen, Loads& loads);

/// What a model has left.
struct FrozenCount {
  std::size_t springs = 0;  ///< left out
  std::size_t domains = 0;  ///< left out, of all strain terms
};

/// Leaves out the springs and the domains of strain terms all of whose vertices are frozen. At rest they give
/// no force, and frozen vertices stay at rest: the others move as before, to the bit. Requires: no volume
/// force, which is not at rest there. Throws: InputError with one.
FrozenCount drop_frozen(std::span<const Index> frozen, ElasticModel& model);

/// What the holder of the frozen vertices has to balance: sqrt(sum |f_v|^2) over them, in N, of all forces on
/// the body. What is left out gives none.
double frozen_force(std::span<const Index> frozen, std::span<const Vec3> force_n);

}  // namespace palpate::dynamics

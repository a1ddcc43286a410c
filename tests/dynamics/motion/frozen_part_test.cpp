// A part of a body held at rest: what is left out gives no force, and the rest moves as it did.
#include "core/dynamics/motion/frozen_part.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/dynamics/motion/motion_forces.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"

namespace palpate::dynamics {
namespace {

constexpr double kYoung = 1e4;

/// Springs along the edges and strain energies of nodes and edges, at small or at large strain.
ElasticModel make_model(const TetMesh& mesh, StrainSize strain) {
  BlendOptions blend;
  blend.strain = strain;
  ElasticModel model = build_blend_model(mesh, {kYoung, 0.3, 1000.0}, blend).model;
  for (const Edge& edge : build_edges(mesh)) {
    model.springs.springs.push_back(edge);
    model.springs.rest_length_m.push_back(length(mesh.points[edge[1]] - mesh.points[edge[0]]));
    model.springs.stiffness_n_per_m.push_back(100.0);
  }
  return model;
}

class FrozenPart : public ::testing::Test {
 protected:
  FrozenPart() {
    for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
      if (mesh_.points[v].z < 0.55) frozen_.push_back(static_cast<Index>(v));
    }
  }

  bool is_frozen(std::size_t v) const {
    return std::find(frozen_.begin(), frozen_.end(), static_cast<Index>(v)) != frozen_.end();
  }

  /// Random, but at rest where it is frozen.
  std::vector<Vec3> free_field(double scale) {
    std::vector<Vec3> field(mesh_.points.size());
    for (std::size_t v = 0; v < field.size(); ++v) {
      if (is_frozen(v)) continue;
      field[v] = scale * Vec3{random_.uniform() - 0.5, random_.uniform() - 0.5, random_.uniform() - 0.5};
    }
    return field;
  }

  std::vector<Vec3> forces_of(const ElasticModel& model, std::span<const Vec3> u) const {
    std::vector<Vec3> force(mesh_.points.size());
    add_elastic_forces(model, u, force);
    return force;
  }

  TetMesh mesh_ = build_kuhn_cube(4, 0.2, 3);
  std::vector<Index> frozen_;
  SplitMix64 random_{9};
};

TEST_F(FrozenPart, WhatIsLeftOutGivesNoForceToTheBit) {
  for (const StrainSize strain : {StrainSize::kSmall, StrainSize::kLarge}) {
    const ElasticModel whole = make_model(mesh_, strain);
    ElasticModel held = whole;
    const FrozenCount dropped = drop_frozen(frozen_, held);
    EXPECT_GT(dropped.springs, 0U);
    EXPECT_GT(dropped.domains, 0U);
    EXPECT_EQ(held.springs.springs.size() + dropped.springs, whole.springs.springs.size());
    const std::vector<Vec3> u = free_field(0.02);
    EXPECT_EQ(forces_of(held, u), forces_of(whole, u)) << "of frozen vertices, too";
    EXPECT_EQ(elastic_energy(held, u), elastic_energy(whole, u));
  }
}

/// What would be found of a part that is not at rest: the same comparison fails.
TEST_F(FrozenPart, APartThatMovesCannotBeLeftOut) {
  const ElasticModel whole = make_model(mesh_, StrainSize::kSmall);
  ElasticModel held = whole;
  drop_frozen(frozen_, held);
  std::vector<Vec3> u = free_field(0.02);
  u[frozen_.front()] = {1e-6, 0.0, 0.0};
  EXPECT_NE(forces_of(held, u), forces_of(whole, u));
}

TEST_F(FrozenPart, TheOthersMoveAsWhereThePartIsOnlyHeld) {
  MotionModel whole;
  whole.elastic = make_model(mesh_, StrainSize::kSmall);
  whole.mass_kg = build_lumped_masses(mesh_, 1000.0);
  BoundaryProblem problem;
  problem.material = {kYoung, 0.3, 1000.0};
  problem.gravity_m_s2 = {0.5, 0.0, -9.81};
  Loads loads = build_loads(mesh_, problem);
  hold_frozen(frozen_, loads);
  whole.loads.push_back({loads, {}});
  MotionModel held = whole;
  drop_frozen(frozen_, held.elastic);
  // Symplectic Euler by hand, from the forces alone.
  const auto run = [&](const MotionModel& model) {
    MotionForces forces(model, 1);
    MotionState state = start_at_rest(model);
    std::vector<Vec3> force(mesh_.points.size());
    for (int step = 0; step < 50; ++step) {
      std::fill(force.begin(), force.end(), Vec3{});
      forces.evaluate(state.displacement_m, state.velocity_m_s, state.time_s, force);
      for (std::size_t v = 0; v < force.size(); ++v) {
        if (forces.held_bits()[v] != 0) continue;
        state.velocity_m_s[v] = state.velocity_m_s[v] + (1e-4 / model.mass_kg[v]) * force[v];
        state.displacement_m[v] = state.displacement_m[v] + 1e-4 * state.velocity_m_s[v];
      }
    }
    return state;
  };
  const MotionState one = run(whole);
  const MotionState other = run(held);
  EXPECT_EQ(hash_state(one), hash_state(other));
  EXPECT_GT(length(*std::max_element(one.displacement_m.begin(), one.displacement_m.end(),
                                     [](const Vec3& a, const Vec3& b) { return length(a) < length(b); })),
            0.0);
  for (const Index v : frozen_) EXPECT_EQ(one.displacement_m[v], Vec3{});
}

/// Free vertices at rest under no load pull at nothing; a pull of theirs arrives at the held part whole: the
/// sum of internal forces is zero.
TEST_F(FrozenPart, TheForceOnItIsWhatTheRestPullsWith) {
  ElasticModel held = make_model(mesh_, StrainSize::kSmall);
  drop_frozen(frozen_, held);
  EXPECT_EQ(frozen_force(frozen_, forces_of(held, std::vector<Vec3>(mesh_.points.size()))), 0.0);
  const std::vector<Vec3> force{{3.0, 0.0, 0.0}, {100.0, 0.0, 0.0}, {0.0, 0.0, 4.0}};
  EXPECT_EQ(frozen_force(std::vector<Index>{0, 2}, force), 5.0);
  const std::vector<Vec3> pulled = forces_of(held, free_field(0.02));
  Vec3 sum;
  for (const Vec3& f : pulled) sum = sum + f;
  EXPECT_LE(length(sum), 1e-9);
  EXPECT_GT(frozen_force(frozen_, pulled), 1e-3);
}

TEST_F(FrozenPart, WhatCannotBeHeldIsRefused) {
  BoundaryProblem problem;
  problem.material = {kYoung, 0.3, 1000.0};
  Loads loads = build_loads(mesh_, problem);
  loads.held[frozen_[1]] = 1;
  loads.held_by_m[frozen_[1]] = {0.01, 0.0, 0.0};
  EXPECT_THROW(hold_frozen(frozen_, loads), InputError);
  EXPECT_THROW(hold_frozen(std::vector<Index>{static_cast<Index>(mesh_.points.size())}, loads), InputError);
  ElasticModel model = make_model(mesh_, StrainSize::kSmall);
  EXPECT_EQ(drop_frozen({}, model).springs, 0U);
  model.volume_force.emplace();
  EXPECT_THROW(drop_frozen(frozen_, model), InputError);
}

}  // namespace
}  // namespace palpate::dynamics

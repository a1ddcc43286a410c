// The pointer version that the engine's speed is measured against moves as the engine does.
#include "tests/support/pointer_springs.h"

#include <gtest/gtest.h>

#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::testing_support {
namespace {

using namespace dynamics;

template <typename Real>
void compare(double tolerance) {
  const TetMesh mesh = build_kuhn_cube(13, 0.2, 5);
  MotionModel model = make_free_body(mesh, 1e-3);
  model.environment_damping_n_s_per_m.assign(mesh.points.size(), 0.1 * model.mass_kg[0]);
  MotionState start = start_at_rest(model);
  start.velocity_m_s = make_random_field(mesh.points.size(), 0.1, 3);
  PlainEngine<Real> engine(model, {});
  engine.set_state(start);
  engine.step(1e-3, 100);
  const MotionState expected = engine.state();
  for (const ObjectOrder order : {ObjectOrder::kAsMade, ObjectOrder::kShuffled}) {
    PointerBody<Real> body(model, order);
    body.set_state(start);
    body.step(1e-3, 100);
    const MotionState found = body.state();
    EXPECT_LT(field_distance(found.displacement_m, expected.displacement_m),
              tolerance * field_norm(expected.displacement_m));
    EXPECT_LT(field_distance(found.velocity_m_s, expected.velocity_m_s),
              tolerance * field_norm(expected.velocity_m_s));
    EXPECT_NEAR(found.time_s, expected.time_s, 1e-12);
  }
}

TEST(PointerBody, MovesAsThePlainEngineDoes) {
  compare<double>(1e-12);
  compare<float>(1e-3);  // roundings of positions of size 1 against displacements of hundredths
}

TEST(PointerBody, ItsOrderInMemoryChangesNothing) {
  const TetMesh mesh = build_kuhn_cube(4, 0.2, 5);
  const MotionModel model = make_free_body(mesh, 1e-3);
  MotionState start = start_at_rest(model);
  start.velocity_m_s = make_random_field(mesh.points.size(), 0.1, 3);
  std::vector<std::uint64_t> hashes;
  for (const ObjectOrder order : {ObjectOrder::kAsMade, ObjectOrder::kShuffled}) {
    PointerBody<double> body(model, order);
    body.set_state(start);
    body.step(1e-3, 10);
    hashes.push_back(hash_state(body.state()));
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

}  // namespace
}  // namespace palpate::testing_support

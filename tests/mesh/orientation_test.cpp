#include "core/mesh/orientation.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(Orientation, SignOfAUnitTet) {
  const Vec3 o{0, 0, 0};
  const Vec3 x{1, 0, 0};
  const Vec3 y{0, 1, 0};
  const Vec3 z{0, 0, 1};
  EXPECT_EQ(orientation(o, x, y, z), 1);
  EXPECT_EQ(orientation(o, y, x, z), -1);
  EXPECT_EQ(orientation(o, x, y, x + y), 0);
}

}  // namespace
}  // namespace palpate

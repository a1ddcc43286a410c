#include "core/simplify/sizing/kept_region_text.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace palpate::simplify {
namespace {

TEST(KeepText, ReadsEachForm) {
  const KeptRegion sphere = parse_kept_region("sphere 1 -2 0.5 1e-2", "here");
  EXPECT_EQ(sphere.kind, KeptRegion::Kind::kSphere);
  EXPECT_EQ(sphere.center, (Vec3{1, -2, 0.5}));
  EXPECT_EQ(sphere.radius, 0.01);
  const KeptRegion half = parse_kept_region("  half_space 0 0  2 -0.04 ", "here");
  EXPECT_EQ(half.kind, KeptRegion::Kind::kHalfSpace);
  EXPECT_EQ(half.normal, (Vec3{0, 0, 2}));
  EXPECT_EQ(half.offset, -0.04);
  const KeptRegion patch = parse_kept_region("patch 1 2 3 4 0", "here");
  EXPECT_EQ(patch.kind, KeptRegion::Kind::kSurfacePatch);
  EXPECT_EQ(patch.center, (Vec3{1, 2, 3}));
  EXPECT_EQ(patch.radius, 4.0);
  EXPECT_EQ(patch.depth, 0.0);
}

TEST(KeepText, RefusalsSayWhereWhatAndWhy) {
  for (const auto& [text, part] : std::vector<std::pair<std::string, std::string>>{
           {"", "a region that starts with sphere, half_space or patch, found \"\""},
           {"ball 0 0 0 1", "found \"ball\""},
           {"sphere", "\"sphere x y z r\", found 0 numbers after sphere"},
           {"sphere 0 0 0 1 2", "found 5 numbers"},
           {"sphere 0 0 0 1mm", "a finite number in \"sphere x y z r\", found \"1mm\""},
           {"sphere 0 0 0 inf", "found \"inf\""},
           {"sphere 0 0 0 1e999", "found \"1e999\""},
           {"sphere 0 0 0 0", "a radius above 0"},
           {"half_space 0 0 0 1", "a normal of a length above 0"},
           {"patch 0 0 0 1", "\"patch x y z r depth\", found 4"},
           {"patch 0 0 0 1 -1", "a depth of at least 0"}}) {
    try {
      parse_kept_region(text, "plan.yaml:7");
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).rfind("plan.yaml:7: expected ", 0), 0U) << error.what();
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace palpate::simplify

#include "core/simplify/skin_guard/guarded_boundary.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/surface/surface.h"
#include "core/mesh/topology.h"
#include "tests/support/moved_top.h"
#include "tests/support/small_meshes.h"
#include "tests/support/triangle_corners.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

TEST(FaceContact, AgreesWithTheJudgeOnRandomPairs) {
  std::size_t contacts = 0;
  for (std::uint64_t seed = 1; seed <= 4000; ++seed) {
    SplitMix64 random(seed);
    // Small whole coordinates; the second triangle shares 0, 1 or 2 vertices with the first.
    const std::size_t shared = seed % 3;
    SurfaceMesh pair;
    for (int i = 0; i < 6; ++i) {
      pair.points.push_back({static_cast<double>(random.below(4)), static_cast<double>(random.below(4)),
                             static_cast<double>(random.below(seed % 2 == 0 ? 1 : 3))});
    }
    pair.triangles = {{0, 1, 2}, {3, 4, 5}};
    for (std::size_t k = 0; k < shared; ++k)
      pair.triangles[1][k] = static_cast<Index>(random.below(2) == 0 ? k : 2 - k);
    if (shared == 2 && pair.triangles[1][0] == pair.triangles[1][1]) continue;
    bool has_area = true;
    for (std::size_t i = 0; i < 2; ++i) {
      const TriangleCorners c = triangle_corners(pair, i);
      has_area = has_area && length_sq(cross(c[1] - c[0], c[2] - c[0])) > 0.0;
    }
    if (!has_area) continue;
    const PlacedFace a{pair.triangles[0], triangle_corners(pair, 0)};
    const PlacedFace b{pair.triangles[1], triangle_corners(pair, 1)};
    const bool expected = judge::count_self_intersections(pair) > 0;
    EXPECT_EQ(are_in_contact(a, b), expected) << "seed " << seed;
    EXPECT_EQ(are_in_contact(b, a), expected) << "seed " << seed;
    if (expected) ++contacts;
  }
  EXPECT_GT(contacts, 500U);
}

TEST(GuardedBoundary, HasTheBoundaryFaces) {
  const MovedTop top;
  const GuardedBoundary boundary(top.mesh, 0.1);
  EXPECT_EQ(boundary.size(), 6U * 32U);
  EXPECT_EQ(boundary.faces_of(top.middle).size(), 6U);
}

TEST(GuardedBoundary, PermitsWhatIsWithinTheBoundAndNothingElse) {
  const MovedTop top;
  GuardedBoundary boundary(top.mesh, 0.1);
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {2, 2, 4.09})), BoundaryVerdict::kAllowed);
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {2, 2, 4.11})), BoundaryVerdict::kTooFar);
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {2.4, 2.3, 4})),
            BoundaryVerdict::kAllowed);  // within the plane
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {3.4, 2.3, 4})),
            BoundaryVerdict::kContact);  // a face turns over
}

TEST(GuardedBoundary, ErrorsDoNotAddUpUnseen) {
  MovedTop top;
  GuardedBoundary boundary(top.mesh, 0.1);
  const BoundaryChange first = top.to(boundary, {2, 2, 4.08});
  ASSERT_EQ(boundary.check(top.mesh, first), BoundaryVerdict::kAllowed);
  boundary.apply(first);
  apply_move(top.mesh, top.middle, first.to);
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {2, 2, 4.16})), BoundaryVerdict::kTooFar);
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {2, 2, 3.92})), BoundaryVerdict::kAllowed);
}

TEST(GuardedBoundary, ABoundMayGrowButNotShrink) {
  const MovedTop top;
  GuardedBoundary boundary(top.mesh, 0.1);
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {2, 2, 4.3})), BoundaryVerdict::kTooFar);
  boundary.raise_bound(top.mesh, 0.4);
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {2, 2, 4.3})), BoundaryVerdict::kAllowed);
  EXPECT_THROW(boundary.raise_bound(top.mesh, 0.2), ContractError);
}

TEST(GuardedBoundary, ASpikeMayNotBeCutOff) {
  // All that would be left is within reach of the input, but the spike is not within reach of what is left.
  TetMesh block = make_kuhn_block(4, 4, 4);
  block.points[block_vertex(4, 4, 2, 2, 4)].z = 5.0;
  MovedTop top;
  top.mesh = build_working_mesh(std::move(block), SizingField());
  for (Index v = 0; v < top.mesh.points.size(); ++v) {
    if (top.mesh.points[v] == Vec3{2, 2, 5}) top.middle = v;
  }
  GuardedBoundary boundary(top.mesh, 0.45);
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {2, 2, 4.4})), BoundaryVerdict::kTooFar);
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {2, 2, 4.6})), BoundaryVerdict::kAllowed);
}

TEST(GuardedBoundary, PartsThatWouldTouchAreSeenFromAfar) {
  // Two blocks, the second 0.25 above the first: the bound permits more than that.
  MovedTop top;
  top.mesh = build_working_mesh(
      join_meshes(make_kuhn_block(4, 4, 4), translated(make_kuhn_block(4, 4, 4), {0, 0, 4.25})),
      SizingField());
  for (Index v = 0; v < top.mesh.points.size(); ++v) {
    if (top.mesh.points[v] == Vec3{2, 2, 4}) top.middle = v;
  }
  GuardedBoundary boundary(top.mesh, 1.0);
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {2, 2, 4.24})), BoundaryVerdict::kAllowed);
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {2, 2, 4.25})), BoundaryVerdict::kContact);
  EXPECT_EQ(boundary.check(top.mesh, top.to(boundary, {2, 2, 4.5})), BoundaryVerdict::kContact);
}

}  // namespace
}  // namespace palpate::simplify

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/judge/mesh/judge.h"
#include "core/mesh/shapes/shapes.h"
#include "core/simplify/sizing/sizing.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr auto kSphere = Region::Kind::kSphere;
constexpr auto kHalfSpace = Region::Kind::kHalfSpace;
constexpr auto kSurfacePatch = Region::Kind::kSurfacePatch;

std::uint64_t tets_in(const TetMesh& mesh, const Region& region) {
  return compare_in_regions(mesh, mesh, {&region, 1}).input_tets;
}

TEST(Regions, NothingWithoutRegions) {
  const RegionFigures none = compare_in_regions(make_two_tets(), make_corner_tet(), {});
  EXPECT_EQ(none.input_tets + none.changed_tets + none.output_tets, 0U);
}

TEST(Regions, TetsByHand) {
  const TetMesh two = make_two_tets();  // tet 0 above the face in z = 0, tet 1 below it
  EXPECT_EQ(tets_in(two, {kHalfSpace, {0, 0, 1}, -0.125, 0}), 1U);
  EXPECT_EQ(tets_in(two, {kHalfSpace, {0, 0, 1}, 0.125, 0}), 2U);
  EXPECT_EQ(tets_in(two, {kHalfSpace, {0, 0, 1}, -1.5, 0}), 0U);
  EXPECT_EQ(tets_in(two, {kSphere, {0.25, 0.25, 0.25}, 1e-3, 0}), 1U);  // within tet 0, at none of its faces
  EXPECT_EQ(tets_in(two, {kSphere, {0.25, 0.25, 0.25}, 0.249, 0}), 1U);
  EXPECT_EQ(tets_in(two, {kSphere, {0.25, 0.25, 0.25}, 0.251, 0}), 2U);
  const double third = 1.0 / 3.0;  // off the slanted face by (1 / 3) sqrt(3)
  EXPECT_EQ(tets_in(two, {kSphere, {2 * third, 2 * third, 2 * third}, 0.999 * std::sqrt(3.0) * third, 0}),
            0U);
  EXPECT_EQ(tets_in(two, {kSphere, {2 * third, 2 * third, 2 * third}, 1.001 * std::sqrt(3.0) * third, 0}),
            1U);
  EXPECT_EQ(tets_in(two, {kSurfacePatch, {0, 0, 1}, 0.1, 0.0}),
            2U);  // tet 1 shares vertices with those faces
}

TEST(Regions, TheSimplifiersKeepAtLeastWhatTheJudgeAsksFor) {
  const TetMesh mesh = build_kuhn_cube(7, 0.35, 3);
  SplitMix64 random(17);
  for (int i = 0; i < 30; ++i) {
    const Vec3 at{random.uniform(), random.uniform(), i % 3 == 2 ? 1.0 : random.uniform()};
    const double size = 0.15 + 0.3 * random.uniform();
    Region region{kSphere, at, size, 0.0};
    simplify::KeptRegion keep{.center = at, .radius = size};
    if (i % 3 == 1) {
      region = {kHalfSpace, at, size, 0.0};
      keep = {.kind = simplify::KeptRegion::Kind::kHalfSpace, .normal = at, .offset = size};
    } else if (i % 3 == 2) {
      region = {kSurfacePatch, at, size, 0.1};
      keep = {.kind = simplify::KeptRegion::Kind::kSurfacePatch, .center = at, .radius = size, .depth = 0.1};
    }
    const auto kept = simplify::build_kept_tets(simplify::SizingField({{keep}, 0.5, 0.0}, mesh), mesh);
    // Two arithmetics: they can differ only for a tet that touches the border, and random ones do not.
    EXPECT_EQ(tets_in(mesh, region), static_cast<std::uint64_t>(std::count(kept.begin(), kept.end(), 1)))
        << i;
  }
}

TEST(Regions, FindsEveryChangeInARegionAndNoneOutside) {
  const TetMesh input = make_kuhn_block(4, 4, 4);
  const std::vector<Region> low{{kHalfSpace, {0, 0, 1}, 0.5, 0.0}};  // the lowest layer of cells
  RegionFigures figures = compare_in_regions(input, input, low);
  EXPECT_EQ(figures.input_tets, 96U);
  EXPECT_EQ(figures.output_tets, 96U);
  EXPECT_EQ(figures.changed_tets, 0U);

  TetMesh turned = input;  // other numbers, an even permutation of the corners: the same tets
  std::reverse(turned.tets.begin(), turned.tets.end());
  for (Tet& t : turned.tets) t = {t[1], t[2], t[0], t[3]};
  EXPECT_EQ(compare_in_regions(turned, input, low).changed_tets, 0U);

  TetMesh moved = input;
  const Index high = block_vertex(4, 4, 2, 2, 3);
  moved.points[high].x += 0.01;
  EXPECT_EQ(compare_in_regions(moved, input, low).changed_tets, 0U);
  const Index inner = block_vertex(4, 4, 2, 2, 1);
  moved.points[inner].x = std::nextafter(moved.points[inner].x, 9.0);
  const auto around = std::count_if(input.tets.begin(), input.tets.end(), [&](const Tet& t) {
    const bool is_low = std::any_of(t.begin(), t.end(), [&](Index v) { return input.points[v].z == 0.0; });
    return is_low && std::count(t.begin(), t.end(), inner) > 0;
  });
  EXPECT_GT(around, 0);
  EXPECT_EQ(compare_in_regions(moved, input, low).changed_tets, static_cast<std::uint64_t>(around));

  TetMesh inverted = input;
  std::swap(inverted.tets[0][0], inverted.tets[0][1]);
  EXPECT_EQ(compare_in_regions(inverted, input, low).changed_tets, 1U);
  TetMesh dropped = input;
  dropped.tets.erase(dropped.tets.begin());
  figures = compare_in_regions(dropped, input, low);
  EXPECT_EQ(figures.changed_tets, 1U);
  EXPECT_EQ(figures.output_tets, 95U);
}

TEST(Regions, SurvivesBrokenMeshes) {
  const std::vector<Region> all{{kSphere, {0, 0, 0}, 100.0, 0.0}, {kSurfacePatch, {0, 0, 0}, 100.0, 1.0}};
  TetMesh broken = make_two_tets();
  broken.tets.push_back({0, 1, 2, 77});
  EXPECT_EQ(compare_in_regions(broken, make_two_tets(), all).changed_tets, 0U);
  broken.points[3].x = std::nan("");
  EXPECT_EQ(compare_in_regions(broken, make_two_tets(), all).changed_tets, 1U);
  EXPECT_EQ(compare_in_regions({}, make_two_tets(), all).changed_tets, 2U);
}

}  // namespace
}  // namespace palpate::judge

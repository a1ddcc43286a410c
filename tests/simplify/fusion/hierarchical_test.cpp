#include "core/simplify/fusion/hierarchical.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/full_mode.h"
#include "tests/support/naive_hierarchical.h"

namespace palpate::simplify {
namespace {

using test_support::NaiveReport;
using test_support::simplify_naively;

struct NamedMesh {
  const char* name;
  TetMesh mesh;
};

std::vector<NamedMesh> meshes_to_compare() {
  return {{"kuhn cube, all ties", build_kuhn_cube(7, 0.0, 0)},
          {"jittered cube", build_kuhn_cube(8, 0.3, 3)},
          {"strongly jittered cube", build_kuhn_cube(7, 0.5, 11)},
          {"bcc bar", build_bcc_bar(5)},
          {"bar", build_bar(5)}};
}

void expect_same_as_naive(const TetMesh& input, const SimplifyOptions& options, const std::string& what) {
  TetMesh fast = input;
  TetMesh naive = input;
  const SimplifyReport report = simplify_hierarchical(fast, options);
  const NaiveReport expected = simplify_naively(naive, options);
  EXPECT_EQ(report.fusions, expected.fusions) << what;
  EXPECT_EQ(fast, naive) << what;  // coordinates to the bit, and every index
  if (report.stop == "limit") {
    EXPECT_EQ(report.rejected.flip + report.rejected.quality + report.rejected.touched, expected.refused)
        << what;
  }
}

TEST(Hierarchical, SameBytesAsTheNaiveRescanWithEveryOption) {
  int number = 0;
  for (const NamedMesh& c : meshes_to_compare()) {
    for (const LevelAdjacency levels :
         {LevelAdjacency::kVertex, LevelAdjacency::kEdge, LevelAdjacency::kFace}) {
      for (const IdealVolume ideal : {IdealVolume::kFixed, IdealVolume::kUpdated}) {
        for (const double drop : {0.0, 0.01, 0.5, 0.9}) {
          for (const bool skip_touched : {false, true}) {
            if (!test::is_full() && number++ % 5 != 0)
              continue;  // 5 divides no number of values: each meets each other's
            SimplifyOptions options;
            options.levels = levels;
            options.ideal_volume = ideal;
            options.drop = drop;
            options.skip_touched = skip_touched;
            expect_same_as_naive(c.mesh, options,
                                 std::string(c.name) + " levels " + std::to_string(static_cast<int>(levels)) +
                                     " ideal " + std::to_string(static_cast<int>(ideal)) + " drop " +
                                     std::to_string(drop) + " skip " + std::to_string(skip_touched));
          }
        }
      }
    }
  }
}

TEST(Hierarchical, SameBytesAsTheNaiveRescanWithOtherChecksMetricsAndLevels) {
  const TetMesh mesh = build_kuhn_cube(8, 0.35, 5);
  for (const FusionChecks checks :
       {FusionChecks{true, false}, FusionChecks{false, true}, FusionChecks{false, false}}) {
    SimplifyOptions options;
    options.checks = checks;
    options.drop = 0.4;
    options.stop.fusions = 40;
    expect_same_as_naive(mesh, options, "checks");
  }
  for (const IdealVolume ideal : {IdealVolume::kFixed, IdealVolume::kUpdated}) {
    SimplifyOptions options;
    options.metric = kMeanRatioMetric;
    options.ideal_volume = ideal;
    options.drop = 0.5;
    options.last_level = 1;
    expect_same_as_naive(mesh, options, "mean ratio, last level 1");
  }
}

TEST(Hierarchical, SameBytesAsTheNaiveRescanUnderEveryStop) {
  const TetMesh mesh = build_kuhn_cube(9, 0.3, 4);
  std::vector<StopRule> stops(6);
  stops[0].fusions = 0;
  stops[1].fusions = 17;
  stops[2].tets = 4000;
  stops[3].tets = 1;
  stops[4].ratio = 0.05;
  stops[5].ratio = 0.999;
  for (const StopRule& stop : stops) {
    SimplifyOptions options;
    options.stop = stop;
    expect_same_as_naive(mesh, options, "stop");
  }
}

TEST(Hierarchical, StorageOrderDoesNotShow) {
  const TetMesh input = build_kuhn_cube(14, 0.35, 9);
  for (const IdealVolume ideal : {IdealVolume::kFixed, IdealVolume::kUpdated}) {
    SimplifyOptions options;
    options.ideal_volume = ideal;
    TetMesh spatial = input;
    TetMesh plain = input;
    options.storage = StorageOrder::kSpatial;
    simplify_hierarchical(spatial, options);
    options.storage = StorageOrder::kInput;
    simplify_hierarchical(plain, options);
    EXPECT_EQ(spatial, plain);
  }
}

KeptRegion sphere_at(const Vec3& center, double radius) {
  return {.kind = KeptRegion::Kind::kSphere, .center = center, .radius = radius};
}

TEST(Hierarchical, SameBytesAsTheNaiveRescanWithRegionsToKeep) {
  for (const NamedMesh& c : meshes_to_compare()) {
    for (const bool skip_touched : {false, true}) {
      for (const IdealVolume ideal : {IdealVolume::kFixed, IdealVolume::kUpdated}) {
        SimplifyOptions options;
        options.skip_touched = skip_touched;
        options.ideal_volume = ideal;
        options.sizing.keep = {sphere_at({0.5, 0.4, 0.3}, 0.15)};
        options.sizing.near_size = 0.4;
        options.sizing.reach = 0.5;
        expect_same_as_naive(c.mesh, options, std::string(c.name) + " with a sphere");
        options.stop.ratio = 0.05;
        expect_same_as_naive(c.mesh, options, std::string(c.name) + " with a sphere, stopped");
        options.sizing.near_size = 1.0;
        expect_same_as_naive(c.mesh, options, std::string(c.name) + " with a sphere, nothing graded");
      }
    }
  }
}

/// The tets of a mesh as sorted lists of points, each point as its coordinates.
std::set<std::vector<std::array<double, 3>>> tets_by_points(const TetMesh& mesh,
                                                            const std::vector<std::uint8_t>& chosen) {
  std::set<std::vector<std::array<double, 3>>> all;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (chosen[t] == 0) continue;
    std::vector<std::array<double, 3>> points;
    for (const Index v : mesh.tets[t])
      points.push_back({mesh.points[v].x, mesh.points[v].y, mesh.points[v].z});
    std::sort(points.begin(), points.end());
    all.insert(points);
  }
  return all;
}

TEST(Hierarchical, KeptTetsAreInTheOutputToTheBit) {
  const TetMesh input = build_kuhn_cube(14, 0.3, 6);
  SimplifyOptions options;
  options.sizing.keep = {
      sphere_at({0.5, 0.5, 0.6}, 0.1),
      {.kind = KeptRegion::Kind::kHalfSpace, .normal = {0, 0, 1}, .offset = 0.2},
      {.kind = KeptRegion::Kind::kSurfacePatch, .center = {1, 0.5, 0.5}, .radius = 0.2, .depth = 0.25}};
  const SizingField field(options.sizing, input);
  const std::vector<std::uint8_t> kept = build_kept_tets(field, input);
  TetMesh output = input;
  const SimplifyReport report = simplify_hierarchical(output, options);
  EXPECT_GT(report.fusions, 50U);
  EXPECT_GT(report.rejected.kept, 0U);
  const auto wanted = tets_by_points(input, kept);
  const auto found = tets_by_points(output, std::vector<std::uint8_t>(output.tets.size(), 1));
  EXPECT_GT(wanted.size(), 1000U);
  EXPECT_TRUE(std::includes(found.begin(), found.end(), wanted.begin(), wanted.end()));
  TetMesh uniform = input;
  simplify_hierarchical(uniform, {});
  const auto others = tets_by_points(uniform, std::vector<std::uint8_t>(uniform.tets.size(), 1));
  EXPECT_FALSE(std::includes(others.begin(), others.end(), wanted.begin(), wanted.end()));
}

TEST(Hierarchical, TetsAreSmallerNearWhatIsKept) {
  const TetMesh input = build_kuhn_cube(20, 0.2, 1);
  const Vec3 center{0.5, 0.5, 0.5};
  SimplifyOptions options;
  options.stop.ratio = 0.3;
  const auto tets_around = [&](double near_size) {
    TetMesh output = input;
    options.sizing.keep = {sphere_at(center, 0.05)};
    options.sizing.near_size = near_size;
    options.sizing.reach = 0.3;
    simplify_hierarchical(output, options);
    return std::count_if(output.tets.begin(), output.tets.end(), [&](const Tet& t) {
      const Vec3 middle =
          0.25 * (output.points[t[0]] + output.points[t[1]] + output.points[t[2]] + output.points[t[3]]);
      return length(middle - center) < 0.2;
    });
  };
  // The same count of tets in all, more of them within 0.2 of the middle the smaller they are to be there.
  EXPECT_GT(tets_around(0.5), tets_around(0.8));
  EXPECT_GT(tets_around(0.8), tets_around(1.0));
}

TEST(Hierarchical, NothingIsFusedWhereAllIsKept) {
  const TetMesh input = build_kuhn_cube(9, 0.3, 3);
  SimplifyOptions options;
  options.sizing.keep = {sphere_at({0.5, 0.5, 0.5}, 2.0)};
  TetMesh output = input;
  const SimplifyReport report = simplify_hierarchical(output, options);
  EXPECT_EQ(output, input);
  EXPECT_EQ(report.fusions, 0U);
  EXPECT_EQ(report.stop, "limit");
}

TEST(Hierarchical, ThreadsDoNotShow) {
  const TetMesh input = build_kuhn_cube(20, 0.35, 9);  // 48,000 tets: enough for ranges of their own
  for (const bool graded : {false, true}) {
    for (const StorageOrder storage : {StorageOrder::kSpatial, StorageOrder::kInput}) {
      TetMesh expected;
      for (const int threads : {1, 2, 3}) {
        SimplifyOptions options;
        options.storage = storage;
        options.threads = threads;
        options.stop.ratio = 0.4;
        if (graded) options.sizing.keep = {sphere_at({0.5, 0.5, 0.5}, 0.1)};
        TetMesh output = input;
        simplify_hierarchical(output, options);
        if (threads == 1) expected = output;
        EXPECT_EQ(output, expected) << threads << " threads";
      }
    }
  }
}

TEST(Hierarchical, KeepsBoundaryVolumeAndOrientation) {
  const TetMesh input = build_kuhn_cube(12, 0.4, 2);
  TetMesh output = input;
  const SimplifyReport report = simplify_hierarchical(output, {});
  EXPECT_GT(report.fusions, 50U);
  EXPECT_EQ(report.stop, "limit");
  for (const Tet& t : output.tets) {
    EXPECT_EQ(orientation(output.points[t[0]], output.points[t[1]], output.points[t[2]], output.points[t[3]]),
              1);
  }
  const auto faces_by_coordinates = [](const TetMesh& mesh) {
    std::vector<std::array<double, 9>> faces;
    for (const Triangle& f : build_boundary(mesh)) {
      std::array<Vec3, 3> p{mesh.points[f[0]], mesh.points[f[1]], mesh.points[f[2]]};
      std::sort(p.begin(), p.end(), [](const Vec3& a, const Vec3& b) {
        return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
      });
      faces.push_back({p[0].x, p[0].y, p[0].z, p[1].x, p[1].y, p[1].z, p[2].x, p[2].y, p[2].z});
    }
    std::sort(faces.begin(), faces.end());
    return faces;
  };
  EXPECT_EQ(faces_by_coordinates(output), faces_by_coordinates(input));
  // The tets fill the same cube: each of n volumes of at most 1 is rounded to about 2^-52 of itself.
  EXPECT_NEAR(total_volume(output), 1.0, 1e-12);
  EXPECT_EQ(static_cast<std::int64_t>(output.points.size()) -
                static_cast<std::int64_t>(build_edges(output).size()) +
                static_cast<std::int64_t>(build_faces(output).size()) -
                static_cast<std::int64_t>(output.tets.size()),
            1);
}

TEST(Hierarchical, StopsAtTheFirstStateThatFits) {
  const TetMesh input = build_kuhn_cube(12, 0.3, 2);
  SimplifyOptions options;
  options.stop.tets = input.tets.size() - 500;
  TetMesh output = input;
  const SimplifyReport report = simplify_hierarchical(output, options);
  EXPECT_EQ(report.stop, "tets");
  EXPECT_LE(output.tets.size(), *options.stop.tets);
  TetMesh before = input;
  SimplifyOptions one_less;
  one_less.stop.fusions = report.fusions - 1;
  simplify_hierarchical(before, one_less);
  EXPECT_GT(before.tets.size(), *options.stop.tets);
}

TEST(Hierarchical, RatioRemovesAtLeastThatShare) {
  StopRule stop;
  stop.ratio = 0.22;
  EXPECT_EQ(target_tet_count(stop, 8158), 8158U - 1795U);  // ceil(1794.76)
  stop.ratio = 0.0;
  EXPECT_EQ(target_tet_count(stop, 8158), 8158U);
}

TEST(Hierarchical, MeshWithoutInteriorTetIsLeftAsItIs) {
  for (const int cells : {1, 2, 3}) {
    const TetMesh input = build_kuhn_cube(cells, 0.0, 0);
    TetMesh output = input;
    const SimplifyReport report = simplify_hierarchical(output, {});
    EXPECT_EQ(output, input);
    EXPECT_EQ(report.fusions, 0U);
    EXPECT_EQ(report.stop, "limit");
    EXPECT_EQ(report.rejected.boundary + report.rejected.boundary_neighbour, input.tets.size());
  }
}

TEST(Hierarchical, SameTopologyAtEveryScale) {
  const TetMesh input = build_kuhn_cube(11, 0.35, 6);
  TetMesh expected = input;
  simplify_hierarchical(expected, {});
  for (const double scale : {std::ldexp(1.0, -30), std::ldexp(1.0, 30), 1e-9, 1e9}) {
    TetMesh output = input;
    for (Vec3& p : output.points) p = scale * p;
    simplify_hierarchical(output, {});
    EXPECT_EQ(output.tets, expected.tets) << scale;
  }
}

TEST(Hierarchical, RefusesImpossibleOptions) {
  const auto run = [](auto change) {
    TetMesh mesh = build_kuhn_cube(3, 0.0, 0);
    SimplifyOptions options;
    change(options);
    simplify_hierarchical(mesh, options);
  };
  EXPECT_THROW(run([](SimplifyOptions& o) { o.drop = -0.1; }), InputError);
  EXPECT_THROW(run([](SimplifyOptions& o) { o.drop = 1.5; }), InputError);
  EXPECT_THROW(run([](SimplifyOptions& o) { o.drop = std::nan(""); }), InputError);
  EXPECT_THROW(run([](SimplifyOptions& o) { o.stop.ratio = 1.0; }), InputError);
  EXPECT_THROW(run([](SimplifyOptions& o) { o.stop.ratio = std::nan(""); }), InputError);
  EXPECT_THROW(run([](SimplifyOptions& o) { o.stop.tets = 0; }), InputError);
  EXPECT_THROW(run([](SimplifyOptions& o) { o.last_level = 0; }), InputError);
  EXPECT_THROW(run([](SimplifyOptions& o) { o.threads = 0; }), InputError);
}

TEST(Hierarchical, RejectionsAddUpToTheTetsThatAreLeft) {
  TetMesh mesh = build_kuhn_cube(12, 0.3, 8);
  SimplifyOptions options;
  options.skip_touched = true;
  options.drop = 0.5;
  const SimplifyReport r = simplify_hierarchical(mesh, options);
  EXPECT_EQ(r.stop, "limit");
  EXPECT_GT(r.rejected.quality, 0U);
  EXPECT_GT(r.rejected.touched, 0U);
  EXPECT_EQ(r.rejected.boundary + r.rejected.boundary_neighbour + r.rejected.quality + r.rejected.flip +
                r.rejected.touched + r.rejected.kept,
            mesh.tets.size());
}

}  // namespace
}  // namespace palpate::simplify

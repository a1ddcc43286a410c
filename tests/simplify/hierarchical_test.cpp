#include "core/simplify/hierarchical.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"
#include "core/mesh/shapes.h"
#include "tests/support/naive_hierarchical.h"

namespace palpate::simplify {
namespace {

using test_support::NaiveReport;
using test_support::simplify_naively;

struct Case {
  const char* name;
  TetMesh mesh;
};

std::vector<Case> small_meshes() {
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
  for (const Case& c : small_meshes()) {
    for (const LevelAdjacency levels :
         {LevelAdjacency::kVertex, LevelAdjacency::kEdge, LevelAdjacency::kFace}) {
      for (const IdealVolume ideal : {IdealVolume::kFixed, IdealVolume::kUpdated}) {
        for (const double drop : {0.0, 0.01, 0.5, 0.9}) {
          for (const bool skip_touched : {false, true}) {
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
                r.rejected.touched,
            mesh.tets.size());
}

}  // namespace
}  // namespace palpate::simplify

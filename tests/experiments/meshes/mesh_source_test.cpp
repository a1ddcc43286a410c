// Made meshes: real organs, filled shapes, lattices and the cache, through the real gmsh, CGAL and VTK.
#include "experiments/meshes/mesh_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <regex>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "experiments/files/file_cache.h"
#include "experiments/judging/judge_record.h"
#include "experiments/meshes/body_surface.h"
#include "experiments/meshes/mesh_cache.h"
#include "experiments/meshes/organ_source.h"
#include "experiments/meshes/skin_jitter.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

std::int64_t euler(const TetMesh& mesh) {
  return static_cast<std::int64_t>(mesh.points.size()) - static_cast<std::int64_t>(build_edges(mesh).size()) +
         static_cast<std::int64_t>(build_faces(mesh).size()) - static_cast<std::int64_t>(mesh.tets.size());
}

bool all_positive(const TetMesh& mesh) {
  const auto& p = mesh.points;
  for (const Tet& t : mesh.tets) {
    if (orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]) <= 0) return false;
  }
  return true;
}

/// Points PALPATE_CACHE elsewhere for one test, and back.
class MovedCache {
 public:
  explicit MovedCache(const std::filesystem::path& folder) {
    const char* before = std::getenv("PALPATE_CACHE");
    had_ = before != nullptr;
    if (had_) before_ = before;
    ::setenv("PALPATE_CACHE", folder.c_str(), 1);
  }
  ~MovedCache() {
    if (had_) {
      ::setenv("PALPATE_CACHE", before_.c_str(), 1);
    } else {
      ::unsetenv("PALPATE_CACHE");
    }
  }
  MovedCache(const MovedCache&) = delete;
  MovedCache& operator=(const MovedCache&) = delete;

 private:
  bool had_ = false;
  std::string before_;
};

// The image's facts: 159 ml of voxels (627 thousand of 0.617 x 0.617 x 1.333 mm); the thesis's counts.
TEST(Kidney, HasTheThesissCountsAndTheVoxelsVolume) {
  const MadeMesh kidney = make_body({.name = "kidney"});
  constexpr double kVoxelVolume = 159554.0;
  EXPECT_NEAR(static_cast<double>(kidney.mesh.points.size()), 1503.0, 15.03);
  EXPECT_NEAR(static_cast<double>(build_edges(kidney.mesh).size()), 9998.0, 99.98);
  EXPECT_NEAR(total_volume(kidney.mesh), kVoxelVolume, 0.03 * kVoxelVolume);
  EXPECT_EQ(euler(kidney.mesh), 1);
  EXPECT_EQ(build_boundary(kidney.mesh).size() % 2, 0U);
  EXPECT_TRUE(all_positive(kidney.mesh));
  ASSERT_EQ(kidney.notes.size(), 1U);
  EXPECT_NE(kidney.notes[0].find("scaled to the voxels' volume"), std::string::npos);
  // A second run, without the cache, gives the same bits.
  EXPECT_EQ(make_body({.name = "kidney"}).mesh, kidney.mesh);
}

TEST(Kidney, TakesAnotherSize) {
  const MadeMesh coarse = make_shape({.name = "kidney", .size = {.vertices = {}, .edge_length = 5.5}});
  EXPECT_EQ(euler(coarse.mesh), 1);
  EXPECT_LT(coarse.mesh.points.size(), 1000U);
  EXPECT_NEAR(total_volume(coarse.mesh), 159554.0, 0.03 * 159554.0);
}

TEST(Liver, IsABallOfItsVoxelsVolume) {
  const MadeMesh liver = make_shape({.name = "liver"});
  EXPECT_NEAR(static_cast<double>(liver.mesh.points.size()), 1503.0, 15.03);
  EXPECT_EQ(euler(liver.mesh), 1);
  EXPECT_TRUE(all_positive(liver.mesh));
  EXPECT_NEAR(total_volume(liver.mesh), 1.6052e6, 0.03 * 1.6052e6);
}

std::int64_t boundary_vertices(const TetMesh& mesh) {
  const auto flags = build_boundary_vertex_flags(mesh);
  return std::count(flags.begin(), flags.end(), 1);
}

struct BodyCase {
  const char* name;
  std::int64_t euler;  // V - E + F - T, half that of the skin
};

// Meshes are scaled to the body's volume, so what is left is rounding: of 10^4 products of coordinates.
TEST(Bodies, AreFilledAsOneBodyOfTheirTopologyAndVolume) {
  constexpr std::array<BodyCase, 7> kCases{{{"gallbladder", 1},
                                            {"bear", 1},
                                            {"fist", 1},
                                            {"spleen", 1},
                                            {"stomach", 2},
                                            {"lobes", 1},
                                            {"ring", 0}}};
  for (const BodyCase& c : kCases) {
    const MadeMesh made = make_shape({.name = c.name});
    EXPECT_NEAR(static_cast<double>(made.mesh.points.size()), 1503.0, 15.03) << c.name;
    EXPECT_EQ(euler(made.mesh), c.euler) << c.name;
    EXPECT_EQ(judge_mesh(made.mesh).violations, std::vector<std::string>{}) << c.name;
    EXPECT_EQ(judge_mesh(made.mesh).figures.at("components"), 1) << c.name;
    const double volume = load_body_surface(c.name).volume;
    EXPECT_NEAR(total_volume(made.mesh), volume, 1e-9 * volume) << c.name;
  }
}

// The image: 17702 voxels of 0.617188 x 0.617188 x 1.33333 mm.
TEST(Bodies, TheGallbladderIsTheImagesThirdLabel) {
  EXPECT_NEAR(load_body_surface("gallbladder").volume, 17702 * 0.617188 * 0.617188 * 1.33333, 1.0);
}

/// Mean edge on the skin over mean edge inside (both ends inside).
double skin_to_inside(const TetMesh& mesh) {
  const auto flags = build_boundary_vertex_flags(mesh);
  std::array<double, 2> sum{};
  std::array<double, 2> count{};
  for (const Edge& e : build_edges(mesh)) {
    if (flags[e[0]] != flags[e[1]]) continue;
    sum[flags[e[0]]] += length(mesh.points[e[0]] - mesh.points[e[1]]);
    count[flags[e[0]]] += 1.0;
  }
  return (sum[1] / count[1]) / (sum[0] / count[0]);
}

TEST(SkinKind, FineIsAtLeastAsFineAsTheInside) {
  for (const char* name : {"lobes", "bean"}) {
    const MadeMesh coarse = make_shape({.name = name});
    const MadeMesh fine = make_shape({.name = name, .skin = SkinKind::kFine});
    EXPECT_NEAR(static_cast<double>(fine.mesh.points.size()), 1503.0, 15.03) << name;
    EXPECT_GT(boundary_vertices(fine.mesh), 3 * boundary_vertices(coarse.mesh) / 2) << name;
    EXPECT_LT(skin_to_inside(fine.mesh), skin_to_inside(coarse.mesh)) << name;
    EXPECT_LT(skin_to_inside(fine.mesh), 1.0) << name;
    EXPECT_GT(skin_to_inside(coarse.mesh), 1.0) << name;
  }
  EXPECT_THROW(make_shape({.name = "bar", .skin = SkinKind::kFine}), InputError);
}

/// The shortest edge of the skin over the mean one.
double shortest_on_skin(const TetMesh& mesh) {
  double shortest = HUGE_VAL;
  double sum = 0.0;
  double count = 0.0;
  for (const Triangle& t : build_boundary(mesh)) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double edge = length(mesh.points[t[k]] - mesh.points[t[(k + 1) % 3]]);
      shortest = std::min(shortest, edge);
      sum += edge;
      count += 1.0;
    }
  }
  return shortest * count / sum;
}

TEST(SkinKind, ScannedHasNeedlesAndTheTopologyOfTheBody) {
  for (const char* name : {"stomach", "ring", "ball"}) {  // a cavity, a hole, no body of a file
    const ShapeRequest request{
        .name = name, .size = {.vertices = 900, .edge_length = {}}, .skin = SkinKind::kScanned};
    ShapeRequest even = request;
    even.skin = SkinKind::kFine;
    ShapeRequest elsewhere = request;
    elsewhere.seed = 3;
    const TetMesh scanned = make_shape(request).mesh;
    EXPECT_NEAR(static_cast<double>(scanned.points.size()), 900.0, 9.0) << name;
    EXPECT_EQ(judge_mesh(scanned).violations, std::vector<std::string>{}) << name;
    EXPECT_EQ(euler(scanned), euler(make_shape(even).mesh)) << name;
    EXPECT_LT(shortest_on_skin(scanned), 0.05) << name;  // half a grey level is 0.004 voxels
    EXPECT_GT(shortest_on_skin(make_shape(even).mesh), 0.3) << name;
    EXPECT_LT(skin_to_inside(scanned), 1.0) << name;
    const TetMesh other = make_shape(elsewhere).mesh;
    EXPECT_NE(other, scanned) << name;
    EXPECT_EQ(euler(other), euler(scanned)) << name;
    EXPECT_NEAR(total_volume(other), total_volume(scanned), 0.03 * total_volume(scanned)) << name;
  }
  for (const char* name : {"cube", "filled_bar"})
    EXPECT_THROW(make_shape({.name = name, .skin = SkinKind::kScanned}), InputError) << name;
}

TEST(SkinKind, AGridTooCoarseForTheBodyIsRefused) {
  const ShapeRequest request{
      .name = "gallbladder", .size = {.vertices = {}, .edge_length = 16.0}, .skin = SkinKind::kScanned};
  EXPECT_THROW(make_shape(request), UnavailableError);
}

TEST(Seed, GivesAnotherMeshOfTheSameBody) {
  for (const char* name : {"ring", "ball"}) {
    const ShapeRequest request{.name = name, .size = {.vertices = 600, .edge_length = {}}};
    ShapeRequest seeded = request;
    seeded.seed = 7;
    const TetMesh plain = make_shape(request).mesh;
    const TetMesh other = make_shape(seeded).mesh;
    EXPECT_NE(other, plain) << name;
    EXPECT_EQ(make_shape(seeded).mesh, other) << name;
    EXPECT_EQ(judge_mesh(other).violations, std::vector<std::string>{}) << name;
    EXPECT_EQ(euler(other), euler(plain)) << name;
    EXPECT_NEAR(static_cast<double>(other.points.size()), 600.0, 6.0) << name;
    EXPECT_NEAR(total_volume(other), total_volume(plain), 0.01 * total_volume(plain)) << name;
  }
  for (const char* name : {"bar", "bcc_bar", "filled_bar"}) {
    try {
      make_shape({.name = name, .seed = 7});
      FAIL() << name;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("expected no seed"), std::string::npos) << error.what();
    }
  }
}

TEST(Seed, MovesVerticesAlongTheSkin) {
  SurfaceMesh ball = build_geodesic_sphere(8);
  const SurfaceMesh before = ball;
  jitter_skin(0, ball);
  EXPECT_EQ(ball, before);
  jitter_skin(3, ball);
  for (std::size_t v = 0; v < ball.points.size(); ++v) {
    const double moved = length(ball.points[v] - before.points[v]);
    EXPECT_GT(moved, 0.0);
    EXPECT_LT(moved, 0.03);  // edges of 0.13 to 0.18
    // Along the sphere: what it leaves it by is moved^2 / 2, and moved times the tilt of the area vector.
    EXPECT_NEAR(length(ball.points[v]), 1.0, 0.5 * moved * moved + 0.1 * moved);
  }
}

TEST(Bean, HasACoarseSkinAndAFinerInterior) {
  const MadeMesh bean = make_shape({.name = "bean"});
  EXPECT_NEAR(static_cast<double>(bean.mesh.points.size()), 1503.0, 15.03);
  EXPECT_NEAR(static_cast<double>(build_edges(bean.mesh).size()), 9998.0, 99.98);
  const auto flags = build_boundary_vertex_flags(bean.mesh);
  EXPECT_EQ(std::count(flags.begin(), flags.end(), 1), 362);
  EXPECT_EQ(euler(bean.mesh), 1);
  EXPECT_TRUE(all_positive(bean.mesh));
}

TEST(Ball, HitsTheWantedCount) {
  for (const std::uint64_t wanted : {300U, 4000U}) {
    const MadeMesh ball = make_shape({.name = "ball", .size = {.vertices = wanted, .edge_length = {}}});
    EXPECT_NEAR(static_cast<double>(ball.mesh.points.size()), static_cast<double>(wanted),
                0.01 * static_cast<double>(wanted));
    EXPECT_EQ(euler(ball.mesh), 1);
    EXPECT_LT(total_volume(ball.mesh), 4.0 / 3.0 * M_PI);  // inscribed
  }
}

TEST(Lattices, TakeTheNearestNumberOfCells) {
  for (const char* name : {"cube", "bar", "bcc_bar"}) {
    const std::size_t found = make_shape({.name = name}).mesh.points.size();
    // A request for the very count found gives it back.
    EXPECT_EQ(make_shape({.name = name, .size = {.vertices = found, .edge_length = {}}}).mesh.points.size(),
              found);
    EXPECT_GT(found, 1000U);
    EXPECT_LT(found, 2200U);
  }
  EXPECT_EQ(make_shape({.name = "cube", .size = {.vertices = {}, .edge_length = 0.25}}).mesh.points.size(),
            125U);
}

TEST(MakeShape, RefusesWhatItCannotMake) {
  const auto message = [](const ShapeRequest& request) -> std::string {
    try {
      make_shape(request);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message({.name = "kideny"}).find("did you mean \"kidney\"?"), std::string::npos);
  EXPECT_NE(message({.name = "ball", .size = {.vertices = 1000, .edge_length = 0.1}}).find("both"),
            std::string::npos);
  EXPECT_NE(message({.name = "ball", .size = {.vertices = 5, .edge_length = {}}}), "");
  EXPECT_NE(message({.name = "ball", .size = {.vertices = {}, .edge_length = 1e-5}}).find("20 million"),
            std::string::npos);
  EXPECT_NE(message({.name = "kidney", .size = {.vertices = {}, .edge_length = -1.0}}), "");
  EXPECT_NE(message({.name = "kidney", .size = {.vertices = {}, .edge_length = std::nan("")}}), "");
  EXPECT_NE(message({.name = "bar", .jitter = 0.1}).find("no jitter"), std::string::npos);
}

TEST(ListShapes, NamesEveryShapeThatIsMade) {
  std::vector<std::string> names;
  for (const ShapeInfo& shape : list_shapes()) {
    names.push_back(shape.name);
    EXPECT_EQ(shape.unavailable, "") << shape.name;
    EXPECT_NE(shape.summary, "");
  }
  EXPECT_EQ(names, (std::vector<std::string>{"kidney", "liver", "gallbladder", "bear", "fist", "spleen",
                                             "stomach", "lobes", "ring", "bean", "ball", "filled_bar", "bar",
                                             "cube", "bcc_bar"}));
}

TEST(MeshCache, KeysHoldTheImageAndWhatMakesMeshes) {
  const test::ScratchFolder folder;
  const MovedCache moved(folder.path());
  std::filesystem::create_directory(folder / "organ_data");
  const ShapeRequest kidney{"kidney", {}, 0, {}};
  const ShapeRequest ball{"ball", {}, 0, {}};
  folder.add("organ_data/liver.inr", "an image");
  const std::string kidney_key = shape_key(kidney);
  const std::string ball_key = shape_key(ball);
  EXPECT_EQ(shape_key(kidney), kidney_key);
  folder.add("organ_data/liver.inr", "another image");
  EXPECT_NE(shape_key(kidney), kidney_key) << "a kidney from another image is another kidney";
  EXPECT_EQ(shape_key(ball), ball_key);
  make_shape({"ball", {150, {}}, 0, {}});
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "mesh_cache")) {
    if (entry.path().extension() != ".json") continue;
    const std::string key = read_kept(entry.path()).at("key").get<std::string>();
    EXPECT_TRUE(std::regex_search(key, std::regex("palpate [0-9.]+ [0-9a-f]{64}; "))) << key;
  }
}

TEST(MeshCache, KeepsAMeshAndMakesADamagedOneAgain) {
  const test::ScratchFolder folder;
  const MovedCache moved(folder.path());
  int made = 0;
  const auto make = [&] {
    ++made;
    return MadeMesh{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}}, {"note"}};
  };
  const MadeMesh first = make_cached("a", make);
  const MadeMesh again = make_cached("a", make);
  EXPECT_EQ(made, 1);
  EXPECT_EQ(again.mesh, first.mesh);
  EXPECT_EQ(again.notes, first.notes);
  make_cached("b", make);
  EXPECT_EQ(made, 2);
  for (const auto& entry : std::filesystem::recursive_directory_iterator(cache_root() / "mesh_cache")) {
    if (entry.path().extension() != ".mesh") continue;
    std::fstream file(entry.path(), std::ios::in | std::ios::out);
    file.seekp(60);
    file << '7';
  }
  EXPECT_EQ(make_cached("a", make).mesh, first.mesh);
  EXPECT_EQ(made, 3);
  make_cached("a", make);
  EXPECT_EQ(made, 3);
}

}  // namespace
}  // namespace palpate::experiments

// The user's surfaces: what is filled, and what is refused and where.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/off.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "experiments/meshes/mesh_fill.h"
#include "experiments/meshes/mesh_source.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/surfaces.h"

namespace palpate::experiments {
namespace {

using test::ascii_stl;
using test::binary_stl;
using test::moved;
using test::turned;
using test::united;

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// The refusal of a surface, or "" if it is filled.
std::string refusal(const std::filesystem::path& path, const MeshSize& size = {}) {
  try {
    mesh_surface({path, size});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string refusal_of(const SurfaceMesh& surface) {
  const test::ScratchFolder folder;
  const auto path = folder.path() / "surface.off";
  write_off(path, surface);
  std::string message = refusal(path);
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  return message;
}

std::string indexed(const SurfaceMesh& s, const std::string& header, const std::string& vertex,
                    const std::string& face, Index first) {
  std::string text = header;
  for (const Vec3& p : s.points) {
    text += vertex + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
  }
  for (const Triangle& t : s.triangles) {
    text += face + std::to_string(t[0] + first) + " " + std::to_string(t[1] + first) + " " +
            std::to_string(t[2] + first) + "\n";
  }
  return text;
}

TEST(Surface, EveryFormatIsFilledWithItsSkinKept) {
  const test::ScratchFolder folder;
  const SurfaceMesh ball = build_geodesic_sphere(3);
  const std::string counts = std::to_string(ball.points.size());
  const std::string ply = "ply\nformat ascii 1.0\nelement vertex " + counts +
                          "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                          std::to_string(ball.triangles.size()) +
                          "\nproperty list uchar int vertex_indices\nend_header\n";
  write_text(folder.path() / "a.stl", ascii_stl(ball));
  write_text(folder.path() / "b.stl", binary_stl(ball));
  write_text(folder.path() / "c.obj", indexed(ball, "", "v ", "f ", 1));
  write_text(folder.path() / "d.ply", indexed(ball, ply, "", "3 ", 0));
  write_off(folder.path() / "e.off", ball);
  for (const char* name : {"a.stl", "b.stl", "c.obj", "d.ply", "e.off"}) {
    const MadeMesh made = mesh_surface({folder.path() / name, {.vertices = {}, .edge_length = 0.3}});
    EXPECT_EQ(build_boundary(made.mesh).size(), ball.triangles.size()) << name;
    EXPECT_NEAR(total_volume(made.mesh), enclosed_volume(ball), 1e-5) << name;  // six digits in the files
  }
}

TEST(Surface, AVertexCountAdaptsTheInteriorAndTheSkinOnlyIfItMust) {
  const test::ScratchFolder folder;
  const SurfaceMesh ball = build_geodesic_sphere(6);
  write_off(folder.path() / "ball.off", ball);
  const MadeMesh fine = mesh_surface({folder.path() / "ball.off", {.vertices = 1000, .edge_length = {}}});
  EXPECT_NEAR(static_cast<double>(fine.mesh.points.size()), 1000.0, 10.0);
  EXPECT_EQ(build_boundary(fine.mesh).size(), ball.triangles.size());
  const MadeMesh coarse = mesh_surface({folder.path() / "ball.off", {.vertices = 300, .edge_length = {}}});
  EXPECT_NEAR(static_cast<double>(coarse.mesh.points.size()), 300.0, 3.0);
  EXPECT_LT(build_boundary(coarse.mesh).size(), ball.triangles.size());
  ASSERT_FALSE(coarse.notes.empty());
  EXPECT_NE(coarse.notes[0].find("remeshed"), std::string::npos);
}

/// A skin that cannot be remade says why, and how it is kept.
TEST(Surface, AWallThatIsThinnerThanItsEdgesIsSaid) {
  const SurfaceMesh ball = build_geodesic_sphere(16);
  const SurfaceMesh shell = united(moved(ball, 50.0, {}), turned(moved(ball, 49.9, {})));
  std::string message;
  try {
    remesh_surface(shell, 20.0);
  } catch (const InputError& error) {
    message = error.what();
  }
  EXPECT_EQ(message.find("skin: expected a body with room for edges of 20, found one that is 0.0"), 0U)
      << message;
  EXPECT_NE(message.find("palpate mesh without --vertices keeps the skin"), std::string::npos) << message;
}

TEST(Surface, SeparatePiecesAreFilled) {
  const SurfaceMesh ball = build_geodesic_sphere(2);
  EXPECT_EQ(refusal_of(united(ball, moved(ball, 1.0, {3, 0, 0}))), "");
}

TEST(Surface, AnOpenOneIsRefused) {
  SurfaceMesh surface = build_geodesic_sphere(2);
  surface.triangles.pop_back();
  const std::string message = refusal_of(surface);
  EXPECT_NE(message.find("3 border edges (open), one at ("), std::string::npos) << message;
}

TEST(Surface, ANonManifoldEdgeIsRefused) {
  // Two tetrahedra back to back along one edge.
  const SurfaceMesh surface{
      {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}},
      {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}, {0, 1, 4}, {0, 5, 1}, {0, 4, 5}, {1, 5, 4}}};
  const std::string message = refusal_of(surface);
  EXPECT_NE(message.find("1 edges with more than two triangles (non-manifold), one at (0, 0, 0) - (0, 0, 1)"),
            std::string::npos)
      << message;
}

TEST(Surface, ANonManifoldVertexIsRefused) {
  const SurfaceMesh cone{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                         {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
  const std::string message = refusal_of(united(cone, turned(moved(cone, -1.0, {}))));
  EXPECT_NE(message.find("1 vertices where separate sheets touch (non-manifold), one at (0, 0, 0)"),
            std::string::npos)
      << message;
}

TEST(Surface, ASelfIntersectingOneIsRefused) {
  const SurfaceMesh ball = build_geodesic_sphere(2);
  const std::string message = refusal_of(united(ball, moved(ball, 1.0, {1, 0.1, 0.2})));
  EXPECT_NE(message.find("pairs of triangles that intersect, one at ("), std::string::npos) << message;
}

TEST(Surface, AnInsideOutOneIsRefused) {
  const std::string message = refusal_of(turned(build_geodesic_sphere(2)));
  EXPECT_NE(message.find("inside out"), std::string::npos) << message;
}

TEST(Surface, OneFlippedTriangleIsRefused) {
  SurfaceMesh surface = build_geodesic_sphere(2);
  std::swap(surface.triangles[7][0], surface.triangles[7][1]);
  const std::string message = refusal_of(surface);
  EXPECT_NE(message.find("3 edges where two neighbours turn against each other"), std::string::npos)
      << message;
}

TEST(Surface, WronglyNestedPiecesAreRefused) {
  const SurfaceMesh ball = build_geodesic_sphere(2);
  const std::string message = refusal_of(united(ball, moved(ball, 0.3, {})));
  EXPECT_NE(message.find("nested in each other the wrong way round"), std::string::npos) << message;
}

TEST(Surface, BrokenFilesAreRefused) {
  const test::ScratchFolder folder;
  const SurfaceMesh ball = build_geodesic_sphere(2);
  const std::string ascii = ascii_stl(ball);
  const std::string binary = binary_stl(ball);
  const auto refused = [&](const std::string& name, const std::string& bytes) {
    write_text(folder.path() / name, bytes);
    return refusal(folder.path() / name);
  };
  EXPECT_NE(refused("empty.stl", "").find("an empty file"), std::string::npos);
  EXPECT_NE(refused("garbage.stl", std::string("\x01\x02\x7f garbage \xff", 13)), "");
  EXPECT_NE(refused("garbage.off", std::string("\x01\x02\x7f garbage \xff", 13)), "");
  EXPECT_NE(refused("garbage.ply", std::string("\x01\x02\x7f garbage \xff", 13)), "");
  EXPECT_NE(refused("garbage.obj", std::string("\x01\x02\x7f garbage \xff", 13)), "");
  EXPECT_NE(refused("short.stl", binary.substr(0, binary.size() - 70)), "");
  EXPECT_NE(refused("cut.stl", ascii.substr(0, ascii.size() / 2)).find("truncated"), std::string::npos);
  EXPECT_NE(refused("claims.off", "OFF\n4000000000 4000000000 0\n0 0 0\n"), "");
  EXPECT_NE(
      refused("nan.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 nan 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"),
      "");
  EXPECT_NE(refused("quads.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").find("4 corners"),
            std::string::npos);
  EXPECT_NE(refused("a.txt", "x").find(".stl, .off, .obj or .ply"), std::string::npos);
  EXPECT_NE(refusal(folder.path() / "missing.stl"), "");
}

/// Each is a good file whose header claims more than is there, or a row that does.
TEST(Surface, AFileThatClaimsMoreThanItHoldsIsRefusedInOneLine) {
  const test::ScratchFolder folder;
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  const std::string faces = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  const auto off = [&](const std::string& counts) { return "OFF\n" + counts + " 0\n" + points + faces; };
  const auto ply = [&](const std::string& vertices, const std::string& count, const std::string& more) {
    return "ply\nformat ascii 1.0\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\n" + more + "element face " + count +
           "\nproperty list uchar int vertex_indices\nend_header\n" + points + faces;
  };
  const auto refused = [&](const std::string& name, const std::string& bytes) {
    write_text(folder.path() / name, bytes);
    return refusal(folder.path() / name);
  };
  EXPECT_EQ(refused("good.off", off("4 4")), "");
  EXPECT_EQ(refused("good.ply", ply("4", "4", "")), "");
  EXPECT_EQ(refused("comment.off", "# a comment\nOFF # another\n\n4 4 0\n" + points + "# and one\n" + faces),
            "");
  const std::vector<std::array<std::string, 3>> all{
      {"v5.off", off("5 4"), "expected 5 vertices and 4 faces, as the header says, found 8 rows"},
      {"f40.off", off("4 40"), "expected 4 vertices and 40 faces, as the header says, found 8 rows"},
      {"huge.off", off("4000000000 4"), "expected vertices that 75 bytes can hold"},
      {"faces.off", off("4 4000000000"), "expected faces that 75 bytes can hold"},
      {"negative.off", off("-4 4"), ""},
      {"corners.off", off("4 4").replace(off("4 4").find("3 1 2 3"), 1, "300000"),
       "expected corners of a face"},
      {"color.off", "C" + off("4 4"), "expected a colour of 3 or 4 numbers"},
      {"v5.ply", ply("5", "4", ""), "expected 9 elements, as the header says, found 8 rows"},
      {"f40.ply", ply("4", "40", ""), "expected 44 elements, as the header says, found 8 rows"},
      {"huge.ply", ply("4000000000", "4", ""), "as the file has bytes"},
      {"faces.ply", ply("4", "4000000000", ""), "as the file has bytes"},
      {"owner.ply", "ply\nformat ascii 1.0\nend_header_of_none\nproperty float x\nend_header\n",
       "expected an element before its properties"},
      {"property.ply", ply("4", "4", "property float q\n"),
       "expected vertex_indices of face 4 of 4, found the end of the file"},
  };
  for (const auto& [name, bytes, expected] : all) {
    const std::string message = refused(name, bytes);
    EXPECT_NE(message, "") << name;
    EXPECT_NE(message.find(expected), std::string::npos) << message;
    EXPECT_NE(message.find(name), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(Surface, ThatIsTooSmallOrTooLargeIsRefusedByItsSize) {
  const SurfaceMesh ball = build_geodesic_sphere(1);
  EXPECT_NE(refusal_of(moved(ball, 1e80, {})).find("expected coordinates within +-1e+60, found "),
            std::string::npos);
  EXPECT_NE(refusal_of(moved(ball, 1e-60, {})).find("expected a surface that is at least 1e-40 long, found "),
            std::string::npos);
  EXPECT_EQ(refusal_of(moved(ball, 1e59, {})), "");
  EXPECT_EQ(refusal_of(moved(ball, 1e-39, {})), "");
}

TEST(Surface, CavitiesBelongToOnePiece) {
  const SurfaceMesh ball = build_geodesic_sphere(2);
  const SurfaceMesh shell = united(moved(ball, 10.0, {}), turned(moved(ball, 6.0, {})));
  EXPECT_EQ(refusal_of(shell), "");
  for (const double x : {1.0, 20.0}) {  // within the cavity, beside the shell
    EXPECT_NE(
        refusal_of(united(shell, moved(ball, 2.0, {x, 0, 0})))
            .find(
                "expected one piece with its cavities, or several without any, found 2 pieces and 1 cavity"),
        std::string::npos);
  }
}

TEST(Surface, AUnitThatNoBodyHasIsRefusedBeforeItIsFilled) {
  const test::ScratchFolder folder;
  write_off(folder.path() / "ball.off", build_geodesic_sphere(2));
  std::string message;
  try {
    // 5 million vertices would take minutes.
    mesh_surface({folder.path() / "ball.off", {5'000'000, {}}, false, 1e9});
  } catch (const InputError& error) {
    message = error.what();
  }
  EXPECT_EQ(message.find("--unit-m: expected a unit in which the body is 1 nm to 1000 km across, found"), 0U)
      << message;
}

TEST(Surface, CornersThatAreNoneAreSaidAsTheyStandInTheFile) {
  const test::ScratchFolder folder;
  const auto refused = [&](const std::string& name, const std::string& bytes) {
    write_text(folder.path() / name, bytes);
    return refusal(folder.path() / name);
  };
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  const std::string faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\n";
  EXPECT_EQ(refused("good.obj", points + faces + "f -3 -2 -1\n"), "");
  for (const char* corner : {"0", "5", "-5", "1000000"}) {
    const std::string said = refused("a.obj", points + faces + "f " + corner + " 3 4\n");
    EXPECT_NE(said.find("a.obj:8: expected vertices 1 to 4, found \"" + std::string(corner) + "\""),
              std::string::npos)
        << said;
  }
  const std::string ply = refused("a.ply",
                                  "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float "
                                  "y\nproperty float z\nelement face 4\n"
                                  "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 "
                                  "0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 -2\n");
  EXPECT_NE(ply.find("expected vertices 0 to 3, found vertex -2"), std::string::npos) << ply;
}

// gmsh returns without tets when two sheets cross: that must never pass for a mesh.
TEST(Gmsh, AFailureIsDetected) {
  const SurfaceMesh ball = build_geodesic_sphere(3);
  EXPECT_THROW(fill_surface(united(ball, moved(ball, 1.0, {1, 0.1, 0.2})), 0.2), UnavailableError);
}

}  // namespace
}  // namespace palpate::experiments

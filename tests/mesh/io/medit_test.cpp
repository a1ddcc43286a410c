#include "core/mesh/io/medit.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/orientation.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/scratch_folder.h"

namespace palpate {
namespace {

using test::bytes_of;
using test::ScratchFolder;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

bool is_same_to_the_bit(const TetMesh& a, const TetMesh& b) {
  if (a.tets != b.tets || a.points.size() != b.points.size()) return false;
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
  for (std::size_t v = 0; v < a.points.size(); ++v) {
    const Vec3& p = a.points[v];
    const Vec3& q = b.points[v];
    if (bits(p.x) != bits(q.x) || bits(p.y) != bits(q.y) || bits(p.z) != bits(q.z)) return false;
  }
  return true;
}

/// Two tets on five vertices.
TetMesh two_tets() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}, {{0, 1, 2, 3}, {1, 2, 3, 4}}};
}

TEST(Medit, WritesTheLayoutThatItPromises) {
  const ScratchFolder folder;
  const TetMesh mesh{{{0, 0, -0.0}, {0.1, 0, 0}, {0, 1e-300, 0}, {0, 0, 12345678.9}}, {{0, 1, 2, 3}}};
  write_medit(folder / "a.mesh", mesh);
  EXPECT_EQ(bytes_of(folder / "a.mesh"),
            "MeshVersionFormatted 2\nDimension 3\n"
            "Vertices\n4\n0 0 -0 0\n0.1 0 0 0\n0 1e-300 0 0\n0 0 12345678.9 0\n"
            "Triangles\n4\n2 3 4 0\n1 4 3 0\n1 2 4 0\n1 3 2 0\n"
            "Tetrahedra\n1\n1 2 3 4 0\nEnd\n");
}

TEST(Medit, ComesBackToTheBit) {
  const ScratchFolder folder;
  for (const TetMesh& mesh : {build_kuhn_cube(7, 0.5, 3), build_bar(2), build_bcc_bar(3), two_tets()}) {
    write_medit(folder / "a.mesh", mesh);
    const MeditFile file = read_medit(folder / "a.mesh");
    EXPECT_TRUE(is_same_to_the_bit(file.mesh, mesh));
    EXPECT_THAT(file.notes, IsEmpty());
  }
}

TEST(Medit, CoordinatesOfEveryMagnitudeComeBackToTheBit) {
  const ScratchFolder folder;
  const std::uint64_t seed = 17;
  SCOPED_TRACE("seed " + std::to_string(seed));
  SplitMix64 random(seed);
  TetMesh mesh = two_tets();
  while (mesh.points.size() < 20000) {
    const auto coordinate = [&] {
      double value = 0.0;
      do {
        value = std::bit_cast<double>(random.next());
      } while (!(std::fabs(value) <= 1e90));
      return value;
    };
    mesh.points.push_back({coordinate(), coordinate(), coordinate()});
  }
  mesh.points.push_back({5e-324, -5e-324, 2.2250738585072014e-308});
  mesh.points.push_back({1e90, -1e90, -0.0});
  write_medit(folder / "a.mesh", mesh);
  EXPECT_TRUE(is_same_to_the_bit(read_medit(folder / "a.mesh", ReadOrientation::kKeep).mesh, mesh));
}

TEST(Medit, TheSameMeshGivesTheSameBytes) {
  const ScratchFolder folder;
  write_medit(folder / "a.mesh", build_kuhn_cube(9, 0.3, 5));
  write_medit(folder / "b.mesh", build_kuhn_cube(9, 0.3, 5));
  write_medit(folder / "c.mesh", read_medit(folder / "a.mesh").mesh);
  EXPECT_EQ(bytes_of(folder / "a.mesh"), bytes_of(folder / "b.mesh"));
  EXPECT_EQ(bytes_of(folder / "a.mesh"), bytes_of(folder / "c.mesh"));
}

TEST(Medit, ScaledCoordinatesGiveTheSameTopology) {
  const ScratchFolder folder;
  const TetMesh mesh = build_kuhn_cube(5, 0.4, 2);
  for (const double scale : {1e-9, 1e9}) {
    TetMesh scaled = mesh;
    for (Vec3& p : scaled.points) p = scale * p;
    write_medit(folder / "a.mesh", scaled);
    const MeditFile file = read_medit(folder / "a.mesh");
    EXPECT_EQ(file.mesh.tets, mesh.tets);
    EXPECT_TRUE(is_same_to_the_bit(file.mesh, scaled));
    EXPECT_THAT(file.notes, IsEmpty());
  }
}

TEST(Medit, WordsMayLieAcrossTheBuffer) {
  const ScratchFolder folder;
  const TetMesh mesh = build_kuhn_cube(20, 0.3, 1);
  write_medit(folder / "a.mesh", mesh);
  const std::string bytes = bytes_of(folder / "a.mesh");
  ASSERT_GT(bytes.size(), 1U << 20U);
  for (std::size_t shift = 1; shift <= 40; ++shift) {
    std::string shifted(shift, '#');
    shifted += "\n";
    shifted += bytes;
    folder.add("b.mesh", shifted);
    ASSERT_EQ(read_medit(folder / "b.mesh").mesh, mesh) << shift;
  }
}

TEST(Medit, LongCommentsAndBlanksKeepTheLineCount) {
  const ScratchFolder folder;
  for (const std::size_t size : {(1U << 20U) - 1U, 1U << 20U, (1U << 20U) + 1U, 3U << 20U}) {
    const std::string comment = "# " + std::string(size, 'c') + "\n\n";
    const std::string blanks = std::string(size, ' ') + std::string(size, '\n');
    std::string bytes = comment;
    for (const std::string& part : {std::string("MeshVersionFormatted 2 Dimension 3\n"), blanks, comment}) {
      bytes += part;
    }
    bytes += "Vertices\nx\n";
    const std::string path = folder.add("a.mesh", bytes);
    const std::size_t line = 2 + 1 + size + 2 + 2;
    try {
      read_medit(path);
      ADD_FAILURE() << "read a broken file";
    } catch (const InputError& error) {
      EXPECT_EQ(error.what(),
                path + ":" + std::to_string(line) + ": expected the number of vertices, found \"x\"");
    }
  }
}

constexpr const char* kVertices = "5\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 1 1 0\n";

TEST(Medit, ReadsTheLayoutOfGmsh) {
  const ScratchFolder folder;
  folder.add("a.mesh", std::string(" MeshVersionFormatted 2\n Dimension\n 3\n Vertices\n 5\n"
                                   "                      0                      0      0      1\n"
                                   " 1. 0 0 2\n 0 1.0e+00 0 3\n +0 0 +1 4\n 1 1 1 5\n"
                                   " Edges\n 1\n 1 2 10\n Triangles\n 2\n 1 2 3 7\n 2 3 4 8\n"
                                   " Tetrahedra\n 2\n 1 2 3 4 1\n 2 3 4 5 1\n End\n"));
  const MeditFile file = read_medit(folder / "a.mesh");
  EXPECT_EQ(file.mesh, two_tets());
  EXPECT_THAT(file.notes, IsEmpty());
}

TEST(Medit, ReadsTheLayoutOfMeditWithAllItsMarkers) {
  const ScratchFolder folder;
  folder.add("a.mesh", std::string("MeshVersionFormatted 1\n\n\nDimension\n3\n\n# CAD\nVertices\n") +
                           kVertices +
                           "\nCorners\n2\n1\n2\n\nRequiredVertices\n1\n3\n\nEdges\n2\n1 2 0\n2 3 0\n"
                           "\nRidges\n1\n1\n\nRequiredEdges\n1\n2\n\nNormals\n1\n0 0 1\n"
                           "\nNormalAtVertices\n1\n1 1\n\nTangents\n1\n1 0 0\n\nTangentAtVertices\n1\n1 1\n"
                           "\nTriangles\n1\n1 2 3 0\n\nRequiredTriangles\n1\n1\n"
                           "\nTetrahedra # the volume\n2\n1 2 3 4 0 # first\n2 3 4 5 0\n\nEnd\n");
  const MeditFile file = read_medit(folder / "a.mesh");
  EXPECT_EQ(file.mesh, two_tets());
  EXPECT_THAT(file.notes, IsEmpty());
}

std::string good_file() {
  return std::string("MeshVersionFormatted 2\nDimension 3\nVertices\n") + kVertices +
         "Tetrahedra\n2\n1 2 3 4 0\n2 3 4 5 0\nEnd\n";
}

TEST(Medit, LineEndsAndSpacingDoNotMatter) {
  const ScratchFolder folder;
  std::string crlf;
  std::string tabs;
  for (const char c : good_file()) {
    crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
    tabs += c == ' ' || c == '\n' ? "\t \v\f" : std::string(1, c);
  }
  for (const std::string& bytes : {crlf, tabs, "\n\n  " + good_file()}) {
    folder.add("a.mesh", bytes);
    EXPECT_EQ(read_medit(folder / "a.mesh").mesh, two_tets());
  }
}

TEST(Medit, WhatFollowsEndIsNotRead) {
  const ScratchFolder folder;
  folder.add("a.mesh", good_file() + "Hexahedra and so on");
  EXPECT_EQ(read_medit(folder / "a.mesh").mesh, two_tets());
}

TEST(Medit, SaysThatEndIsMissing) {
  const ScratchFolder folder;
  std::string bytes = good_file();
  bytes.resize(bytes.size() - 5);
  folder.add("a.mesh", bytes);
  const MeditFile file = read_medit(folder / "a.mesh");
  EXPECT_EQ(file.mesh, two_tets());
  EXPECT_THAT(file.notes, ElementsAre("the file has no End"));
}

TEST(Medit, RestoresOrientationAndSaysSo) {
  const ScratchFolder folder;
  TetMesh mesh = build_kuhn_cube(3, 0.3, 1);
  SplitMix64 random(6);
  std::size_t inverted = 0;
  for (Tet& tet : mesh.tets) {
    if (random.below(3) != 0) continue;
    shuffle(std::span<Index>(tet), random);
    const auto& p = mesh.points;
    inverted += orientation(p[tet[0]], p[tet[1]], p[tet[2]], p[tet[3]]) < 0 ? 1 : 0;
  }
  ASSERT_GT(inverted, 0U);
  write_medit(folder / "a.mesh", mesh);
  const MeditFile file = read_medit(folder / "a.mesh");
  EXPECT_THAT(file.notes, ElementsAre(std::to_string(inverted) +
                                      " of 162 tetrahedra were negatively oriented: positive orientation "
                                      "restored"));
  for (const Tet& t : file.mesh.tets) {
    const auto& p = file.mesh.points;
    EXPECT_EQ(orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]), 1);
  }
  EXPECT_NO_THROW(build_boundary(file.mesh));
  EXPECT_TRUE(is_same_to_the_bit(read_medit(folder / "a.mesh", ReadOrientation::kKeep).mesh, mesh));
}

TEST(Medit, LeavesIsolatedVerticesOutAndSaysSo) {
  const ScratchFolder folder;
  TetMesh mesh{{{7, 7, 7}, {0, 0, 0}, {1, 0, 0}, {8, 8, 8}, {0, 1, 0}, {0, 0, 1}}, {{1, 2, 4, 5}}};
  write_medit(folder / "a.mesh", mesh);
  const MeditFile file = read_medit(folder / "a.mesh");
  EXPECT_EQ(file.mesh, (TetMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}}));
  EXPECT_THAT(file.notes, ElementsAre("2 vertices that no tetrahedron uses were left out"));
  EXPECT_EQ(read_medit(folder / "a.mesh", ReadOrientation::kKeep).mesh, mesh);
}

TEST(Medit, SaysThatReferenceNumbersAreNotKept) {
  const ScratchFolder folder;
  std::string bytes = good_file();
  bytes.replace(bytes.find("2 3 4 5 0"), 9, "2 3 4 5 1");
  folder.add("a.mesh", bytes);
  EXPECT_THAT(read_medit(folder / "a.mesh").notes,
              ElementsAre("reference numbers of the tetrahedra differ: they are not kept"));
}

TEST(Medit, ReadsAPipe) {
  const ScratchFolder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const TetMesh mesh = build_kuhn_cube(8, 0.3, 1);
  std::thread writer([&] { write_medit(pipe, mesh); });
  const MeditFile file = read_medit(pipe);
  writer.join();
  EXPECT_EQ(file.mesh, mesh);
}

TEST(Medit, WritesABrokenMeshForTheJudge) {
  const ScratchFolder folder;
  TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  mesh.tets.push_back(mesh.tets[0]);            // duplicate
  mesh.tets.push_back(mesh.tets[7]);            // and a third on its faces
  std::swap(mesh.tets[3][0], mesh.tets[3][1]);  // inverted
  mesh.tets.push_back({0, 1, 3, 4});            // across others
  ASSERT_THROW(build_boundary(mesh), InputError);
  write_medit(folder / "a.mesh", mesh);
  EXPECT_EQ(read_medit(folder / "a.mesh", ReadOrientation::kKeep).mesh, mesh);
}

TEST(Medit, AnUnwritablePlaceLeavesNothing) {
  const ScratchFolder folder;
  folder.add("file", "x");
  EXPECT_THROW(write_medit(folder / "missing/a.mesh", two_tets()), InputError);
  EXPECT_THROW(write_medit(folder / "file/a.mesh", two_tets()), InputError);
  EXPECT_THROW(write_medit("/dev/full", two_tets()), InputError);
  EXPECT_EQ(folder.count(), 1U);
}

TEST(Medit, RefusesToWriteWhatItCouldNotRead) {
  const ScratchFolder folder;
  TetMesh mesh = two_tets();
  mesh.tets[1][3] = 5;
  EXPECT_THROW(write_medit(folder / "a.mesh", mesh), ContractError);
  mesh = two_tets();
  mesh.points[4].z = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_medit(folder / "a.mesh", mesh), ContractError);
  EXPECT_EQ(folder.count(), 0U);
}

}  // namespace
}  // namespace palpate

#include "core/springs/network/springs_csv.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "core/springs/identification/identify.h"
#include "core/springs/network/network.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_meshes.h"

namespace palpate::springs {
namespace {

using namespace testing_support;
using test::ScratchFolder;

const std::string kHead = "vertex_a,vertex_b,rest_length_m,stiffness_n_per_m\n";

TEST(SpringsCsv, ReadsBackToTheSameBits) {
  const ScratchFolder folder;
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 9);
  for (const bool face_opposite : {false, true}) {
    IdentifyReport report;
    const SpringNetwork network = identify_springs(mesh, {12345.6, 0.25, 0.0}, SpringMethod::kIsotropyPatch,
                                                   {.face_opposite = face_opposite}, report);
    write_springs_csv(folder / "k.csv", network);
    EXPECT_EQ(read_springs_csv(folder / "k.csv", mesh), network);
  }
}

TEST(SpringsCsv, TheFileIsPlain) {
  const ScratchFolder folder;
  SpringNetwork network = build_spring_network(make_corner_tet());
  network.stiffness_n_per_m = {1, 2, 3, 4, 0.5, 0};
  write_springs_csv(folder / "k.csv", network);
  EXPECT_EQ(test::bytes_of(folder / "k.csv"), kHead +
                                                  "0,1,1,1\n0,2,1,2\n0,3,1,3\n"
                                                  "1,2,1.4142135623730951,4\n"
                                                  "1,3,1.4142135623730951,0.5\n"
                                                  "2,3,1.4142135623730951,0\n");
}

TEST(SpringsCsv, WindowsLineEndsAndAMissingLastOneAreRead) {
  const ScratchFolder folder;
  SpringNetwork network = build_spring_network(make_corner_tet());
  write_springs_csv(folder / "k.csv", network);
  std::string text = test::bytes_of(folder / "k.csv");
  text.pop_back();
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.insert(at, "\r");
  EXPECT_EQ(read_springs_csv(folder.add("w.csv", text), make_corner_tet()), network);
}

/// Reads `rows` below the header for the corner tet, and expects this after the file's name.
void expect_refusal(const std::string& text, const std::string& message) {
  const ScratchFolder folder;
  const auto path = folder.add("k.csv", text);
  try {
    read_springs_csv(path, make_corner_tet());
    FAIL() << "accepted: " << message;
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(), path.string() + message);
  }
}

TEST(SpringsCsv, WhatIsNotARowIsRefusedWithItsLine) {
  const std::string row = "two vertices and two finite numbers, separated by commas, found ";
  expect_refusal("", ":1: expected \"vertex_a,vertex_b,rest_length_m,stiffness_n_per_m\", found \"\"");
  expect_refusal("a,b,c\n",
                 ":1: expected \"vertex_a,vertex_b,rest_length_m,stiffness_n_per_m\", found \"a,b,c\"");
  expect_refusal(kHead + "0,1,1\n", ":2: expected " + row + "\"0,1,1\"");
  expect_refusal(kHead + "0,1,1,1\n0,2,1,1,1\n", ":3: expected " + row + "\"0,2,1,1,1\"");
  expect_refusal(kHead + "0,-1,1,1\n", ":2: expected " + row + "\"0,-1,1,1\"");
  expect_refusal(kHead + "0,1,1,nan\n", ":2: expected " + row + "\"0,1,1,nan\"");
  expect_refusal(kHead + "0,1,inf,1\n", ":2: expected " + row + "\"0,1,inf,1\"");
  expect_refusal(kHead + "\n", ":2: expected " + row + "\"\"");
}

TEST(SpringsCsv, SpringsOfAnotherMeshAreRefused) {
  expect_refusal(kHead + "1,0,1,1\n", ":2: expected vertex_a below vertex_b, found 1,0");
  expect_refusal(kHead + "0,4,1,1\n",
                 ":2: expected vertices of the mesh, 0 to 3, found 4: the springs are of another mesh");
  expect_refusal(kHead + "0,1,1,-0.5\n", ":2: expected a stiffness of at least 0, found -0.5");
  expect_refusal(kHead + "0,1,1000,1\n",
                 ":2: expected the distance of vertices 0 and 1, 1 m, found 1000: the springs are of another "
                 "mesh, or of another unit");
  expect_refusal(kHead + "0,2,1,1\n0,1,1,1\n",
                 ":3: expected rows sorted by vertices, each pair once, found (0, 1) after (0, 2)");
  expect_refusal(kHead + "0,1,1,1\n0,1,1,1\n",
                 ":3: expected rows sorted by vertices, each pair once, found (0, 1) after (0, 1)");
  expect_refusal(kHead + "0,1,1,1\n0,3,1,1\n",
                 ": expected a row for every edge of the mesh, found none for (0, 2)");
  expect_refusal(kHead, ": expected a row for every edge of the mesh, found none for (0, 1)");
}

TEST(SpringsCsv, APairThatIsNeitherEdgeNorApexesIsRefused) {
  const ScratchFolder folder;
  const TetMesh mesh = make_kuhn_block(2, 1, 1);
  SpringNetwork network = build_spring_network(mesh, true);
  Edge far{0, 1};
  while (std::binary_search(network.springs.begin(), network.springs.end(), far)) ++far[1];
  ASSERT_LT(far[1], mesh.points.size());
  const auto at =
      std::lower_bound(network.springs.begin(), network.springs.end(), far) - network.springs.begin();
  network.springs.insert(network.springs.begin() + at, far);
  network.rest_length_m.insert(network.rest_length_m.begin() + at,
                               length(mesh.points[far[1]] - mesh.points[0]));
  network.stiffness_n_per_m.insert(network.stiffness_n_per_m.begin() + at, 1.0);
  write_springs_csv(folder / "k.csv", network);
  try {
    read_springs_csv(folder / "k.csv", mesh);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(),
              (folder / "k.csv").string() + ":" + std::to_string(at + 2) +
                  ": expected an edge of the mesh, or the two apexes of an interior face, found "
                  "(0, " +
                  std::to_string(far[1]) + "): the springs are of another mesh");
  }
}

TEST(SpringsCsv, FilesThatCannotBeReadOrWritten) {
  const ScratchFolder folder;
  EXPECT_THROW(read_springs_csv(folder / "none.csv", make_corner_tet()), InputError);
  EXPECT_THROW(read_springs_csv(folder.path(), make_corner_tet()), InputError);
  EXPECT_THROW(write_springs_csv(folder / "no" / "k.csv", build_spring_network(make_corner_tet())),
               InputError);
}

}  // namespace
}  // namespace palpate::springs

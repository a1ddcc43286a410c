// Foreign mesh formats through the converter programs.
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "core/base/error.h"
#include "core/mesh/shapes.h"
#include "experiments/mesh_source.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

const char* const kMshHead =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 0\n6 1 0 1\n"
    "7 0 1 1\n8 1 1 1\n$EndNodes\n$Elements\n";
const char* const kVtkHead =
    "# vtk DataFile Version 3.0\na\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n0 0 0\n1 0 0\n1 1 "
    "0\n0 1 0\n"
    "0 0 1\n1 0 1\n1 1 1\n0 1 1\n";

class Formats : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
    return folder_.path() / name;
  }

  std::string refusal(const std::filesystem::path& path) {
    try {
      read_mesh(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  test::ScratchFolder folder_;
};

TEST_F(Formats, VtuGoesOutAndComesBackToTheBit) {
  const TetMesh cube = build_kuhn_cube(3, 0.2, 5);
  const auto path = folder_.path() / "cube.vtu";
  write_mesh(path, cube);
  EXPECT_EQ(read_mesh(path).mesh, cube);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}),
            1);  // nothing left beside it
}

TEST_F(Formats, MshOfTetsIsRead) {
  const auto path =
      write("a.msh", std::string(kMshHead) + "2\n1 2 2 1 1 1 2 3\n2 4 2 1 1 1 3 2 4\n$EndElements\n");
  const MeditFile file = read_mesh(path);
  EXPECT_EQ(file.mesh.points.size(), 4U);  // the four that no tet uses are left out
  EXPECT_EQ(file.mesh.tets, (std::vector<Tet>{{0, 2, 3, 1}}));
  ASSERT_EQ(file.notes.size(), 1U);
  EXPECT_NE(file.notes[0].find("1 negatively oriented"), std::string::npos);
}

TEST_F(Formats, VtkOfTetsIsRead) {
  const auto path = write("a.vtk", std::string(kVtkHead) + "CELLS 1 5\n4 0 1 3 4\nCELL_TYPES 1\n10\n");
  EXPECT_EQ(read_mesh(path).mesh.tets, (std::vector<Tet>{{0, 1, 2, 3}}));
}

TEST_F(Formats, OtherElementsAreRefusedByName) {
  const auto hexahedron =
      write("h.msh", std::string(kMshHead) + "1\n1 5 2 1 1 1 2 5 3 4 6 8 7\n$EndElements\n");
  EXPECT_NE(refusal(hexahedron).find("Hexahedron"), std::string::npos) << refusal(hexahedron);
  const auto cells =
      write("h.vtk", std::string(kVtkHead) + "CELLS 1 9\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n12\n");
  EXPECT_NE(refusal(cells).find("vtkHexahedron"), std::string::npos) << refusal(cells);
  const auto curved =
      write("c.vtk",
            "# vtk DataFile Version 3.0\na\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 10 double\n"
            "0 0 0\n1 0 0\n0 1 0\n0 0 1\n.5 0 0\n.5 .5 0\n0 .5 0\n0 0 .5\n.5 0 .5\n0 .5 .5\n"
            "CELLS 1 11\n10 0 1 2 3 4 5 6 7 8 9\nCELL_TYPES 1\n24\n");
  EXPECT_NE(refusal(curved).find("vtkQuadraticTetra"), std::string::npos) << refusal(curved);
}

TEST_F(Formats, ADegenerateTetNamesTheUsersFile) {
  const auto path = write("d.msh", std::string(kMshHead) + "1\n1 4 2 1 1 1 2 3 3\n$EndElements\n");
  EXPECT_EQ(refusal(path).rfind(path.string() + ": expected", 0), 0U) << refusal(path);
  EXPECT_NE(refusal(path).find("different vertices"), std::string::npos) << refusal(path);
}

TEST_F(Formats, BrokenFilesAndOtherEndingsAreRefused) {
  for (const char* name : {"a.msh", "a.vtk", "a.vtu"}) {
    EXPECT_NE(refusal(write(name, "")).find("an empty file"), std::string::npos) << name;
    EXPECT_NE(refusal(write(name, std::string("\x02garbage\x00\xff", 10))), "") << name;
    EXPECT_NE(refusal(folder_.path() / (std::string("missing") + (name + 1))), "") << name;
  }
  EXPECT_NE(refusal(write("a.inp", "x")).find(".mesh, .msh, .vtk or .vtu"), std::string::npos);
  EXPECT_THROW(write_mesh(folder_.path() / "a.msh", build_kuhn_cube(1, 0.0, 0)), InputError);
  EXPECT_THROW(write_mesh(folder_.path() / "no_folder" / "a.vtu", build_kuhn_cube(1, 0.0, 0)), InputError);
}

}  // namespace
}  // namespace palpate::experiments

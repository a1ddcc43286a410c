// Foreign mesh formats through the converter programs.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <string>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/meshes/mesh_source.h"
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

TEST_F(Formats, AMshFileIsNoScript) {
  const auto trace = folder_.path() / "trace";
  const std::string script = "SystemCall \"touch " + trace.string() + "\";\n";
  for (const std::string start : {"", "x\n", "\n$MeshFormat\n", " $MeshFormat\n", "$View\n"}) {
    EXPECT_NE(refusal(write("a.msh", start + script)).find("expected a .msh file"), std::string::npos)
        << start;
    EXPECT_FALSE(std::filesystem::exists(trace)) << start;
  }
  for (const std::string start : {"$MeshFormat\n", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", "$Comments\n",
                                  "$NOD\n0\n$ENDNOD\n", "$Comments\n$EndComments\n"}) {
    EXPECT_NE(refusal(write("a.msh", start + script)), "") << start;
    EXPECT_FALSE(std::filesystem::exists(trace)) << start;
  }
}

TEST_F(Formats, WhatLiesBesideAMshFileIsNotRun) {
  const auto trace = folder_.path() / "trace";
  const auto path =
      write("a.msh", std::string(kMshHead) + "2\n1 2 2 1 1 1 2 3\n2 4 2 1 1 1 3 2 4\n$EndElements\n");
  for (const char* name : {"a.msh.opt", "a.opt", "a.geo", ".gmshrc", ".gmsh-options"})
    write(name, "SystemCall \"touch " + trace.string() + "\";\n");
  EXPECT_EQ(read_mesh(path).mesh.points.size(), 4U);
  EXPECT_FALSE(std::filesystem::exists(trace));
}

/// A grid of four points and one tet whose header says what it likes.
std::string vtu_that_claims(const std::string& points, const std::string& cells, const std::string& rest) {
  return "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
         "header_type=\"UInt64\" "
         "compressor=\"vtkZLibDataCompressor\"><UnstructuredGrid><Piece NumberOfPoints=\"" +
         points + "\" NumberOfCells=\"" + cells + "\">" + rest + "</Piece></UnstructuredGrid></VTKFile>\n";
}

TEST_F(Formats, AVtuFileThatClaimsWhatItHasNotIsRefused) {
  const std::string points = "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"";
  const std::string cells =
      "<Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray><DataArray "
      "type=\"Int64\" Name=\"offsets\" format=\"ascii\">4</DataArray><DataArray type=\"UInt8\" "
      "Name=\"types\" "
      "format=\"ascii\">10</DataArray></Cells>";
  const std::string few = points + "ascii\">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>" + cells;
  EXPECT_EQ(read_mesh(write("good.vtu", vtu_that_claims("4", "1", few))).mesh.tets.size(), 1U);
  for (const char* count : {"1000000000", "99999999999", "9223372036854775807", "-1", "5", "nan"}) {
    EXPECT_NE(refusal(write("points.vtu", vtu_that_claims(count, "1", few))), "") << count << " points";
    EXPECT_NE(refusal(write("cells.vtu", vtu_that_claims("4", count, few))), "") << count << " cells";
  }
  // Compressed: so many blocks, of so many bytes each, of which there are none.
  for (const char* header : {"//////////8=", "AAAAAAEAAAA=", "AQAAAAAAAAD//////////wAAAAAAAAAA"}) {
    const std::string lies = points + "binary\">" + header + "</DataArray></Points>" + cells;
    EXPECT_NE(refusal(write("blocks.vtu", vtu_that_claims("4", "1", lies))), "") << header;
  }
}

TEST_F(Formats, AFileOfHolesIsHandedToNoVendor) {
  for (const char* name : {"holes.msh", "holes.vtk", "holes.vtu"}) {
    const auto path = write(name, "x");
    std::filesystem::resize_file(path, std::uint64_t{1} << 40U);
    EXPECT_NE(refusal(path).find("a file of at most 4294967296 bytes, found 1099511627776"),
              std::string::npos);
  }
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

TEST_F(Formats, AnElementNumberThatIsThereTwiceIsRefused) {
  // gmsh keeps one of them, and says nothing.
  const std::string tets = "2\n7 4 2 1 1 1 2 3 5\n7 4 2 1 1 2 3 5 6\n$EndElements\n";
  const std::string twice = refusal(write("a.msh", kMshHead + tets));
  EXPECT_NE(twice.find("expected elements with a number of their own, found element number 7 on line"),
            std::string::npos)
      << twice;
  // Two blocks of version 4.1.
  const std::string head =
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 5 1 5\n3 1 0 5\n1\n2\n3\n4\n5\n"
      "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1\n$EndNodes\n$Elements\n2 2 1 2\n3 1 4 1\n1 1 2 3 4\n3 1 4 1\n";
  const std::string blocks = refusal(write("b.msh", head + "1 2 3 4 5\n$EndElements\n"));
  EXPECT_NE(blocks.find(":23: expected elements"), std::string::npos) << blocks;
  EXPECT_NE(blocks.find("element number 1 on line 21 too"), std::string::npos) << blocks;
  EXPECT_EQ(read_mesh(write("c.msh", head + "2 2 3 4 5\n$EndElements\n")).mesh.tets.size(), 2U);
}

TEST_F(Formats, ANodeNumberThatIsThereTwiceIsRefused) {
  const std::string nodes =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n4 1 1 1\n"
      "$EndNodes\n$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n";
  const std::string twice = refusal(write("a.msh", nodes));
  EXPECT_NE(twice.find(":10: expected nodes with a number of their own, found node number 4 on line 9 too"),
            std::string::npos)
      << twice;
}

/// Bytes of a value, as a binary .msh file holds them.
template <typename T>
void put(std::string& bytes, std::initializer_list<T> values) {
  for (const T value : values) {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), &value, sizeof(T));
    bytes.append(raw.data(), raw.size());
  }
}

class BinaryMsh : public Formats {
 protected:
  void expect_one_number_each(const std::filesystem::path& path, bool is_sound) {
    if (is_sound) {
      EXPECT_EQ(read_mesh(path).mesh.tets.size(), 2U) << path;
    } else {
      EXPECT_NE(refusal(path).find("element number 1 twice"), std::string::npos) << refusal(path);
    }
  }
};

TEST_F(BinaryMsh, NumbersAreLookedAtToo) {
  for (const std::int32_t second : {1, 2}) {
    std::string bytes = "$MeshFormat\n2.2 1 8\n";
    put<std::int32_t>(bytes, {1});
    bytes += "\n$EndMeshFormat\n$Nodes\n5\n";
    const std::array<std::array<double, 3>, 5> points{
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}};
    for (std::int32_t i = 0; i < 5; ++i) {
      const auto& p = points[static_cast<std::size_t>(i)];
      put<std::int32_t>(bytes, {i + 1});
      put<double>(bytes, {p[0], p[1], p[2]});
    }
    bytes += "\n$EndNodes\n$Elements\n2\n";
    put<std::int32_t>(bytes, {4, 2, 2, 1, 1, 1, 1, 2, 3, 4, second, 1, 1, 2, 3, 4, 5});
    bytes += "\n$EndElements\n";
    const auto path = write("b" + std::to_string(second) + ".msh", bytes);
    expect_one_number_each(path, second == 2);

    bytes = "$MeshFormat\n4.1 1 8\n";
    put<std::int32_t>(bytes, {1});
    bytes += "\n$EndMeshFormat\n$Nodes\n";
    put<std::uint64_t>(bytes, {1, 5, 1, 5});
    put<std::int32_t>(bytes, {3, 1, 0});
    put<std::uint64_t>(bytes, {5, 1, 2, 3, 4, 5});
    for (const auto& p : points) put<double>(bytes, {p[0], p[1], p[2]});
    bytes += "\n$EndNodes\n$Elements\n";
    put<std::uint64_t>(bytes, {1, 2, 1, 2});
    put<std::int32_t>(bytes, {3, 1, 4});
    put<std::uint64_t>(bytes, {2, 1, 1, 2, 3, 4, static_cast<std::uint64_t>(second), 2, 3, 4, 5});
    bytes += "\n$EndElements\n";
    const auto newer = write("n" + std::to_string(second) + ".msh", bytes);
    expect_one_number_each(newer, second == 2);
  }
}

TEST_F(Formats, TetsThatAllStandAloneAreRefusedAndTheirDoubledPointsNamed) {
  const TetMesh cube = build_kuhn_cube(3, 0.0, 0);
  TetMesh apart;
  for (const Tet& t : cube.tets) {
    const auto first = static_cast<Index>(apart.points.size());
    for (const Index v : t) apart.points.push_back(cube.points[v]);
    apart.tets.push_back({first, first + 1, first + 2, first + 3});
  }
  const auto path = folder_.path() / "apart.mesh";
  write_mesh(path, apart);
  // 6 * 27 tets, 4 points each, of which 4^3 differ.
  EXPECT_NE(
      refusal(path).find("found 162 that all stand alone: 584 of 648 points are doubled, as vertices 1 and"),
      std::string::npos)
      << refusal(path);
  write_mesh(path, cube);
  EXPECT_EQ(refusal(path), "");
  // Two tets that stand apart in space are two bodies.
  write_mesh(path, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {5, 0, 1}},
                    {{0, 1, 2, 3}, {4, 5, 6, 7}}});
  EXPECT_EQ(refusal(path), "");
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

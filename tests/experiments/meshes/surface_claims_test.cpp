// What a file of a surface claims: taken where it is there, refused at once where it is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "experiments/meshes/mesh_source.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using testing::HasSubstr;

/// A file by its name, and what has to stand in its refusal; nothing for a good one.
struct SurfaceClaim {
  std::string name;
  std::string bytes;
  std::string expected;
};

const std::vector<int> kCorners{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
const std::vector<float> kPoints{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
const std::string kPointRows = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
const std::string kFaceRows = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

/// The bytes of a number, the lowest first or the highest.
template <typename Number>
std::string bytes_of(Number number, bool is_big) {
  std::string bytes(reinterpret_cast<const char*>(&number), sizeof number);
  return is_big ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

/// Points of a tetrahedron, each with `more` numbers behind it.
std::string binary_points(bool is_big, int more) {
  std::string bytes;
  for (std::size_t k = 0; k < kPoints.size(); ++k) {
    bytes += bytes_of(kPoints[k], is_big);
    for (int m = 0; k % 3 == 2 && m < more; ++m) bytes += bytes_of(0.5F, is_big);
  }
  return bytes;
}

/// Its triangles, each with the count 3 as a number of that type.
template <typename Count>
std::string binary_faces(bool is_big) {
  std::string bytes;
  for (std::size_t k = 0; k < kCorners.size(); ++k) {
    if (k % 3 == 0) bytes += bytes_of(Count{3}, is_big);
    bytes += bytes_of(kCorners[k], is_big);
  }
  return bytes;
}

/// A binary OFF file with these counts in its header.
std::string binary_off(const std::string& keyword, int vertices, int faces, const std::string& body) {
  return keyword + " BINARY\n" + bytes_of(vertices, true) + bytes_of(faces, true) + bytes_of(6, true) + body;
}

std::string ply_header(const std::string& form, const std::string& count, const std::string& more) {
  return "ply\nformat " + form + " 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty float y\n" +
         "property float z\n" + more + "element face 4\nproperty list " + count +
         " int vertex_indices\nend_header\n";
}

/// Each in one line that says which, and what our own walk found, before CGAL saw the file.
void expect_refusals(const std::vector<SurfaceClaim>& claims) {
  const test::ScratchFolder folder;
  for (const SurfaceClaim& claim : claims) {
    std::string message;
    try {
      mesh_surface({folder.add(claim.name, claim.bytes), {}});
    } catch (const InputError& error) {
      message = error.what();
    }
    EXPECT_THAT(message, HasSubstr(claim.name));
    EXPECT_THAT(message, HasSubstr(claim.expected)) << claim.name;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

void expect_tetrahedra(const std::vector<SurfaceClaim>& claims) {
  const test::ScratchFolder folder;
  for (const SurfaceClaim& claim : claims) {
    SCOPED_TRACE(claim.name);
    const MadeMesh made = mesh_surface({folder.add(claim.name, claim.bytes), {}});
    EXPECT_NEAR(total_volume(made.mesh), 1.0 / 6.0, 1e-9);
  }
}

TEST(SurfaceClaims, GoodOffFilesOfEveryKindAreRead) {
  const std::string faces = binary_faces<int>(true);
  expect_tetrahedra({
      {"plain.OFF", "OFF\n4 4 6\n" + kPointRows + kFaceRows, ""},
      {"one_line.off", "OFF 4 4 0\n" + kPointRows + kFaceRows, ""},
      {"comments.off", "# a\nOFF\n# b\n4\n4 0 # c\n" + kPointRows + "\n  # d\n" + kFaceRows, ""},
      {"colored_faces.off", "OFF\n4 4 0\n" + kPointRows + "3 0 2 1 9\n3 0 1 3 9\n3 0 3 2\n3 1 2 3", ""},
      {"carriage.off", "OFF\r\n4 4 0\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n0 0 1\r\n" + kFaceRows, ""},
      {"colors.off", "COFF\n4 4 0\n0 0 0 1 2 3\n1 0 0 1 2 3 4\n0 1 0 1 2 3\n0 0 1 0.1 0.2 0.3\n" + kFaceRows,
       ""},
      {"face_colors.off",
       "COFF\n4 4 0\n0 0 0 1 2 3\n1 0 0 1 2 3 4\n0 1 0 0 0 2555\n0 0 1 0.1 1 1\n3 0 2 1\n3 0 1 3 255 0 0\n" +
           std::string("3 0 3 2\n3 1 2 3 1 0.5 0\n"),
       ""},
      {"textures.off", "# a\nSTOFF 4 4 0\n0 0 0 0 0\n1 0 0 0 0\n0 1 0 0 0\n0 0 1 0 0\n" + kFaceRows, ""},
      {"edges.off", "OFF\n4 4 -858993460\n" + kPointRows + kFaceRows, ""},
      {"normals.off", "NOFF\n4 4 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n0 0 1 0 0 1\n" + kFaceRows, ""},
      {"four.off", "4OFF\n4 4 0\n0 0 0 1\n2 0 0 2\n0 1 0 1\n0 0 1 1\n" + kFaceRows, ""},
      {"skeleton.off", "SKEL\n4 4\n" + kPointRows + kFaceRows, ""},
      {"dimensions.off", "nOFF\n3\n4 4 0\n" + kPointRows + kFaceRows, ""},
      {"binary.off", binary_off("OFF", 4, 4, binary_points(true, 0) + faces), ""},
      {"binary_comment.off", "#\n" + binary_off("OFF", 4, 4, binary_points(true, 0) + faces), ""},
      {"binary_normals.off", binary_off("NOFF", 4, 4, binary_points(true, 3) + faces), ""},
      {"binary_textures.off", binary_off("STOFF", 4, 4, binary_points(true, 2) + faces), ""},
  });
}

TEST(SurfaceClaims, GoodPlyFilesOfEveryKindAreRead) {
  const std::string colors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const std::string other = "element other 2\nproperty list ushort double w\nproperty char c\n";
  const auto w = [](bool is_big) {
    return bytes_of(std::uint16_t{1}, is_big) + bytes_of(0.5, is_big) + "c" +
           bytes_of(std::uint16_t{0}, is_big) + "d";
  };
  expect_tetrahedra({
      {"plain.PLY", ply_header("ascii", "uchar", "") + kPointRows + kFaceRows, ""},
      {"one_line.ply",
       ply_header("ascii", "int", "") + "0 0 0 1 0 0 0 1 0 0 0 1e0 3 0 2 1 3 0 1 3 3 0 3 2 +3 1 2 3", ""},
      {"colors.ply",
       ply_header("ascii", "uint8", colors) + "0 0 0 1 2 3\n1. 0 0 255 0 0\n0 +1 0 1 2 3\n0 -0 1 1 2 3\n" +
           kFaceRows,
       ""},
      {"other.ply", ply_header("ascii", "uint", other) + kPointRows + "2 0.5 7 -3\n0 4\n" + kFaceRows, ""},
      {"little.ply",
       ply_header("binary_little_endian", "uchar", "") + binary_points(false, 0) +
           binary_faces<std::uint8_t>(false),
       ""},
      {"big.ply",
       ply_header("binary_big_endian", "uint", "property float q\n") + binary_points(true, 1) +
           binary_faces<std::uint32_t>(true),
       ""},
      {"little_other.ply",
       ply_header("binary_little_endian", "short", other) + binary_points(false, 0) + w(false) +
           binary_faces<std::int16_t>(false),
       ""},
      {"big_other.ply",
       ply_header("binary_big_endian", "int", other) + binary_points(true, 0) + w(true) +
           binary_faces<int>(true) + "more",
       ""},
  });
}

/// CGAL 5.5.1 made room for a billion faces of the first (24 GB), and for what a face claimed to have (15
/// GB).
TEST(SurfaceClaims, OffFilesThatClaimMoreThanTheyHoldAreRefusedBeforeTheyAreRead) {
  const std::string points = binary_points(true, 0);
  const std::string faces = binary_faces<int>(true);
  const std::string corners = bytes_of(2000000000, true) + faces.substr(4);
  const std::string text = kPointRows + kFaceRows;
  expect_refusals({
      {"faces.off", binary_off("OFF", 4, 1000000000, points + faces),
       "expected faces that 135 bytes can hold"},
      {"corners.off", binary_off("OFF", 4, 4, points + corners),
       "expected triangles only, found a polygon of 2000000000 corners, face 1 of 4"},
      {"negative.off", binary_off("OFF", -4, 4, points + faces), "found -4"},
      {"cut.off", binary_off("OFF", 4, 4, points + faces.substr(0, 40)),
       "expected 4 vertices and 4 faces, as the header says, found 2 faces"},
      {"points.off", binary_off("OFF", 9, 4, points + faces), "as the header says, found 0 faces"},
      {"few_points.off", binary_off("OFF", 40, 4, points + faces), "found 9 vertices"},
      {"index.off", binary_off("OFF", 3, 4, points.substr(0, 36) + faces),
       "expected vertices 0 to 2 in face 2 of 4, found 3"},
      {"color_count.off",
       binary_off("OFF", 4, 4, points + faces.substr(0, 16) + bytes_of(0, true) + faces.substr(16)),
       "of face 2 of 4, without a count of colours between faces, found 0 corners"},
      {"colors.off", binary_off("COFF", 4, 4, points + faces), "expected OFF BINARY or NOFF BINARY"},
      {"comment.off", "#\n" + binary_off("OFF", 4, 1000000000, ""), "expected faces that 25 bytes can hold"},
      {"capital.OFF", "OFF\n2000000000 1 0\n0 0 0\n", "capital.OFF:2: expected vertices that 25 bytes"},
      {"counts.off", "OFF\n4\n1000000000 0\n" + text, "counts.off:3: expected faces that"},
      {"edges.off", "OFF\n4 4 1500000000\n" + text,
       "expected edges, -1073741823 to 1073741823, found 1500000000"},
      {"rest.off", "OFF\n1 1 0 0 0 0\n1000000000 0 0\n", "rest.off:3: expected corners of a face"},
      {"row.off", "OFF\n4 4 0\n0 0\n" + text, "row.off:3: expected a vertex of 3 numbers, found 0 0"},
      {"far.off", "OFF\n4 4 0\n" + kPointRows + "3 0 2 9\n", "far.off:7: expected vertices 0 to 3, found 9"},
      {"no_counts.off", "OFF\n", "expected counts behind OFF, found the end of the file"},
  });
}

/// CGAL 5.5.1 goes on through all that a list claims once the file is at its end: four billion numbers.
TEST(SurfaceClaims, PlyFilesThatClaimMoreThanTheyHoldAreRefusedBeforeTheyAreRead) {
  const std::string text = ply_header("ascii", "uint", "");
  const std::string bytes = ply_header("binary_little_endian", "uint", "");
  const std::string points = binary_points(false, 0);
  const std::string faces = binary_faces<std::uint32_t>(false);
  const std::string list = ply_header("ascii", "uchar", "property list uint double w\n");
  expect_refusals({
      {"list.ply", text + kPointRows + "4294967295 0 2 1\n" + kFaceRows.substr(8),
       "list.ply:15: expected vertex_indices of face 1 of 4 that 228 bytes can hold, found 4294967295"},
      {"over.ply", text + kPointRows + "99999999999 0 2 1\n" + kFaceRows.substr(8),
       "over.ply:15: expected vertex_indices of face 1 of 4, uint, found 99999999999"},
      {"minus.ply", text + kPointRows + "-1 0 2 1\n" + kFaceRows.substr(8), "of face 1 of 4, uint, found -1"},
      {"half.ply", text + kPointRows + "3.5 0 2 1\n" + kFaceRows.substr(8),
       "of face 1 of 4, uint, found 3.5"},
      {"word.ply", text + "0 0 0\n1 0 zero\n0 1 0\n0 0 1\n" + kFaceRows,
       "word.ply:12: expected z of vertex 2 of 4, float, found zero"},
      {"vertex_list.ply", list + "0 0 0 4294967295\n1 0 0 0\n0 1 0 0\n0 0 1 0\n" + kFaceRows,
       "expected w of vertex 1 of 4 that "},
      {"binary_list.ply", bytes + points + bytes_of(std::uint32_t{4294967295U}, false) + faces.substr(4),
       "expected vertex_indices of face 1 of 4 that "},
      {"binary_cut.ply", bytes + points + faces.substr(0, 34),
       "expected 4 of element face, as the header says, found 2 and the end of the file"},
      {"binary_points.ply", bytes + points.substr(0, 30),
       "expected 4 of element vertex, as the header says, found 2 and the end of the file"},
      {"quad.ply", text + kPointRows + "4 0 2 1 3\n" + kFaceRows.substr(8),
       "expected triangles only, found a polygon of 4 corners, face 1 of 4"},
      {"no_end.ply", "ply\nformat ascii 1.0\nelement vertex 4\n", "expected end_header"},
      {"type.ply", ply_header("ascii", "half", "") + kPointRows + kFaceRows,
       "type.ply:9: expected a property"},
      {"sum.ply", "ply\nformat ascii 1.0\nelement a 40\nelement b 40\nend_header\n",
       "sum.ply:4: expected an element"},
  });
}

/// CGAL 5.5.1 takes a property by its name and asks a pointer of the wrong type, which is none.
TEST(SurfaceClaims, PlyPropertiesOfAnotherTypeThanTheirNamesHaveAreRefused) {
  const std::string rows = "0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n0 1 0 1 1 1 1\n0 0 1 1 1 1 1\n" + kFaceRows;
  const std::string colors = "property uchar red\nproperty uchar g\nproperty uchar b\nproperty float green\n";
  std::string whole = ply_header("ascii", "uchar", "");
  whole.replace(whole.find("float x"), 5, "int");
  expect_refusals({
      {"whole.ply", whole + kPointRows + kFaceRows,
       "whole.ply:4: expected x of type double or float in element vertex, found int"},
      {"green.ply", ply_header("ascii", "uchar", colors) + rows,
       "expected green of type uchar in element vertex, found float"},
      {"edge.ply",
       ply_header("ascii", "uchar", "element halfedge 1\nproperty int source\n") + kPointRows + "0\n" +
           kFaceRows,
       "expected source of type uint in element halfedge, found int"},
  });
}

}  // namespace
}  // namespace palpate::experiments

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/orientation.h"
#include "experiments/processes/child/sanitizers.h"
#include "tests/support/scratch_folder.h"

namespace palpate {
namespace {

using test::ScratchFolder;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A good file, one entry a line; line n is entry n - 1.
std::vector<std::string> good_lines() {
  return {"MeshVersionFormatted 2",
          "Dimension 3",
          "Vertices",
          "5",
          "0 0 0 0",
          "1 0 0 0",
          "0 1 0 0",
          "0 0 1 0",
          "1 1 1 0",
          "Tetrahedra",
          "2",
          "1 2 3 4 0",
          "2 3 4 5 0",
          "End"};
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

/// The good file with line `number` (from 1) replaced.
std::string with_line(std::size_t number, const std::string& text) {
  std::vector<std::string> lines = good_lines();
  lines.at(number - 1) = text;
  return joined(lines);
}

std::string message_for(const ScratchFolder& folder, const std::string& bytes) {
  const std::string path = folder.add("bad.mesh", bytes);
  try {
    read_medit(path);
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), StartsWith(path));
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return std::string(error.what()).substr(path.size());
  }
  return "(read without an error)";
}

struct Case {
  std::string bytes;
  std::string message;  ///< behind the name of the file
};

void expect_messages(const std::vector<Case>& cases) {
  const ScratchFolder folder;
  for (const Case& c : cases) EXPECT_EQ(message_for(folder, c.bytes), c.message);
}

TEST(MeditBadInput, MissingFolderAndEmptyFile) {
  const ScratchFolder folder;
  const auto message = [](const std::string& path) {
    try {
      read_medit(path);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(message(folder / "no.mesh"),
            (folder / "no.mesh").string() + ": expected a mesh file, found no such file");
  EXPECT_EQ(message(folder.path()), folder.path().string() + ": expected a mesh file, found a folder");
  EXPECT_EQ(message_for(folder, ""), ": expected a MEDIT mesh, found an empty file");
  EXPECT_EQ(message_for(folder, " \n\n"),
            ":3: expected MeshVersionFormatted (a MEDIT mesh), found the end of the file");
}

TEST(MeditBadInput, Header) {
  expect_messages({
      {with_line(1, "MeshVersionUnformatted 2"), ":1: expected an ASCII MEDIT mesh, found a binary one"},
      {with_line(1, "solid kidney"), ":1: expected MeshVersionFormatted (a MEDIT mesh), found \"solid\""},
      {with_line(1, "MeshVersionFormatted 5"), ":1: expected a MEDIT version from 1 to 4, found 5"},
      {with_line(1, "MeshVersionFormatted two"), ":1: expected the MEDIT version, found \"two\""},
      {with_line(2, "Dimension 2"), ":2: expected dimension 3, found 2"},
      {with_line(2, "Dimension"), ":3: expected the dimension, found \"Vertices\""},
      {with_line(3, "Vertexes"), ":3: expected a MEDIT keyword after Dimension, found \"Vertexes\""},
  });
}

TEST(MeditBadInput, Coordinates) {
  const std::string finite = "expected a finite coordinate of vertex 2 of 5 within +-1e90, found ";
  const std::string number = "expected a coordinate of vertex 2 of 5, found ";
  expect_messages({
      {with_line(6, "nan 0 0 0"), ":6: " + finite + "\"nan\""},
      {with_line(6, "0 -NaN 0 0"), ":6: " + finite + "\"-NaN\""},
      {with_line(6, "0 inf 0 0"), ":6: " + finite + "\"inf\""},
      {with_line(6, "0 0 -Infinity 0"), ":6: " + finite + "\"-Infinity\""},
      {with_line(6, "1e400 0 0 0"), ":6: " + finite + "\"1e400\""},
      {with_line(6, "1 -2e90 0 0"), ":6: " + finite + "\"-2e90\""},
      {with_line(6, "1,5 0 0 0"), ":6: " + number + "\"1,5\""},
      {with_line(6, "1.0x 0 0 0"), ":6: " + number + "\"1.0x\""},
      {with_line(6, "+-1 0 0 0"), ":6: " + number + "\"+-1\""},
      {with_line(6, "+ 1 0 0 0"), ":6: " + number + "\"+\""},
      {with_line(6, "1 0 0"), ":10: expected the reference number of vertex 5 of 5, found \"Tetrahedra\""},
      {with_line(6, "1 0 0 0.5"), ":6: expected the reference number of vertex 2 of 5, found \"0.5\""},
  });
}

TEST(MeditBadInput, Counts) {
  expect_messages({
      {with_line(4, "4"), ":9: expected a MEDIT keyword after Vertices, found \"1\""},
      {with_line(4, "6"), ":10: expected a coordinate of vertex 6 of 6, found \"Tetrahedra\""},
      {with_line(4, "-1"), ":4: expected a number of vertices that is not negative, found -1"},
      {with_line(4, "five"), ":4: expected the number of vertices, found \"five\""},
      {with_line(4, "5.0"), ":4: expected the number of vertices, found \"5.0\""},
      {with_line(11, "1"), ":13: expected a MEDIT keyword after Tetrahedra, found \"2\""},
      {with_line(11, "99999999999999999999"),
       ":11: expected the number of tetrahedra, found \"99999999999999999999\""},
      {with_line(10, "Corners\n3\n1 2\nTetrahedra"),
       ":13: expected a number of Corners 3 of 3, found \"Tetrahedra\""},
      {with_line(10, "Triangles\n2\n1 2 3 0\nTetrahedra"),
       ":13: expected a vertex number from 1 to 5 in triangle 2 of 2, found \"Tetrahedra\""},
      {with_line(3, "Tetrahedra\n1\n1 2 3 4 0\nVertices"),
       ":4: expected the section Vertices before tetrahedra, found none"},
      {with_line(14, "Vertices\n1\n0 0 0 0\nEnd"), ":14: expected one section Vertices, found a second"},
      {with_line(14, "Tetrahedra\n1\n1 2 3 4 0\nEnd"),
       ":14: expected one section Tetrahedra, found a second"},
  });
}

TEST(MeditBadInput, TooManyTetsForTheFile) {
  std::vector<std::string> lines = good_lines();
  lines[10] = "3";
  lines[13] = "# a file that is long enough for three";
  expect_messages(
      {{joined(lines),
        ":15: expected a vertex number from 1 to 5 in tetrahedron 3 of 3, found the end of the file"},
       {with_line(11, "3"),
        ":11: expected a number of tetrahedra that the file can hold (at most 2), found 3"}});
}

TEST(MeditBadInput, Indices) {
  const std::string expected = ":13: expected a vertex number from 1 to 5 in tetrahedron 2 of 2, found ";
  expect_messages({
      {with_line(13, "2 3 4 6 0"), expected + "\"6\""},
      {with_line(13, "2 3 4 0 0"), expected + "\"0\""},
      {with_line(13, "2 3 4 -5 0"), expected + "\"-5\""},
      {with_line(13, "2 3 4 4294967297 0"), expected + "\"4294967297\""},
      {with_line(13, "2 3 4 18446744073709551617 0"), expected + "\"18446744073709551617\""},
      {with_line(13, "2 3 4 5.0 0"), expected + "\"5.0\""},
      {with_line(13, "2 3 4 5 x"), ":13: expected the reference number of tetrahedron 2 of 2, found \"x\""},
      {with_line(13, "2 3 4 2 0"),
       ":13: expected different vertices in tetrahedron 2 of 2, found vertex 2 twice"},
      {with_line(10, "Triangles\n1\n1 2 9 0\nTetrahedra"),
       ":12: expected a vertex number from 1 to 5 in triangle 1 of 1, found \"9\""},
      {with_line(10, "Triangles\n1\n4 4 1 0\nTetrahedra"),
       ":12: expected different vertices in triangle 1 of 1, found vertex 4 twice"},
  });
}

TEST(MeditBadInput, FlatTetsAndPoints) {
  expect_messages({
      {with_line(8, "1 1 0 0"),
       ": expected tetrahedra with a volume, found tetrahedron 1 that is flat (degenerate)"},
      {with_line(9, "0.25 0.25 0.5 0"),
       ": expected tetrahedra with a volume, found tetrahedron 2 that is flat (degenerate)"},
  });
  const ScratchFolder folder;
  std::vector<std::string> lines = good_lines();
  for (std::size_t l = 4; l < 9; ++l) lines[l] = "3 4 5 0";
  EXPECT_THAT(message_for(folder, joined(lines)), HasSubstr("expected vertices at least 1e-90 apart"));
}

TEST(MeditBadInput, OtherElementsAreNamed) {
  for (const char* kind : {"Hexahedra", "Hexaedra", "Quadrilaterals", "Prisms", "Pyramids", "TetrahedraP2",
                           "TrianglesP2", "EdgesP2", "HexahedraQ2", "TetrahedraP3"}) {
    const ScratchFolder folder;
    EXPECT_EQ(message_for(folder, with_line(10, std::string(kind) + "\n1\n1 2 3 4 5 1 2 3 0\nTetrahedra")),
              std::string(":10: expected linear tetrahedra and triangles only, found ") + kind);
  }
}

TEST(MeditBadInput, NoTetrahedra) {
  std::vector<std::string> lines = good_lines();
  lines.erase(lines.begin() + 9, lines.begin() + 13);
  expect_messages({
      {joined(lines), ": expected tetrahedra, found none"},
      {"MeshVersionFormatted 2\nDimension 3\nEnd\n", ": expected a section Vertices, found none"},
  });
  lines.insert(lines.begin() + 9, "Triangles\n2\n1 2 3 0\n2 3 4 0");
  expect_messages({{joined(lines), ": expected tetrahedra, found none, only 2 triangles"}});
}

/// No more address space than now and 32 MB while it lives. Sanitizers need address space of their own.
class MemoryLimit {
 public:
  MemoryLimit() {
    ::getrlimit(RLIMIT_AS, &former_);
    if (experiments::kIsSanitized) return;
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlimit limit{pages * 4096 + (32U << 20U), former_.rlim_max};
    ::setrlimit(RLIMIT_AS, &limit);
  }
  ~MemoryLimit() { ::setrlimit(RLIMIT_AS, &former_); }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  rlimit former_{};
};

TEST(MeditBadInput, AClaimOfGigabytesCostsNoMemory) {
  const ScratchFolder folder;
  const MemoryLimit limit;
  EXPECT_EQ(message_for(folder, with_line(4, "1000000000")),
            ":4: expected a number of vertices that the file can hold (at most 9), found 1000000000");
  EXPECT_EQ(message_for(folder, with_line(4, "2147483648")),
            ":4: expected fewer than 2^30 vertices, found 2147483648");
  EXPECT_EQ(message_for(folder, with_line(11, "1000000000")),
            ":11: expected a number of tetrahedra that the file can hold (at most 2), found 1000000000");
  EXPECT_EQ(message_for(folder, with_line(10, "Triangles\n1000000000\nTetrahedra")),
            ":11: expected a number of triangles that the file can hold (at most 4), found 1000000000");
  EXPECT_EQ(message_for(folder, with_line(10, "Corners\n1000000000\nTetrahedra")),
            ":11: expected a number of Corners that the file can hold (at most 19), found 1000000000");
}

/// Reads bytes that may be bad: an InputError, or a mesh that keeps every promise of the reader.
bool is_read_well_or_refused(const ScratchFolder& folder, const std::string& bytes) {
  const std::string path = folder.add("any.mesh", bytes);
  try {
    const TetMesh mesh = read_medit(path).mesh;
    if (mesh.tets.empty()) return false;
    const auto& p = mesh.points;
    for (const Vec3& point : p) {
      if (!is_finite(point)) return false;
    }
    for (const Tet& t : mesh.tets) {
      for (const Index v : t) {
        if (v >= p.size()) return false;
      }
      if (orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]) != 1) return false;
    }
    return true;
  } catch (const InputError& error) {
    return std::string(error.what()).starts_with(path) &&
           std::string(error.what()).find('\n') == std::string::npos;
  }
}

TEST(MeditBadInput, TruncatedAtEveryByte) {
  const ScratchFolder folder;
  const std::string whole = joined(good_lines());
  const std::string path = folder.add("whole.mesh", whole);
  const TetMesh mesh = read_medit(path).mesh;
  const std::size_t complete = whole.find("2 3 4 5 0") + 9;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::string cut = folder.add("cut.mesh", whole.substr(0, size));
    // Without the last line, all data are there; "E" and "En" are no keywords.
    const bool is_whole = size == complete || size == complete + 1 || size + 1 == whole.size();
    if (is_whole) {
      EXPECT_EQ(read_medit(cut).mesh, mesh) << size;
    } else {
      EXPECT_THROW(read_medit(cut), InputError) << size;
    }
  }
}

TEST(MeditBadInput, RandomBytes) {
  const ScratchFolder folder;
  const std::string header = "MeshVersionFormatted 2\nDimension 3\nVertices\n";
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    SplitMix64 random(seed);
    std::string bytes = seed % 3 == 0 ? "" : header;
    const std::size_t size = bytes.size() + 1 + random.below(seed % 50 == 0 ? 100000 : 600);
    while (bytes.size() < size) {
      // Binary, or text of the characters that numbers are made of.
      bytes += seed % 2 == 0 ? static_cast<char>(random.below(256)) : "0123456789 \n-+.eE#"[random.below(18)];
    }
    EXPECT_TRUE(is_read_well_or_refused(folder, bytes)) << "seed " << seed;
    EXPECT_THROW(read_medit(folder / "any.mesh"), InputError) << "seed " << seed;
  }
}

TEST(MeditBadInput, MutatedFiles) {
  const ScratchFolder folder;
  const std::string whole = joined(good_lines());
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    SplitMix64 random(seed);
    std::string bytes = whole;
    for (std::uint64_t edits = 1 + random.below(4); edits > 0 && !bytes.empty(); --edits) {
      const std::size_t at = random.below(bytes.size());
      switch (random.below(4)) {
        case 0:
          bytes[at] = static_cast<char>(random.below(256));
          break;
        case 1:
          bytes.erase(at, 1 + random.below(20));
          break;
        case 2:
          bytes.insert(at, bytes.substr(random.below(bytes.size()), 1 + random.below(20)));
          break;
        default:
          bytes[at] = "0123456789 \n-."[random.below(14)];
          break;
      }
    }
    EXPECT_TRUE(is_read_well_or_refused(folder, bytes)) << "seed " << seed;
  }
}

TEST(MeditBadInput, BinaryDataAreNamed) {
  const ScratchFolder folder;
  EXPECT_EQ(message_for(folder, std::string(100, '\0')), ":1: expected text, found binary data");
  EXPECT_EQ(message_for(folder, std::string(5000, 'x')), ":1: expected text, found binary data");
  EXPECT_EQ(message_for(folder, with_line(6, std::string("1 0 0\0 0", 8))),
            ":6: expected text, found binary data");
  EXPECT_THAT(message_for(folder, with_line(6, "\x01\x02 0 0 0")), HasSubstr("found \"\?\?\""));
}

}  // namespace
}  // namespace palpate

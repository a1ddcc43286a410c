#include "core/mesh/io/medit.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/io/word_reader.h"
#include "core/mesh/orientation.h"
#include "core/mesh/topology.h"

namespace palpate {
namespace {

constexpr double kLargestCoordinate = 1e90;  // its cube and the products of the predicates stay finite

std::string shown(std::string_view word) {
  if (word.empty()) return "the end of the file";
  std::string text = "\"";
  for (const char c : word.substr(0, 40)) text += (c >= ' ' && c <= '~') ? c : '?';
  return text + (word.size() > 40 ? "...\"" : "\"");
}

/// What is being read, for messages: "vertex 17 of 100".
struct Row {
  const char* kind;
  std::uint64_t number;
  std::uint64_t count;

  std::string text() const {
    return std::string(kind) + " " + std::to_string(number) + " of " + std::to_string(count);
  }
};

/// Takes the whole of `word` as a number. Returns the error of std::from_chars, or invalid_argument.
template <typename Number>
std::errc parse(std::string_view word, Number& value) {
  const char* last = word.data() + word.size();
  const auto [end, error] = std::from_chars(word.data(), last, value);
  return error == std::errc() && end != last ? std::errc::invalid_argument : error;
}

double read_coordinate(WordReader& reader, const Row& row) {
  const std::string_view word = reader.next();
  const bool has_plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
  double value = 0.0;
  const std::errc error = parse(word.substr(has_plus ? 1 : 0), value);
  if (error == std::errc::invalid_argument) reader.fail("a coordinate of " + row.text(), shown(word));
  if (error != std::errc() || !(std::fabs(value) <= kLargestCoordinate)) {
    reader.fail("a finite coordinate of " + row.text() + " within +-1e90", shown(word));
  }
  return value;
}

/// `what` is called for the message alone, so that a good row costs no text.
template <typename What>
std::int64_t read_integer(WordReader& reader, What&& what) {
  const std::string_view word = reader.next();
  std::int64_t value = 0;
  if (parse(word, value) != std::errc()) reader.fail(what(), shown(word));
  return value;
}

Index read_vertex_index(WordReader& reader, const Row& row, std::size_t vertices) {
  const std::string_view word = reader.next();
  std::int64_t value = 0;
  if (parse(word, value) != std::errc() || value < 1 || value > static_cast<std::int64_t>(vertices)) {
    reader.fail("a vertex number from 1 to " + std::to_string(vertices) + " in " + row.text(), shown(word));
  }
  return static_cast<Index>(value - 1);
}

/// A count, and how many rows memory may be set aside for.
struct Count {
  std::uint64_t rows;
  std::uint64_t reserve;
};

/// Reads a count and holds it against the bytes that are left, so that a lying file costs no memory.
Count read_count(WordReader& reader, const char* section, std::uint64_t smallest_row_bytes) {
  const std::string kind(section);
  const std::int64_t count = read_integer(reader, [&] { return "the number of " + kind; });
  if (count < 0) reader.fail("a number of " + kind + " that is not negative", std::to_string(count));
  if (count >= (std::int64_t{1} << 30)) {
    reader.fail("fewer than 2^30 " + kind, std::to_string(count));
  }
  const auto rows = static_cast<std::uint64_t>(count);
  if (!reader.has_size()) return {rows, 0};
  // The last row may lack its line end.
  const std::uint64_t most = (reader.bytes_left() + 1) / smallest_row_bytes;
  if (rows > most) {
    reader.fail("a number of " + kind + " that the file can hold (at most " + std::to_string(most) + ")",
                std::to_string(count));
  }
  return {rows, rows};
}

template <std::size_t N>
void require_distinct(const WordReader& reader, const std::array<Index, N>& element, const Row& row) {
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = i + 1; j < N; ++j) {
      if (element[i] == element[j]) {
        reader.fail("different vertices in " + row.text(),
                    "vertex " + std::to_string(element[i] + 1) + " twice");
      }
    }
  }
}

/// Reads one section of elements with N vertices and a reference number each. Returns whether references
/// differ.
template <std::size_t N>
bool read_elements(WordReader& reader, const char* section, const char* kind, std::size_t vertices,
                   std::vector<std::array<Index, N>>& elements) {
  const Count count = read_count(reader, section, 2 * N + 2);
  if (count.rows > 0 && vertices == 0) {
    reader.fail(std::string("the section Vertices before ") + section, "none");
  }
  elements.reserve(elements.size() + count.reserve);
  std::int64_t first_reference = 0;
  bool references_differ = false;
  for (std::uint64_t i = 0; i < count.rows; ++i) {
    const Row row{kind, i + 1, count.rows};
    std::array<Index, N> element;
    for (Index& v : element) v = read_vertex_index(reader, row, vertices);
    const std::int64_t reference =
        read_integer(reader, [&] { return "the reference number of " + row.text(); });
    require_distinct(reader, element, row);
    if (i == 0) first_reference = reference;
    references_differ = references_differ || reference != first_reference;
    elements.push_back(element);
  }
  return references_differ;
}

void read_vertices(WordReader& reader, std::vector<Vec3>& points) {
  const Count count = read_count(reader, "vertices", 8);
  points.reserve(count.reserve);
  for (std::uint64_t i = 0; i < count.rows; ++i) {
    const Row row{"vertex", i + 1, count.rows};
    Vec3 point;
    point.x = read_coordinate(reader, row);
    point.y = read_coordinate(reader, row);
    point.z = read_coordinate(reader, row);
    read_integer(reader, [&] { return "the reference number of " + row.text(); });
    points.push_back(point);
  }
}

/// Numbers a row of the sections that carry no element, 0 if `keyword` is none of them.
std::size_t numbers_per_marker(std::string_view keyword) {
  struct Marker {
    std::string_view keyword;
    std::size_t numbers;
  };
  static constexpr std::array<Marker, 12> kMarkers{{{"Corners", 1},
                                                    {"RequiredVertices", 1},
                                                    {"Ridges", 1},
                                                    {"RequiredEdges", 1},
                                                    {"RequiredTriangles", 1},
                                                    {"Edges", 3},
                                                    {"Normals", 3},
                                                    {"Tangents", 3},
                                                    {"NormalAtVertices", 2},
                                                    {"TangentAtVertices", 2},
                                                    {"TangentAtEdges", 3},
                                                    {"NormalAtTriangleVertices", 3}}};
  for (const Marker& marker : kMarkers) {
    if (marker.keyword == keyword) return marker.numbers;
  }
  return 0;
}

void skip_markers(WordReader& reader, const std::string& keyword, std::size_t numbers) {
  const Count count = read_count(reader, keyword.c_str(), 2 * numbers);
  for (std::uint64_t i = 0; i < count.rows * numbers; ++i) {
    const std::string_view word = reader.next();
    double value = 0.0;
    if (parse(word, value) == std::errc::invalid_argument) {
      reader.fail("a number of " + Row{keyword.c_str(), i / numbers + 1, count.rows}.text(), shown(word));
    }
  }
}

bool is_other_element(std::string_view keyword) {
  static constexpr std::array<std::string_view, 6> kKinds{"Quadrilaterals", "Hexahedra", "Hexaedra",
                                                          "Prisms",         "Pyramids",  "Pentahedra"};
  const bool curved = keyword.find("P2") != std::string_view::npos ||
                      keyword.find("Q2") != std::string_view::npos ||
                      keyword.find("P3") != std::string_view::npos;
  return curved || std::find(kKinds.begin(), kKinds.end(), keyword) != kKinds.end();
}

void read_header(WordReader& reader) {
  const std::string_view word = reader.next();
  if (word == "MeshVersionUnformatted") reader.fail("an ASCII MEDIT mesh", "a binary one");
  if (word != "MeshVersionFormatted") reader.fail("MeshVersionFormatted (a MEDIT mesh)", shown(word));
  const std::int64_t version = read_integer(reader, [] { return "the MEDIT version"; });
  if (version < 1 || version > 4) reader.fail("a MEDIT version from 1 to 4", std::to_string(version));
}

/// What the sections of a file hold.
struct Sections {
  TetMesh mesh;
  std::uint64_t triangles = 0;
  bool references_differ = false;
};

void restore_orientation(const WordReader& reader, MeditFile& file) {
  std::size_t swapped = 0;
  for (std::size_t i = 0; i < file.mesh.tets.size(); ++i) {
    Tet& t = file.mesh.tets[i];
    const auto& p = file.mesh.points;
    const int sign = orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
    if (sign == 0) {
      throw InputError(reader.name(), 0, "tetrahedra with a volume",
                       "tetrahedron " + std::to_string(i + 1) + " that is flat (degenerate)");
    }
    if (sign < 0) {
      std::swap(t[2], t[3]);
      ++swapped;
    }
  }
  if (swapped > 0) {
    file.notes.push_back(std::to_string(swapped) + " of " + std::to_string(file.mesh.tets.size()) +
                         " tetrahedra were negatively oriented: positive orientation restored");
  }
}

void check_extent(const WordReader& reader, const TetMesh& mesh) {
  double largest = 0.0;
  for (const Vec3& p : mesh.points) {
    largest = std::max({largest, std::fabs(p.x - mesh.points[0].x), std::fabs(p.y - mesh.points[0].y),
                        std::fabs(p.z - mesh.points[0].z)});
  }
  if (largest < 1.0 / kLargestCoordinate) {
    throw InputError(reader.name(), 0, "vertices at least 1e-90 apart",
                     "an extent of " + short_number(largest));
  }
}

/// Reads one section. Returns whether it was one that we know.
bool read_section(WordReader& reader, const std::string& keyword, Sections& sections) {
  TetMesh& mesh = sections.mesh;
  if (keyword == "Dimension") {
    const std::int64_t dimension = read_integer(reader, [] { return "the dimension"; });
    if (dimension != 3) reader.fail("dimension 3", std::to_string(dimension));
  } else if (keyword == "Vertices") {
    if (!mesh.points.empty()) reader.fail("one section Vertices", "a second");
    read_vertices(reader, mesh.points);
  } else if (keyword == "Triangles") {
    std::vector<Triangle> triangles;
    read_elements<3>(reader, "triangles", "triangle", mesh.points.size(), triangles);
    sections.triangles += triangles.size();
  } else if (keyword == "Tetrahedra") {
    if (!mesh.tets.empty()) reader.fail("one section Tetrahedra", "a second");
    sections.references_differ =
        read_elements<4>(reader, "tetrahedra", "tetrahedron", mesh.points.size(), mesh.tets);
  } else if (const std::size_t numbers = numbers_per_marker(keyword); numbers > 0) {
    skip_markers(reader, keyword, numbers);
  } else {
    return false;
  }
  return true;
}

/// Reads the sections up to End.
Sections read_sections(WordReader& reader, std::vector<std::string>& notes) {
  Sections sections;
  std::string previous = "the header";
  while (true) {
    const std::string keyword(reader.next());
    if (keyword == "End") break;
    if (keyword.empty()) {
      notes.emplace_back("the file has no End");
      break;
    }
    if (is_other_element(keyword)) reader.fail("linear tetrahedra and triangles only", keyword);
    if (!read_section(reader, keyword, sections)) {
      reader.fail("a MEDIT keyword after " + previous, shown(keyword));
    }
    previous = keyword;
  }
  if (sections.references_differ) {
    notes.emplace_back("reference numbers of the tetrahedra differ: they are not kept");
  }
  return sections;
}

void flush_when_large(AtomicFile& file, std::string& text) {
  if (text.size() < (1U << 20U)) return;
  file.write(text);
  text.clear();
}

template <std::size_t N>
void write_elements(AtomicFile& file, std::string& text, const char* section,
                    const std::vector<std::array<Index, N>>& elements) {
  text += section;
  text += '\n';
  append_number(text, elements.size());
  text += '\n';
  for (const auto& element : elements) {
    for (const Index v : element) {
      append_number(text, std::uint64_t{v} + 1);
      text += ' ';
    }
    text += "0\n";
    flush_when_large(file, text);
  }
}

void require_writable(const TetMesh& mesh) {
  for (const Vec3& p : mesh.points) require(is_finite(p), "write_medit: a coordinate is not finite");
  for (const Tet& tet : mesh.tets) {
    for (const Index v : tet) require(v < mesh.points.size(), "write_medit: no such vertex");
  }
}

}  // namespace

MeditFile read_medit(const std::filesystem::path& path, ReadOrientation orientation) {
  WordReader reader(path);
  MeditFile file;
  read_header(reader);
  Sections sections = read_sections(reader, file.notes);
  file.mesh = std::move(sections.mesh);
  TetMesh& mesh = file.mesh;
  if (mesh.points.empty()) throw InputError(reader.name(), 0, "a section Vertices", "none");
  if (mesh.tets.empty()) {
    throw InputError(
        reader.name(), 0, "tetrahedra",
        sections.triangles > 0 ? "none, only " + std::to_string(sections.triangles) + " triangles" : "none");
  }
  if (orientation == ReadOrientation::kRestore) {
    const std::size_t isolated = remove_isolated_vertices(mesh);
    file.isolated_vertices = isolated;
    if (isolated > 0) {
      file.notes.push_back((isolated == 1
                                ? std::string("1 vertex that no tetrahedron uses was")
                                : std::to_string(isolated) + " vertices that no tetrahedron uses were") +
                           " left out");
    }
  }
  check_extent(reader, mesh);
  if (orientation == ReadOrientation::kRestore) restore_orientation(reader, file);
  return file;
}

void write_medit(const std::filesystem::path& path, const TetMesh& mesh) {
  require_writable(mesh);
  AtomicFile file(path);
  std::string text = "MeshVersionFormatted 2\nDimension 3\nVertices\n";
  append_number(text, mesh.points.size());
  text += '\n';
  for (const Vec3& p : mesh.points) {
    append_number(text, p.x);
    text += ' ';
    append_number(text, p.y);
    text += ' ';
    append_number(text, p.z);
    text += " 0\n";
    flush_when_large(file, text);
  }
  write_elements(file, text, "Triangles", build_unpaired_faces(mesh));
  write_elements(file, text, "Tetrahedra", mesh.tets);
  text += "End\n";
  file.write(text);
  file.commit();
}

}  // namespace palpate

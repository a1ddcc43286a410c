#include "core/mesh/medit.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <memory>
#include <string_view>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/mesh/orientation.h"
#include "core/mesh/topology.h"

namespace palpate {
namespace {

constexpr double kLargestCoordinate = 1e90;  // its cube and the products of the predicates stay finite

/// Reads white-space separated words with their line, through a fixed buffer.
class WordReader {
 public:
  explicit WordReader(const std::filesystem::path& path) : name_(path.string()) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) throw InputError(name_, 0, "a mesh file", "no such file");
    if (std::filesystem::is_directory(path, error)) throw InputError(name_, 0, "a mesh file", "a folder");
    file_.reset(std::fopen(path.c_str(), "rb"));
    if (!file_) throw InputError(name_, 0, "a readable file", "one that cannot be opened");
    size_ = std::filesystem::file_size(path, error);
    if (error) size_ = 0;
    buffer_.resize(kBufferSize);
    if (!fill()) throw InputError(name_, 0, "a MEDIT mesh", "an empty file");
  }

  /// The next word, empty at the end of the file; valid until the next call.
  std::string_view next() {
    skip_space();
    word_line_ = line_;
    if (at_ == end_) return {};
    std::size_t last = at_;
    while (true) {
      while (last < end_ && !is_space(buffer_[last])) ++last;
      if (last < end_ || !refill(last)) break;
    }
    if (last - at_ > kLongestWord) fail("text", "binary data");
    const std::string_view word(buffer_.data() + at_, last - at_);
    at_ = last;
    return word;
  }

  [[noreturn]] void fail(const std::string& expected, const std::string& found) const {
    throw InputError(name_, word_line_, expected, found);
  }

  std::size_t line() const { return word_line_; }
  std::uint64_t bytes_left() const { return size_ > consumed_ + at_ ? size_ - consumed_ - at_ : 0; }
  const std::string& name() const { return name_; }

 private:
  static constexpr std::size_t kBufferSize = 1U << 20U;
  static constexpr std::size_t kLongestWord = 256;

  static bool is_space(char c) {
    return c == ' ' || c == '\n' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
  }

  void skip_space() {
    bool in_comment = false;
    while (at_ < end_ || fill()) {
      const char c = buffer_[at_];
      if (c == '\0') {
        word_line_ = line_;
        fail("text", "binary data");
      }
      if (c == '\n') {
        ++line_;
        in_comment = false;
      } else if (c == '#') {
        in_comment = true;
      } else if (!in_comment && !is_space(c)) {
        return;
      }
      ++at_;
    }
  }

  bool fill() {
    consumed_ += end_;
    at_ = 0;
    end_ = std::fread(buffer_.data(), 1, buffer_.size(), file_.get());
    return end_ > 0;
  }

  /// Moves the word that ends at the buffer's end to its front and reads on behind it.
  bool refill(std::size_t& last) {
    const std::size_t kept = end_ - at_;
    if (kept > kLongestWord) return false;
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(at_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
    consumed_ += at_;
    at_ = 0;
    const std::size_t got = std::fread(buffer_.data() + kept, 1, buffer_.size() - kept, file_.get());
    end_ = kept + got;
    last = kept;
    return got > 0;
  }

  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::string name_;
  std::unique_ptr<std::FILE, Closer> file_;
  std::vector<char> buffer_;
  std::size_t at_ = 0;
  std::size_t end_ = 0;
  std::uint64_t consumed_ = 0;
  std::uint64_t size_ = 0;
  std::size_t line_ = 1;
  std::size_t word_line_ = 1;
};

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

double read_coordinate(WordReader& reader, const Row& row) {
  std::string_view word = reader.next();
  const std::string_view whole = word;
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (whole.empty() || error == std::errc::invalid_argument || end != word.data() + word.size()) {
    reader.fail("a coordinate of " + row.text(), shown(whole));
  }
  // An exponent beyond the range of doubles: too small is zero, too large is refused below as written.
  if (error == std::errc::result_out_of_range || !std::isfinite(value) ||
      std::fabs(value) > kLargestCoordinate) {
    reader.fail("a finite coordinate of " + row.text() + " within +-1e90", shown(whole));
  }
  return value;
}

std::int64_t read_integer(WordReader& reader, const std::string& what) {
  const std::string_view word = reader.next();
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || error != std::errc() || end != word.data() + word.size())
    reader.fail(what, shown(word));
  return value;
}

Index read_vertex_index(WordReader& reader, const Row& row, std::size_t vertices) {
  const std::string_view word = reader.next();
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || error != std::errc() || end != word.data() + word.size() || value < 1 ||
      value > static_cast<std::int64_t>(vertices)) {
    reader.fail("a vertex number from 1 to " + std::to_string(vertices) + " in " + row.text(), shown(word));
  }
  return static_cast<Index>(value - 1);
}

/// Reads a count and holds it against the bytes that are left, so that a lying file costs no memory.
std::uint64_t read_count(WordReader& reader, const char* section, std::uint64_t smallest_row_bytes) {
  const std::int64_t count = read_integer(reader, std::string("the number of ") + section);
  const std::uint64_t most = reader.bytes_left() / smallest_row_bytes + 1;
  if (count < 0 || static_cast<std::uint64_t>(count) > most) {
    reader.fail(std::string("a number of ") + section + " that the file can hold (at most " +
                    std::to_string(most) + ")",
                std::to_string(count));
  }
  if (count >= (std::int64_t{1} << 30)) {
    reader.fail(std::string("fewer than 2^30 ") + section, std::to_string(count));
  }
  return static_cast<std::uint64_t>(count);
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
template <std::size_t N, typename Take>
bool read_elements(WordReader& reader, const char* section, const char* kind, std::size_t vertices,
                   Take&& take) {
  const std::uint64_t count = read_count(reader, section, 2 * N + 2);
  std::int64_t first_reference = 0;
  bool references_differ = false;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Row row{kind, i + 1, count};
    std::array<Index, N> element;
    for (Index& v : element) v = read_vertex_index(reader, row, vertices);
    const std::int64_t reference = read_integer(reader, "the reference number of " + row.text());
    require_distinct(reader, element, row);
    if (i == 0) first_reference = reference;
    references_differ = references_differ || reference != first_reference;
    take(element, count);
  }
  return references_differ;
}

void read_vertices(WordReader& reader, std::vector<Vec3>& points) {
  const std::uint64_t count = read_count(reader, "vertices", 8);
  points.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    const Row row{"vertex", i + 1, count};
    const double x = read_coordinate(reader, row);
    const double y = read_coordinate(reader, row);
    const double z = read_coordinate(reader, row);
    const std::string_view reference = reader.next();
    if (reference.empty()) reader.fail("the reference number of " + row.text(), shown(reference));
    points.push_back({x, y, z});
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
  const std::uint64_t count = read_count(reader, keyword.c_str(), 2 * numbers);
  for (std::uint64_t i = 0; i < count * numbers; ++i) {
    if (reader.next().empty()) reader.fail("a number of " + keyword, "the end of the file");
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
  const std::int64_t version = read_integer(reader, "the MEDIT version");
  if (version < 1 || version > 4) reader.fail("a MEDIT version from 1 to 4", std::to_string(version));
}

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
                     "an extent of " + std::to_string(largest));
  }
}

/// Reads the sections up to End. Returns the number of triangles.
std::uint64_t read_sections(WordReader& reader, MeditFile& file) {
  TetMesh& mesh = file.mesh;
  std::uint64_t triangles = 0;
  bool references_differ = false;
  bool ended = false;
  std::string previous = "the header";
  while (!ended) {
    const std::string keyword(reader.next());
    if (keyword.empty()) {
      file.notes.emplace_back("the file has no End");
      break;
    }
    if (keyword == "Dimension") {
      const std::int64_t dimension = read_integer(reader, "the dimension");
      if (dimension != 3) reader.fail("dimension 3", std::to_string(dimension));
    } else if (keyword == "Vertices") {
      if (!mesh.points.empty()) reader.fail("one section Vertices", "a second");
      read_vertices(reader, mesh.points);
    } else if (keyword == "Triangles") {
      read_elements<3>(reader, "triangles", "triangle", mesh.points.size(),
                       [&](const Triangle&, std::uint64_t) { ++triangles; });
    } else if (keyword == "Tetrahedra") {
      if (!mesh.tets.empty()) reader.fail("one section Tetrahedra", "a second");
      references_differ = read_elements<4>(reader, "tetrahedra", "tetrahedron", mesh.points.size(),
                                           [&](const Tet& tet, std::uint64_t count) {
                                             if (mesh.tets.empty()) mesh.tets.reserve(count);
                                             mesh.tets.push_back(tet);
                                           });
    } else if (const std::size_t numbers = numbers_per_marker(keyword); numbers > 0) {
      skip_markers(reader, keyword, numbers);
    } else if (keyword == "End") {
      ended = true;
    } else if (is_other_element(keyword)) {
      reader.fail("linear tetrahedra and triangles only", keyword);
    } else {
      reader.fail("a MEDIT keyword after " + previous, shown(keyword));
    }
    previous = keyword;
  }
  if (references_differ)
    file.notes.emplace_back("reference numbers of the tetrahedra differ: they are not kept");
  return triangles;
}

void append_number(std::string& text, double value) {
  std::array<char, 32> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), end);
}

void append_number(std::string& text, std::uint64_t value) {
  std::array<char, 24> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), end);
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

}  // namespace

MeditFile read_medit(const std::filesystem::path& path, ReadOrientation orientation) {
  WordReader reader(path);
  MeditFile file;
  read_header(reader);
  const std::uint64_t triangles = read_sections(reader, file);
  TetMesh& mesh = file.mesh;
  if (mesh.points.empty()) throw InputError(reader.name(), 0, "a section Vertices", "none");
  if (mesh.tets.empty()) {
    throw InputError(reader.name(), 0, "tetrahedra",
                     triangles > 0 ? "none, only " + std::to_string(triangles) + " triangles" : "none");
  }
  check_extent(reader, mesh);
  if (orientation == ReadOrientation::kRestore) {
    const std::size_t isolated = remove_isolated_vertices(mesh);
    if (isolated > 0) {
      file.notes.push_back(std::to_string(isolated) + " vertices that no tetrahedron uses were left out");
    }
    restore_orientation(reader, file);
  }
  return file;
}

void write_medit(const std::filesystem::path& path, const TetMesh& mesh) {
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
  write_elements(file, text, "Triangles", build_boundary(mesh));
  write_elements(file, text, "Tetrahedra", mesh.tets);
  text += "End\n";
  file.write(text);
  file.commit();
}

}  // namespace palpate

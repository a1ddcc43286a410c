// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "reference/cgal/surface_tools.h"

namespace palpate::reference {
namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;
using Polygons = std::vector<std::vector<std::size_t>>;

constexpr std::size_t kStlHeader = 80;
constexpr std::size_t kStlTriangle = 50;

/// A binary STL file must be as long as its count says; an ASCII one must be ended by endsolid.
void check_stl_is_whole(const std::string& where) {
  std::ifstream file(where, std::ios::binary);
  std::string head(kStlHeader + 4, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  const auto got = static_cast<std::size_t>(file.gcount());
  const std::uintmax_t size = std::filesystem::file_size(where);
  std::uint32_t count = 0;
  if (got == head.size()) {
    std::memcpy(&count, head.data() + kStlHeader, sizeof count);
    if (size == kStlHeader + 4 + std::uintmax_t{count} * kStlTriangle) return;
  }
  const std::size_t first = head.find_first_not_of(" \t\r\n");
  if (first == std::string::npos || head.compare(first, 5, "solid") != 0 || head.find('\0') < got) {
    if (got < head.size())
      throw InputError(where, 0, "an STL file", "a broken file of " + std::to_string(size) + " bytes");
    throw InputError(where, 0, std::to_string(count) + " triangles, as the STL header says",
                     "a file of " + std::to_string(size) + " bytes");
  }
  constexpr std::streamoff kTail = 4096;
  file.clear();
  file.seekg(size > static_cast<std::uintmax_t>(kTail) ? static_cast<std::streamoff>(size) - kTail : 0);
  const std::string tail{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (tail.find("endsolid") == std::string::npos) {
    throw InputError(where, 0, "endsolid at the end", "a truncated file");
  }
}

std::size_t count_words(const std::string& line) {
  std::istringstream words(line.substr(0, line.find('#')));
  return static_cast<std::size_t>(
      std::distance(std::istream_iterator<std::string>(words), std::istream_iterator<std::string>()));
}

/// The rows of an OFF file that have words, as they are needed here.
class OffRows {
 public:
  explicit OffRows(const std::string& where) : where_(where), size_(std::filesystem::file_size(where)) {}

  /// Takes the next line. Returns false if nothing more is to be looked at.
  /// Throws: InputError for what CGAL 5.5 takes wrongly.
  bool take(const std::string& line) {
    ++number_;
    const std::string text = line.substr(0, line.find('#'));
    if (number_ == 1 && text.find("BINARY") != std::string::npos) return false;  // 32 bits a count
    if (count_words(text) == 0) return true;
    const std::size_t keyword = rows_ == 0 && !has_header_ ? text.find("OFF") : std::string::npos;
    if (keyword != std::string::npos) {
      has_header_ = true;
      read_kind(text, keyword);
      if (count_words(text.substr(keyword + 3)) > 0) take_row(text.substr(keyword + 3));
    } else {
      take_row(text);
    }
    return true;
  }

  /// Throws: InputError if the header claims more rows than there are.
  void check_end() const {
    if (rows_ > 0 && static_cast<double>(rows_ - 1) < vertices_ + faces_)
      throw InputError(
          where_, 0,
          short_number(vertices_) + " vertices and " + short_number(faces_) + " faces, as the header says",
          std::to_string(rows_ - 1) + " rows");
  }

 private:
  /// "C" in front of OFF: each row has to have all of its colour, for CGAL 5.5 reads three numbers wherever
  /// there is room for one, be they there or not.
  void read_kind(const std::string& text, std::size_t keyword) {
    std::istringstream(text.substr(0, keyword)) >> kind_;
    is_colored_ = kind_.find('C') != std::string::npos;
    if (is_colored_ && ((kind_ != "C" && kind_ != "CN") || count_words(text) > 1))
      throw InputError(where_, number_, "OFF, NOFF, COFF or CNOFF alone", text);
  }

  void take_row(const std::string& text) {
    std::istringstream words(text);
    double first = 0.0;
    const bool is_number = static_cast<bool>(words >> first);
    if (rows_ == 0) {
      words >> faces_;
      check(first, "vertices", text);
      check(faces_, "faces", text);
      vertices_ = first;
    } else {
      const bool is_face = static_cast<double>(rows_) > vertices_;
      if (is_face && is_number) check(first, "corners of a face", text);
      if (is_colored_) check_color(count_words(text), is_face, first);
    }
    ++rows_;
  }

  /// Three or four numbers behind the row's own; a face may go without.
  void check_color(std::size_t words, bool is_face, double corners) const {
    const std::size_t plain = kind_ == "CN" ? 6 : 3;
    const std::size_t own = is_face ? static_cast<std::size_t>(std::max(0.0, corners)) + 1 : plain;
    if (words == own + 3 || words == own + 4 || (is_face && words == own)) return;
    throw InputError(where_, number_, "a colour of 3 or 4 numbers", "another row");
  }

  /// CGAL 5.5 makes room for as many vertices, faces and corners as are claimed, before it reads them: none
  /// of them takes less than a byte.
  void check(double claimed, const char* what, const std::string& text) const {
    if (claimed > static_cast<double>(size_))
      throw InputError(where_, number_,
                       std::string(what) + " that " + std::to_string(size_) + " bytes can hold", text);
  }

  std::string where_;
  std::uintmax_t size_ = 0;
  std::size_t number_ = 0;
  std::size_t rows_ = 0;  ///< the counts and those behind them
  bool has_header_ = false;
  std::string kind_;
  bool is_colored_ = false;
  double vertices_ = 0.0;
  double faces_ = 0.0;
};

/// `is_broken`: CGAL could not read it. Then a row too few is what is said, and nothing where that is not it.
void check_off(const std::string& where, bool is_broken) {
  std::ifstream file(where, std::ios::binary);
  OffRows rows(where);
  std::string line;
  while (std::getline(file, line)) {
    if (!rows.take(line)) return;
  }
  if (is_broken) rows.check_end();
}

/// An element takes a byte at least: CGAL 5.5 goes through all that are claimed, be they there or not.
/// Returns: the count.
double check_ply_count(const std::string& where, std::size_t number, const std::string& line) {
  std::istringstream words(line);
  std::string word;
  std::string name;
  double count = 0.0;
  const bool is_whole = static_cast<bool>(words >> word >> name >> count);
  const std::uintmax_t size = std::filesystem::file_size(where);
  if (!is_whole || count < 0.0 || count > static_cast<double>(size))
    throw InputError(where, number,
                     "an element of at most " + std::to_string(size) + ", as the file has bytes", line);
  return count;
}

/// CGAL 5.5 takes the last element of a PLY header for the owner of a property, be there one or not.
/// `is_broken`: what it read makes no sense. Then it is said if there are fewer rows than elements; that
/// holds for text alone.
void check_ply(const std::string& where, bool is_broken) {
  std::ifstream file(where, std::ios::binary);
  std::string line;
  bool has_element = false;
  bool is_text = false;
  double elements = 0.0;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    std::string word;
    std::string second;
    std::istringstream(line) >> word >> second;
    if (word == "end_header") break;  // the whole word: what only begins so ends nothing for CGAL
    has_element = has_element || word == "element";
    is_text = is_text || (word == "format" && second == "ascii");
    if (word == "element") elements += check_ply_count(where, number, line);
    if (word == "property" && !has_element)
      throw InputError(where, number, "an element before its properties", "none");
  }
  if (!is_broken || !is_text) return;
  std::size_t rows = 0;
  while (std::getline(file, line)) rows += count_words(line) > 0 ? 1 : 0;
  if (static_cast<double>(rows) < elements)
    throw InputError(where, 0, short_number(elements) + " elements, as the header says",
                     std::to_string(rows) + " rows");
}

/// What CGAL takes wrongly, before it reads; and, once it `is_broken`, whether the header claims too much.
void check_claims(const std::filesystem::path& path, bool is_broken) {
  if (path.extension() == ".off") check_off(path.string(), is_broken);
  if (path.extension() == ".ply") check_ply(path.string(), is_broken);
}

bool read_soup(const std::string& where, std::vector<Point>& points, Polygons& polygons) {
  try {
    return CGAL::IO::read_polygon_soup(where, points, polygons);
  } catch (const std::exception&) {  // counts that the file claims and memory cannot hold
    return false;
  }
}

}  // namespace

SurfaceMesh read_surface(const std::filesystem::path& path) {
  const std::string where = path.string();
  if (!std::filesystem::is_regular_file(path)) throw InputError(where, 0, "a readable file", "none");
  if (std::filesystem::file_size(path) == 0) throw InputError(where, 0, "a surface", "an empty file");
  if (path.extension() == ".stl") check_stl_is_whole(where);
  check_claims(path, false);
  std::vector<Point> points;
  Polygons polygons;
  if (!read_soup(where, points, polygons)) {
    check_claims(path, true);
    throw InputError(where, 0, "a whole " + path.extension().string() + " file", "a broken or truncated one");
  }
  if (polygons.empty()) throw InputError(where, 0, "triangles", "none");
  SurfaceMesh surface;
  std::map<std::tuple<double, double, double>, Index> known;
  for (const auto& polygon : polygons) {
    if (polygon.size() != 3) {
      check_claims(path, true);
      throw InputError(where, 0, "triangles only",
                       "a polygon of " + std::to_string(polygon.size()) + " corners");
    }
    Triangle triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (polygon[k] >= points.size()) {
        throw InputError(where, 0, "vertices of the file", "vertex " + std::to_string(polygon[k]));
      }
      const Point& p = points[polygon[k]];
      const Vec3 v{p.x(), p.y(), p.z()};
      if (!is_finite(v)) throw InputError(where, 0, "finite coordinates", "NaN or infinity");
      const auto [entry, is_new] =
          known.try_emplace({v.x, v.y, v.z}, static_cast<Index>(surface.points.size()));
      if (is_new) surface.points.push_back(v);
      triangle[k] = entry->second;
    }
    surface.triangles.push_back(triangle);
  }
  return surface;
}

}  // namespace palpate::reference

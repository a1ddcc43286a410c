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

/// CGAL 5.5 reads three numbers of a colour wherever a coloured OFF file (COFF) has room for one, be they
/// there or not. So each row has to have all of them: red, green, blue and perhaps an opacity.
void check_off_colors(const std::string& where) {
  std::ifstream file(where, std::ios::binary);
  std::string line;
  std::size_t number = 0;
  const auto next = [&] {
    while (std::getline(file, line)) {
      ++number;
      if (count_words(line) > 0) return true;
    }
    return false;
  };
  if (!next() || line.find("OFF") == std::string::npos) return;
  const std::string kind = line.substr(0, line.find("OFF"));
  if (kind.find('C') == std::string::npos || line.find("BINARY") != std::string::npos) return;
  const bool is_known = kind == "C" || kind == "CN";
  if (!is_known || count_words(line) > 1)
    throw InputError(where, number, "OFF, NOFF, COFF or CNOFF alone", line);
  if (!next()) return;
  std::size_t vertices = 0;
  std::istringstream(line) >> vertices;
  const std::size_t plain = kind == "CN" ? 6 : 3;
  for (std::size_t i = 0; next(); ++i) {
    std::size_t corners = 0;
    if (i >= vertices) std::istringstream(line) >> corners;
    const std::size_t rest = i < vertices ? plain : std::min<std::size_t>(corners, line.size()) + 1;
    const std::size_t words = count_words(line);
    const bool is_whole = words == rest + 3 || words == rest + 4 || (i >= vertices && words == rest);
    if (!is_whole) throw InputError(where, number, "a colour of 3 or 4 numbers", "another row");
  }
}

/// CGAL 5.5 makes room for as many vertices, faces and corners as an OFF file claims, before it reads them:
/// none of them takes less than a byte.
void check_off_counts(const std::string& where) {
  const std::uintmax_t size = std::filesystem::file_size(where);
  std::ifstream file(where, std::ios::binary);
  std::string line;
  std::size_t number = 0;
  std::size_t rows = 0;  // with words, behind the header's
  std::size_t vertices = 0;
  const auto check = [&](double claimed, const char* what) {
    if (claimed > static_cast<double>(size))
      throw InputError(where, number, std::string(what) + " that " + std::to_string(size) + " bytes can hold",
                       line);
  };
  while (std::getline(file, line)) {
    ++number;
    const std::string text = line.substr(0, line.find('#'));
    if (number == 1 && text.find("BINARY") != std::string::npos) return;  // CGAL reads its counts as 32 bits
    const bool is_header = rows == 0 && text.find("OFF") != std::string::npos;
    std::istringstream words(is_header ? text.substr(text.find("OFF") + 3) : text);
    double first = 0.0;
    if (!(words >> first)) continue;
    if (rows == 0) {
      double faces = 0.0;
      words >> faces;
      check(first, "vertices");
      check(faces, "faces");
      vertices = first > 0.0 ? static_cast<std::size_t>(first) : 0;
    } else if (rows > vertices) {
      check(first, "corners of a face");
    }
    ++rows;
  }
}

/// An element takes a byte at least: CGAL 5.5 goes through all that are claimed, be they there or not.
void check_ply_count(const std::string& where, std::size_t number, const std::string& line) {
  std::istringstream words(line);
  std::string word;
  std::string name;
  double count = 0.0;
  const bool is_whole = static_cast<bool>(words >> word >> name >> count);
  const std::uintmax_t size = std::filesystem::file_size(where);
  if (!is_whole || count < 0.0 || count > static_cast<double>(size))
    throw InputError(where, number,
                     "an element of at most " + std::to_string(size) + ", as the file has bytes", line);
}

/// CGAL 5.5 takes the last element of a PLY header for the owner of a property, be there one or not.
void check_ply_header(const std::string& where) {
  std::ifstream file(where, std::ios::binary);
  std::string line;
  bool has_element = false;
  for (std::size_t number = 1; std::getline(file, line) && line.rfind("end_header", 0) != 0; ++number) {
    std::string word;
    std::istringstream(line) >> word;
    has_element = has_element || word == "element";
    if (word == "element") check_ply_count(where, number, line);
    if (word == "property" && !has_element)
      throw InputError(where, number, "an element before its properties", "none");
  }
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
  if (path.extension() == ".off") check_off_counts(where);
  if (path.extension() == ".off") check_off_colors(where);
  if (path.extension() == ".ply") check_ply_header(where);
  std::vector<Point> points;
  Polygons polygons;
  if (!read_soup(where, points, polygons)) {
    throw InputError(where, 0, "a whole " + path.extension().string() + " file", "a broken or truncated one");
  }
  if (polygons.empty()) throw InputError(where, 0, "triangles", "none");
  SurfaceMesh surface;
  std::map<std::tuple<double, double, double>, Index> known;
  for (const auto& polygon : polygons) {
    if (polygon.size() != 3) {
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

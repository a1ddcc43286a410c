// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Simple_cartesian.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "reference/cgal/file_claims.h"
#include "reference/cgal/surface_tools.h"

namespace palpate::reference {
namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;
using Polygons = std::vector<std::vector<std::size_t>>;

constexpr double kMostCoordinate = 1e90;  // whose volumes are finite
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

void refuse_byte_order_mark(const std::string& where) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  std::ifstream file(where, std::ios::binary);
  std::string head(kMark.size(), '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (head == kMark)
    throw InputError(where, 1, "a file without a byte-order mark", "one in front of its text");
}

/// What CGAL 5.5 takes as it is claimed is looked at before. The ending is the one that CGAL goes by.
OffExtras check_whole(const std::string& where) {
  const std::string ending = CGAL::IO::internal::get_file_extension(where);
  if (ending == "stl") check_stl_is_whole(where);
  if (ending != "stl") refuse_byte_order_mark(where);
  if (ending == "ply") check_ply_file(where);
  return ending == "off" ? check_off_file(where) : OffExtras{};
}

/// Throws: InputError with the line of the first corner of an OBJ file that is none of its vertices. They
/// count from 1, or from -1 backwards from those above.
void refuse_obj_corners(const std::string& where) {
  const auto walk = [&](const auto& look) {
    std::ifstream file(where);
    std::size_t line = 0;
    for (std::string row; std::getline(file, row);) {
      std::istringstream words(row);
      std::string word;
      words >> word;
      look(++line, word, words);
    }
  };
  std::int64_t vertices = 0;
  walk([&](std::size_t, const std::string& kind, std::istringstream&) { vertices += kind == "v" ? 1 : 0; });
  std::int64_t above = 0;
  walk([&](std::size_t line, const std::string& kind, std::istringstream& words) {
    above += kind == "v" ? 1 : 0;
    if (kind != "f") return;
    for (std::string word; words >> word;) {
      std::int64_t corner = 0;
      const bool is_whole = std::from_chars(word.data(), word.data() + word.size(), corner).ec == std::errc();
      if (is_whole && corner != 0 && corner <= vertices && corner >= -above) continue;
      throw InputError(where, line, "vertices 1 to " + std::to_string(vertices),
                       "\"" + shown_piece(word) + "\"");
    }
  });
}

bool read_soup(const std::string& where, const OffExtras& extras, std::vector<Point>& points,
               Polygons& polygons) {
  try {
    if (extras.length == 0) return CGAL::IO::read_polygon_soup(where, points, polygons);
    std::ifstream file(where, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    text.erase(extras.at, extras.length);
    std::istringstream plain(std::move(text));
    return CGAL::IO::read_OFF(plain, points, polygons);
  } catch (const std::exception&) {  // of CGAL's own checks, or out of memory
    return false;
  }
}

}  // namespace

SurfaceMesh read_surface(const std::filesystem::path& path) {
  const std::string where = path.string();
  if (!std::filesystem::is_regular_file(path)) throw InputError(where, 0, "a readable file", "none");
  if (std::filesystem::file_size(path) == 0) throw InputError(where, 0, "a surface", "an empty file");
  const OffExtras extras = check_whole(where);
  const bool is_obj = CGAL::IO::internal::get_file_extension(where) == "obj";
  std::vector<Point> points;
  Polygons polygons;
  if (!read_soup(where, extras, points, polygons)) {
    if (is_obj) refuse_obj_corners(where);
    throw InputError(where, 0, "a whole " + path.extension().string() + " file",
                     "one that is broken, truncated or has a number that is none");
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
        if (is_obj) refuse_obj_corners(where);
        throw InputError(where, 0, "vertices 0 to " + std::to_string(points.size() - 1),
                         "vertex " + std::to_string(static_cast<std::int64_t>(polygon[k])));
      }
      const Point& p = points[polygon[k]];
      const Vec3 v{p.x(), p.y(), p.z()};
      if (!is_finite(v)) throw InputError(where, 0, "finite coordinates", "NaN or infinity");
      for (const double x : {v.x, v.y, v.z}) {
        if (std::fabs(x) > kMostCoordinate)
          throw InputError(where, 0, "coordinates of at most " + short_number(kMostCoordinate),
                           short_number(x));
      }
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

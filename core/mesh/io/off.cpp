#include "core/mesh/io/off.h"

#include <charconv>
#include <cstdint>
#include <fstream>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/plain_file.h"

namespace palpate {
namespace {

/// Reads white-space separated words and names the file in each complaint.
class OffReader {
 public:
  explicit OffReader(const std::filesystem::path& path) : name_(path.string()) {
    refuse_no_file(path, "a readable OFF file");
    file_.open(path);
    if (!file_) throw InputError(name_, 0, "a readable OFF file", "none");
  }

  std::string word(const char* expected) {
    std::string text;
    if (!(file_ >> text)) throw InputError(name_, 0, expected, "the end of the file");
    return text;
  }

  template <typename Number>
  Number number(const char* expected) {
    const std::string text = word(expected);
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) {
      throw InputError(name_, 0, expected, "\"" + text.substr(0, 40) + "\"");
    }
    return value;
  }

  const std::string& name() const { return name_; }

 private:
  std::string name_;
  std::ifstream file_;
};

}  // namespace

SurfaceMesh read_off(const std::filesystem::path& path) {
  OffReader reader(path);
  if (reader.word("the word OFF") != "OFF") {
    throw InputError(reader.name(), 0, "the word OFF", "something else");
  }
  const auto point_count = reader.number<std::uint32_t>("a number of vertices");
  const auto triangle_count = reader.number<std::uint32_t>("a number of triangles");
  reader.number<std::uint32_t>("a number of edges");
  SurfaceMesh surface;
  for (std::uint32_t i = 0; i < point_count; ++i) {
    Vec3 p;
    for (double* c : {&p.x, &p.y, &p.z}) *c = reader.number<double>("a coordinate");
    if (!is_finite(p)) throw InputError(reader.name(), 0, "finite coordinates", "NaN or infinity");
    surface.points.push_back(p);
  }
  for (std::uint32_t i = 0; i < triangle_count; ++i) {
    const auto corners = reader.number<std::uint32_t>("a triangle");
    if (corners != 3) throw InputError(reader.name(), 0, "triangles", std::to_string(corners) + " corners");
    Triangle triangle{};
    for (Index& v : triangle) {
      v = reader.number<Index>("a vertex of a triangle");
      if (v >= point_count) throw InputError(reader.name(), 0, "a vertex of the file", std::to_string(v));
    }
    surface.triangles.push_back(triangle);
  }
  return surface;
}

void write_off(const std::filesystem::path& path, const SurfaceMesh& surface) {
  AtomicFile file(path);
  std::string text = "OFF\n" + std::to_string(surface.points.size()) + " " +
                     std::to_string(surface.triangles.size()) + " 0\n";
  for (const Vec3& p : surface.points) {
    append_number(text, p.x);
    text += ' ';
    append_number(text, p.y);
    text += ' ';
    append_number(text, p.z);
    text += '\n';
  }
  for (const Triangle& t : surface.triangles) {
    text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
  }
  file.write(text);
  file.commit();
}

}  // namespace palpate

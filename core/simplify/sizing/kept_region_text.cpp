#include "core/simplify/sizing/kept_region_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "core/base/error.h"

namespace palpate::simplify {
namespace {

struct Form {
  KeptRegion::Kind kind;
  const char* text;
  std::size_t numbers;
};

constexpr std::array<Form, 3> kForms{{{KeptRegion::Kind::kSphere, "sphere x y z r", 4},
                                      {KeptRegion::Kind::kHalfSpace, "half_space nx ny nz offset", 4},
                                      {KeptRegion::Kind::kSurfacePatch, "patch x y z r depth", 5}}};

double parse_number(const std::string& word, const Form& form, const std::string& where) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    throw InputError(where, 0, std::string("a finite number in \"") + form.text + "\"", "\"" + word + "\"");
  return value;
}

void check_positive(double value, const char* what, const std::string& where) {
  if (!(value > 0.0)) throw InputError(where, 0, std::string(what) + " above 0", std::to_string(value));
}

}  // namespace

const std::vector<std::string>& kept_region_kinds() {
  static const std::vector<std::string> kinds{"sphere", "half_space", "patch"};
  return kinds;
}

KeptRegion parse_kept_region(const std::string& text, const std::string& where) {
  std::istringstream words(text);
  std::string word;
  words >> word;
  std::size_t n = 0;
  while (n < kForms.size() && word != kept_region_kinds()[n]) ++n;
  if (n == kForms.size())
    throw InputError(where, 0, "a region that starts with sphere, half_space or patch", "\"" + word + "\"");
  const Form& form = kForms[n];
  std::vector<double> numbers;
  while (words >> word) numbers.push_back(parse_number(word, form, where));
  if (numbers.size() != form.numbers) {
    throw InputError(where, 0, std::string("\"") + form.text + "\"",
                     std::to_string(numbers.size()) + " numbers after " + kept_region_kinds()[n]);
  }
  const Vec3 first{numbers[0], numbers[1], numbers[2]};
  KeptRegion region{.kind = form.kind};
  if (form.kind == KeptRegion::Kind::kHalfSpace) {
    check_positive(length(first), "a normal of a length", where);
    region.normal = first;
    region.offset = numbers[3];
    return region;
  }
  region.center = first;
  region.radius = numbers[3];
  check_positive(region.radius, "a radius", where);
  if (form.kind != KeptRegion::Kind::kSurfacePatch) return region;
  region.depth = numbers[4];
  if (region.depth < 0.0) throw InputError(where, 0, "a depth of at least 0", std::to_string(region.depth));
  return region;
}

}  // namespace palpate::simplify

#include "core/springs/identification/identify_options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "core/base/error.h"
#include "core/base/number_text.h"

namespace palpate::springs {
namespace {

std::vector<SpringMethod> all_methods() {
  std::vector<SpringMethod> methods;
  for (const std::string& name : spring_method_names()) methods.push_back(parse_spring_method(name));
  return methods;
}

std::string text_of(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

void check_positive(double value, const std::string& what) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw InputError(what, 0, "a finite number above 0", text_of(value));
}

std::string quoted(std::string_view text) {
  return "\"" + std::string(text) + "\"";
}

bool parse_flag(std::string_view text, const std::string& where) {
  if (text == "true") return true;
  if (text == "false") return false;
  throw InputError(where, 0, "true or false", quoted(text));
}

double parse_number(std::string_view text, const std::string& where) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw InputError(where, 0, "a finite number", quoted(text));
  return value;
}

bool takes(const SpringOption& option, SpringMethod method) {
  return std::find(option.methods.begin(), option.methods.end(), method) != option.methods.end();
}

}  // namespace

const std::vector<std::string>& spring_method_names() {
  static const std::vector<std::string> names{"uniform",          "van_gelder",    "lloyd",
                                              "maciel",           "stiffness_fit", "thesis_printed",
                                              "thesis_corrected", "isotropy",      "isotropy_patch"};
  return names;
}

const char* spring_method_name(SpringMethod method) {
  return spring_method_names().at(static_cast<std::size_t>(method)).c_str();
}

SpringMethod parse_spring_method(std::string_view name) {
  const std::vector<std::string>& names = spring_method_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    std::string known;
    for (const std::string& other : names) known += (known.empty() ? "" : ", ") + other;
    throw InputError("spring method", 0, "one of " + known, "\"" + std::string(name) + "\"");
  }
  return static_cast<SpringMethod>(found - names.begin());
}

void check_material(const Material& material, const std::string& prefix) {
  check_positive(material.young_modulus_pa, prefix + "young_modulus_pa");
  const double nu = material.poisson_ratio;
  if (!(nu > -1.0 && nu < 0.5))
    throw InputError(prefix + "poisson_ratio", 0, "a number above -1 and below 0.5", text_of(nu));
  if (!(material.density_kg_m3 >= 0.0) || !std::isfinite(material.density_kg_m3)) {
    throw InputError(prefix + "density_kg_m3", 0, "a finite number of at least 0",
                     text_of(material.density_kg_m3));
  }
}

void check_options(const IdentifyOptions& options) {
  if (options.uniform_stiffness_n_per_m) check_positive(*options.uniform_stiffness_n_per_m, "stiffness");
  check_positive(options.stiffness_row_weight, "row_weight");
  check_positive(options.patch_length, "patch_length");
  check_positive(options.tolerance, "tolerance");
}

std::span<const SpringOption> spring_options() {
  static const std::array<SpringOption, 5> options{{
      {"face_opposite", "true: also a spring between the two apexes of each interior face", "false",
       all_methods()},
      {"stiffness_n_per_m",
       "of every spring, above 0",
       "the best fit to sum k U^2 = 6 E V",
       {SpringMethod::kUniform}},
      {"row_weight",
       "of the stiffness row, above 0",
       "1",
       {SpringMethod::kThesisPrinted, SpringMethod::kThesisCorrected}},
      {"rows",
       "how appendix B is read: letter, b4_sign or substituted",
       "letter",
       {SpringMethod::kThesisPrinted}},
      {"patch_length",
       "weight of the patch rows in mean rest lengths, above 0",
       "1",
       {SpringMethod::kIsotropyPatch}},
  }};
  return options;
}

std::vector<std::string> spring_option_names(SpringMethod method) {
  std::vector<std::string> names;
  for (const SpringOption& option : spring_options()) {
    if (takes(option, method)) names.push_back(option.name);
  }
  return names;
}

ThesisRows parse_thesis_rows(std::string_view text, const std::string& where) {
  if (text == "letter") return ThesisRows::kPrinted;
  if (text == "b4_sign") return ThesisRows::kB4Sign;
  if (text == "substituted") return ThesisRows::kSubstituted;
  throw InputError(where, 0, "letter, b4_sign or substituted", quoted(text));
}

void set_spring_option(SpringMethod method, std::string_view name, std::string_view text,
                       const std::string& where, IdentifyOptions& options) {
  const std::vector<std::string> names = spring_option_names(method);
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    std::string known;
    for (const std::string& other : names) known += (known.empty() ? "" : ", ") + other;
    throw InputError(where + ": " + spring_method_name(method) + " has no option " + quoted(name) +
                     "; it has " + known);
  }
  const std::string place = where + " " + std::string(name);
  if (name == "face_opposite") options.face_opposite = parse_flag(text, place);
  if (name == "stiffness_n_per_m") options.uniform_stiffness_n_per_m = parse_number(text, place);
  if (name == "row_weight") options.stiffness_row_weight = parse_number(text, place);
  if (name == "rows") options.printed_rows = parse_thesis_rows(text, place);
  if (name == "patch_length") options.patch_length = parse_number(text, place);
}

}  // namespace palpate::springs

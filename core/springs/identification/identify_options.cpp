#include "core/springs/identification/identify_options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "core/base/error.h"

namespace palpate::springs {
namespace {

std::vector<SpringMethod> all_methods() {
  std::vector<SpringMethod> methods;
  for (const std::string& name : spring_method_names()) methods.push_back(parse_spring_method(name));
  return methods;
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

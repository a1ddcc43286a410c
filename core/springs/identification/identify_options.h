// The options of the identification methods by name, as on the command line and in requests.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/springs/identification/identify.h"

namespace palpate::springs {

/// An option: its name, what it is, its default as text, and the methods that take it.
struct SpringOption {
  std::string name;
  std::string summary;
  std::string default_text;
  std::vector<SpringMethod> methods;
};

/// All of them: face_opposite, stiffness_n_per_m, row_weight, rows, patch_length.
std::span<const SpringOption> spring_options();

/// Names of the options that the method takes.
std::vector<std::string> spring_option_names(SpringMethod method);

/// How thesis_printed reads appendix B: "letter", "b4_sign" or "substituted" (ThesisRows).
/// Throws: InputError that starts with `where`.
ThesisRows parse_thesis_rows(std::string_view text, const std::string& where);

/// Sets the option `name` of the method from its text ("true", "0.5"). Ranges are checked by
/// identify_springs.
///
/// Throws: InputError that starts with `where`, for an option that the method does not take, or a text that
///         is not true or false, or not a finite number.
void set_spring_option(SpringMethod method, std::string_view name, std::string_view text,
                       const std::string& where, IdentifyOptions& options);

}  // namespace palpate::springs

// The identification methods and their options by name, as on the command line and in requests: who asks for
// springs and solves nothing needs no more than this.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/springs/identification/thesis_rows.h"

namespace palpate::springs {

/// The identification methods; kTrained needs fields to learn from and is not among them.
enum class SpringMethod {
  kUniform,
  kVanGelder,
  kLloyd,
  kMaciel,
  kStiffnessFit,
  kThesisPrinted,
  kThesisCorrected,
  kIsotropy,
  kIsotropyPatch
};

/// "isotropy_patch" and so on, as on the command line, in the order of the enumeration.
const std::vector<std::string>& spring_method_names();
/// The name that parse_spring_method reads.
const char* spring_method_name(SpringMethod method);

/// The method of that name. Throws: InputError that lists the names.
SpringMethod parse_spring_method(std::string_view name);

/// Options of the methods; each says whose it is.
struct IdentifyOptions {
  bool face_opposite = false;  ///< also a spring between the two apexes of each interior face
  std::optional<double>
      uniform_stiffness_n_per_m{};    ///< kUniform: given; else the best fit to sum k U^2 = 6 E V
  double stiffness_row_weight = 1.0;  ///< kThesisPrinted, kThesisCorrected: of the stiffness row
  ThesisRows printed_rows = ThesisRows::kPrinted;  ///< kThesisPrinted: how appendix B is read
  double patch_length = 1.0;  ///< kIsotropyPatch: weight of the patch rows, in mean rest lengths
  double tolerance = 1e-10;   ///< of the KKT residual
};

/// Throws: InputError unless 0 < E < infinity, -1 < nu < 0.5 and density >= 0, naming what is wrong; `prefix`
/// goes before "young_modulus_pa", "poisson_ratio", "density_kg_m3".
void check_material(const Material& material, const std::string& prefix = "");

/// Throws: InputError for a number that is not above 0, naming the option.
void check_options(const IdentifyOptions& options);

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

// Spring constants that make a network move like an elastic solid: each method a named function of mesh and
// material.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"
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

/// What came of it.
struct IdentifyReport {
  SpringMethod method = SpringMethod::kUniform;
  std::size_t zero_springs = 0;
  double kkt_relative = 0.0;  ///< 0 for closed forms
  std::size_t iterations = 0;
  bool converged = true;
  double stiffness_ratio_mean = 0.0;  ///< over vertices, of sum over its springs of k U^2 / (12 E V_m)
  std::vector<Index>
      degenerate_vertices;  ///< one tet, or a flat fan: their constants rest on too few directions
  std::vector<Index> hanging_vertices;  ///< find_hanging_vertices
  std::vector<std::string> warnings;    ///< one line each; they name the first few vertices
};

/// Throws: InputError unless 0 < E < infinity, -1 < nu < 0.5 and density >= 0, naming what is wrong; `prefix`
/// goes before "young_modulus_pa", "poisson_ratio", "density_kg_m3".
void check_material(const Material& material, const std::string& prefix = "");

/// Identifies the stiffness of each spring for Young's modulus and Poisson's ratio. Springs alone give 1/4
/// whatever the ratio is, and a warning says so (a volume model carries the rest; fit to mu then: E_s = 2.5
/// mu). The formulas and where they come from: docs/springs.md.
///
/// Requires: points in metres, positive tets, no isolated vertices.
/// Throws: InputError as check_material; for an option out of range. ContractError for a mesh that breaks
/// what is required.
SpringNetwork identify_springs(const TetMesh& mesh, const Material& material, SpringMethod method,
                               const IdentifyOptions& options, IdentifyReport& report);

}  // namespace palpate::springs

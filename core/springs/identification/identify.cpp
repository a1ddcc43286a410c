#include "core/springs/identification/identify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/springs/identification/closed_forms.h"
#include "core/springs/identification/isotropy_fit.h"
#include "core/springs/identification/isotropy_rows.h"
#include "core/springs/identification/stiffness_fit.h"
#include "core/springs/identification/thesis_rows.h"
#include "core/springs/network/network.h"
#include "core/springs/network/weak_vertices.h"
#include "core/springs/solvers/nonnegative_least_squares.h"

namespace palpate::springs {
namespace {

constexpr double kNetworkRatio = 0.25;  ///< Poisson's ratio of every isotropic network of springs
constexpr std::size_t kNamedVertices = 5;

std::string rounded(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

void take_solver_report(const NonnegativeReport& solve, IdentifyReport& report) {
  report.kkt_relative = solve.kkt_relative;
  report.iterations = solve.iterations;
  report.converged = solve.converged;
}

void run_thesis(const TetMesh& mesh, double young_modulus_pa, ThesisRows rows, const IdentifyOptions& options,
                SpringNetwork& network, IdentifyReport& report) {
  ThesisOptions thesis;
  thesis.rows = rows;
  thesis.stiffness_row_weight = options.stiffness_row_weight;
  thesis.solve.tolerance = options.tolerance;
  if (options.face_opposite) {
    thesis.ridge_relative = kOppositeRidge;
    report.warnings.push_back(
        "with face_opposite the thesis's rows leave constants open; a ridge of 1% takes the smallest that "
        "fit");
  }
  take_solver_report(identify_thesis(mesh, young_modulus_pa, thesis, network), report);
}

void run_isotropy(const TetMesh& mesh, double young_modulus_pa, bool patch, const IdentifyOptions& options,
                  SpringNetwork& network, IdentifyReport& report) {
  IsotropyOptions isotropy;
  isotropy.patch = patch;
  isotropy.patch_length = options.patch_length;
  isotropy.solve.tolerance = options.tolerance;
  take_solver_report(identify_isotropy(mesh, young_modulus_pa, isotropy, network).solve, report);
}

void run_method(const TetMesh& mesh, const Material& material, const IdentifyOptions& options,
                SpringNetwork& network, IdentifyReport& report) {
  const double young = material.young_modulus_pa;
  switch (report.method) {
    case SpringMethod::kUniform:
      return set_uniform(mesh, young, options.uniform_stiffness_n_per_m, network);
    case SpringMethod::kVanGelder:
      return set_van_gelder(mesh, young, network);
    case SpringMethod::kLloyd:
      return set_lloyd(mesh, young, network);
    case SpringMethod::kMaciel:
      return set_maciel(mesh, young, network);
    case SpringMethod::kStiffnessFit:
      return set_stiffness_fit(mesh, material, network);
    case SpringMethod::kThesisPrinted:
      return run_thesis(mesh, young, options.printed_rows, options, network, report);
    case SpringMethod::kThesisCorrected:
      return run_thesis(mesh, young, ThesisRows::kCorrected, options, network, report);
    case SpringMethod::kIsotropy:
      return run_isotropy(mesh, young, false, options, network, report);
    case SpringMethod::kIsotropyPatch:
      return run_isotropy(mesh, young, true, options, network, report);
  }
  throw ContractError("identify_springs: no such method");
}

void warn_of_ratio(const Material& material, IdentifyReport& report) {
  if (std::abs(material.poisson_ratio - kNetworkRatio) < 1e-9) return;
  std::string ratio;
  append_number(ratio, material.poisson_ratio);
  report.warnings.push_back("springs alone give Poisson's ratio 0.25, not " + ratio +
                            "; with a volume model for the rest, identify for E = 2.5 mu = " +
                            rounded(2.5 * material.mu_pa()) + " Pa and 0.25");
}

void warn_of_stiffness(IdentifyReport& report) {
  if (std::abs(report.stiffness_ratio_mean - 1.0) <= 0.1) return;
  report.warnings.push_back("the network is about " + rounded(report.stiffness_ratio_mean) +
                            " times as stiff as the solid (mean over vertices of sum k U^2 / (12 E V))");
}

/// The first few of them.
std::string named(const std::vector<Index>& vertices) {
  std::string text;
  for (std::size_t i = 0; i < std::min(vertices.size(), kNamedVertices); ++i)
    text += (i > 0 ? ", " : "") + std::to_string(vertices[i]);
  return vertices.size() > kNamedVertices ? text + ", ..." : text;
}

void warn_of_degenerate(IdentifyReport& report) {
  if (report.degenerate_vertices.empty()) return;
  const std::size_t count = report.degenerate_vertices.size();
  const std::string text =
      std::to_string(count) + (count == 1 ? " vertex rests" : " vertices rest") +
      " on too few directions (one tetrahedron, or a flat fan), and the constants there on less "
      "than the method wants: ";
  report.warnings.push_back(text + named(report.degenerate_vertices));
}

void warn_of_hanging(IdentifyReport& report) {
  if (report.hanging_vertices.empty()) return;
  const std::size_t count = report.hanging_vertices.size();
  report.warnings.push_back(
      std::to_string(count) + (count == 1 ? " vertex hangs" : " vertices hang") +
      " on too little, free to move in some direction by springs alone (simulate may say \"buckled\"): " +
      named(report.hanging_vertices) +
      "; face_opposite=true, a method whose constants are all positive (van_gelder, lloyd), a coarser skin "
      "or a "
      "volume model holds them");
}

void fill_report(const TetMesh& mesh, const Material& material, const SpringNetwork& network,
                 IdentifyReport& report) {
  const auto& k = network.stiffness_n_per_m;
  report.zero_springs = static_cast<std::size_t>(std::count(k.begin(), k.end(), 0.0));
  const std::vector<double> volumes = build_influence_volumes(mesh);
  const std::vector<double> ratios = build_stiffness_ratios(network, volumes, material.young_modulus_pa);
  report.stiffness_ratio_mean =
      std::accumulate(ratios.begin(), ratios.end(), 0.0) / static_cast<double>(ratios.size());
  report.degenerate_vertices = find_degenerate_vertices(mesh, network);
  warn_of_ratio(material, report);
  warn_of_stiffness(report);
  report.hanging_vertices = find_hanging_vertices(mesh, network, material.young_modulus_pa);
  warn_of_degenerate(report);
  warn_of_hanging(report);
  if (!report.converged) {
    report.warnings.push_back("the solver stopped at a KKT residual of " + rounded(report.kkt_relative) +
                              ": the constants are not the optimum");
  }
}

/// Every vertex has a volume, and none is negative or not a number.
void require_volumes(const TetMesh& mesh) {
  require(!mesh.tets.empty(), "identify_springs: the mesh has no tets");
  for (const double volume : build_influence_volumes(mesh))
    require(volume > 0.0 && std::isfinite(volume), "identify_springs: a vertex without volume");
}

}  // namespace

SpringNetwork identify_springs(const TetMesh& mesh, const Material& material, SpringMethod method,
                               const IdentifyOptions& options, IdentifyReport& report) {
  check_material(material);
  check_options(options);
  require_volumes(mesh);
  report = IdentifyReport{};
  report.method = method;
  SpringNetwork network = build_spring_network(mesh, options.face_opposite);
  run_method(mesh, material, options, network, report);
  fill_report(mesh, material, network, report);
  return network;
}

}  // namespace palpate::springs

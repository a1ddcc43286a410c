// springs: spring constants of a mesh by one method, as a CSV for a simulator.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <numeric>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "core/springs/identification/identify_options.h"
#include "core/springs/network/network.h"
#include "core/springs/network/springs_csv.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/files/output_file.h"
#include "experiments/meshes/metre_mesh.h"
#include "experiments/spring_training/identified_springs.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// Of a modulus, a density or a unit, in size.

struct SpringsArguments {
  std::string mesh;
  std::string out;
  std::string masses;
  std::string method;
  std::vector<std::string> set;
  double young_pa = 0.0;
  double poisson = 0.0;
  double density = 0.0;
  bool has_density = false;
  double unit_m = 1.0;
  bool as_json = false;
};

springs::SpringMethod find_spring_method(const std::string& name) {
  const std::vector<std::string>& names = springs::spring_method_names();
  if (name == "trained") {
    throw InputError(
        "--method trained: trained springs are fitted to displacement fields of a training set, and this "
        "command has only a mesh; isotropy_patch is the method that they start from");
  }
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw InputError("--method: unknown method \"" + name + "\"" + nearest_hint(name, names));
  return springs::parse_spring_method(name);
}

/// Takes the options of the wish's method, and whether its springs are calibrated on their own mesh.
void parse_spring_options(const std::vector<std::string>& settings, SpringWish& wish) {
  springs::IdentifyOptions options;
  std::set<std::string> given;
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0)
      throw InputError("--set", 0, "key=value", "\"" + setting + "\"");
    const std::string key = setting.substr(0, equals);
    if (!given.insert(key).second) throw InputError("--set: option \"" + key + "\" twice");
    const std::string value = setting.substr(equals + 1);
    if (key != "calibrate") {
      springs::set_spring_option(wish.method, key, value, "--set", options);
      wish.set[key] = value;
    } else {
      if (value != "true" && value != "false")
        throw InputError("--set calibrate", 0, "true or false", "\"" + value + "\"");
      wish.calibrate = value == "true";
    }
  }
}

/// A number from an option that has to be above 0.
Material material_of(const SpringsArguments& arguments) {
  check_material_options(arguments.young_pa, arguments.poisson,
                         arguments.has_density ? std::optional(arguments.density) : std::nullopt);
  if (!arguments.masses.empty() && !arguments.has_density)
    throw InputError("--masses: masses need --density");
  return {arguments.young_pa, arguments.poisson, arguments.density};
}

void write_masses(const std::string& path, const std::vector<double>& masses) {
  std::string text = "vertex,mass_kg\n";
  for (std::size_t v = 0; v < masses.size(); ++v) {
    append_number(text, v);
    text += ',';
    append_number(text, masses[v]);
    text += '\n';
  }
  write_file_atomically(path, text);
}

json triple(const Vec3& v) {
  return {v.x, v.y, v.z};
}

json figures_of(const SpringsArguments& arguments, const TetMesh& mesh, const IdentifiedSprings& found) {
  const springs::IdentifyReport& report = found.report;
  const auto& k = found.network.stiffness_n_per_m;
  json figures{{"method", springs::spring_method_name(report.method)},
               {"vertices", mesh.points.size()},
               {"tets", mesh.tets.size()},
               {"springs", k.size()},
               {"zero_springs", report.zero_springs},
               {"stiffness_min_n_per_m", *std::min_element(k.begin(), k.end())},
               {"stiffness_max_n_per_m", *std::max_element(k.begin(), k.end())},
               {"stiffness_ratio_mean", report.stiffness_ratio_mean},
               {"kkt_relative", report.kkt_relative},
               {"iterations", report.iterations},
               {"converged", report.converged},
               {"kernel_s", found.kernel_s},
               {"volume_m3", total_volume(mesh)},
               {"geometric_center_m", triple(springs::geometric_center(mesh))},
               {"center_of_mass_m", triple(springs::center_of_mass(mesh))},
               {"degenerate_vertices", report.degenerate_vertices},
               {"hanging_vertices", report.hanging_vertices},
               {"warnings", report.warnings},
               {"file", arguments.out}};
  if (arguments.has_density) figures["mass_kg"] = arguments.density * total_volume(mesh);
  return figures;
}

void print_figures(const json& figures) {
  constexpr std::array<std::pair<const char*, const char*>, 12> kNames{
      {{"vertices", "vertices"},
       {"tets", "tetrahedra"},
       {"springs", "springs"},
       {"zero_springs", "springs of stiffness 0"},
       {"stiffness_min_n_per_m", "least stiffness, N/m"},
       {"stiffness_max_n_per_m", "greatest stiffness, N/m"},
       {"stiffness_ratio_mean", "stiffness against the solid, mean"},
       {"calibration_factor", "calibrated by"},
       {"kkt_relative", "KKT residual, relative"},
       {"iterations", "iterations"},
       {"volume_m3", "volume, m^3"},
       {"mass_kg", "mass, kg"}}};
  TextTable table({"measure", "value"}, "lr");
  for (const auto& [key, name] : kNames) {
    if (figures.contains(key)) table.add({name, short_number(figures.at(key).get<double>())});
  }
  table.add({"time of the method", time_text(figures.at("kernel_s").get<double>())});
  std::cout << table.text();
}

int identify(const SpringsArguments& arguments) {
  SpringWish wish;
  wish.method = find_spring_method(arguments.method);
  parse_spring_options(arguments.set, wish);
  wish.material = material_of(arguments);
  if (!(arguments.unit_m > 0.0))
    throw InputError("--unit-m", 0, "a finite number above 0", short_number(arguments.unit_m));
  check_output_csv(arguments.out);
  refuse_output_over_input("-o", arguments.out, {arguments.mesh});
  if (!arguments.masses.empty()) {
    check_output_csv(arguments.masses);
    refuse_output_over_input("--masses", arguments.masses, {arguments.mesh});
    if (is_same_file(arguments.masses, arguments.out))
      throw InputError("--masses: the same file as --output");
  }
  const TetMesh mesh = read_mesh_in_metres(arguments.mesh, arguments.unit_m);
  const IdentifiedSprings found = obtain_springs(mesh, wish);
  const springs::IdentifyReport& report = found.report;
  springs::write_springs_csv(arguments.out, found.network);
  if (!arguments.masses.empty())
    write_masses(arguments.masses, springs::build_lumped_masses(mesh, arguments.density));
  for (const std::string& warning : report.warnings) print_note(warning);
  json figures = figures_of(arguments, mesh, found);
  if (wish.calibrate) {
    figures["calibration_factor"] = found.calibration_factor;
    figures["stiffness_ratio_mean"] = found.calibration_factor * report.stiffness_ratio_mean;
  }
  if (arguments.as_json) {
    print_json(figures);
  } else {
    print_figures(figures);
    std::cout << "Written: " << arguments.out << '\n';
  }
  return report.converged && report.hanging_vertices.empty() ? kDone : kNotAccepted;
}

std::string springs_footer() {
  std::string text =
      "Methods: " + joined(springs::spring_method_names()) + ".\n\n" + "Options of the methods (--set):\n";
  for (const springs::SpringOption& option : springs::spring_options()) {
    text += "  " + option.name + "=: " + option.summary + " (" + option.default_text + "); ";
    std::vector<std::string> methods;
    for (const springs::SpringMethod method : option.methods)
      methods.emplace_back(springs::spring_method_name(method));
    text += joined(methods) + "\n";
  }
  text +=
      "  calibrate=: true: all springs times one factor, from the moduli that they have on their own mesh "
      "(false); all methods\n";
  return text +
         "\nThe CSV has the columns vertex_a, vertex_b, rest_length_m, stiffness_n_per_m; vertices count "
         "from "
         "0.\n"
         "Springs alone give Poisson's ratio 0.25. Formulas and what they satisfy: docs/springs.md.\n"
         "Exit codes: 0 done; 1 written, but the solver did not reach the optimum, or vertices hang on too "
         "little; 2 bad input.";
}

}  // namespace

void add_springs_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SpringsArguments>();
  CLI::App* command = app.add_subcommand("springs", "Find the spring constants of a mesh with one method");
  // What is above 0 or below 0.5 is checked later, so that the message can say so.
  const auto a_number = number_from(-kMostNumber, kMostNumber);
  command->add_option("MESH", arguments->mesh, "Mesh to put springs on")->required();
  command->add_option("-o,--output", arguments->out, "Springs to write (.csv)")
      ->required()
      ->type_name("FILE");
  command->add_option("--method", arguments->method, "One of the methods below")
      ->required()
      ->type_name("NAME");
  command->add_option("--young-pa", arguments->young_pa, "Young's modulus, Pa")
      ->required()
      ->check(a_number)
      ->type_name("E");
  command->add_option("--poisson", arguments->poisson, "Poisson's ratio, above -1 and below 0.5")
      ->required()
      ->check(a_number)
      ->type_name("NU");
  auto* density = command->add_option("--density", arguments->density, "Density, kg/m^3, for masses")
                      ->check(a_number)
                      ->type_name("RHO");
  command->add_option("--masses", arguments->masses, "Lumped masses to write (.csv); needs --density")
      ->type_name("FILE");
  command->add_option("--unit-m", arguments->unit_m, "The mesh's unit in metres (1); 0.001 for millimetres")
      ->check(a_number)
      ->type_name("M");
  command->add_option("--set", arguments->set, "Option of the method, as often as needed")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  command->add_flag("--json", arguments->as_json, "Print the report as JSON");
  command->footer(springs_footer());
  command->callback([arguments, density, &exit_code] {
    arguments->has_density = density->count() > 0;
    exit_code = identify(*arguments);
  });
}

}  // namespace palpate::experiments

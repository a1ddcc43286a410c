// export: a whole model of a mesh as one file for another simulator.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/boundary_problem.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/contests/moving_task.h"
#include "experiments/files/output_file.h"
#include "experiments/files/plain_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/meshes/metre_mesh.h"
#include "experiments/scene_reader/scene_motion.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"
#include "reference/door/deform_problem.h"
#include "reference/door/json_file.h"
#include "reference/door/moving_body.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr std::size_t kMostBytes = std::size_t{1} << 36U;  ///< of a model
constexpr const char* kTableMethod = "reduced.compliance";

struct ExportArguments {
  std::string mesh;
  std::string out;
  std::string method;
  std::vector<std::string> set;
  std::optional<double> young_modulus_pa;
  std::optional<double> density_kg_m3;
  double poisson_ratio = 0.0;
  std::string strain = "small";
  double stiffness_s = 0.0;
  double mass_per_s = 0.0;
  double unit_m = 1.0;
};

/// The options as they were given, by their names.
std::map<std::string, GivenOption> given_options(const ExportArguments& arguments) {
  std::map<std::string, GivenOption> given;
  for (const std::string& setting : arguments.set) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0)
      throw InputError("--set", 0, "key=value", "\"" + setting + "\"");
    const std::string key = setting.substr(0, equals);
    if (!given.insert({key, {setting.substr(equals + 1), "--set"}}).second)
      throw InputError("--set: option \"" + key + "\" twice");
  }
  return given;
}

/// The method with its options: those that make the model, none that say how to solve.
json model_options(const ExportArguments& arguments, const Registry& registry) {
  std::vector<std::string> known{kTableMethod};
  for (const std::string& name : registry.method_names()) {
    if (name.starts_with("springs.") || name.starts_with("smoothed.")) known.push_back(name);
  }
  if (std::find(known.begin(), known.end(), arguments.method) == known.end())
    throw InputError("--method: \"" + arguments.method +
                     "\" is no springs.NAME, smoothed.NAME or reduced.compliance" +
                     nearest_hint(arguments.method, known));
  const auto given = given_options(arguments);
  json options = resolve_options(*registry.find(arguments.method)->method, given);
  for (const char* key : kStaticOptions) {
    if (given.contains(key))
      throw InputError(std::string("--set: ") + key + " says how to solve, and is no part of a model");
    options.erase(key);
  }
  return options;
}

/// Before any work: the ending is the format's, and the folder is there.
void check_output(const std::filesystem::path& path, const std::string& ending) {
  std::error_code error;
  if (path.extension() != ending)
    throw InputError(path.string(), 0, "an output that ends in " + ending, path.extension().string());
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(folder, error))
    throw InputError(path.string(), 0, "an output in a folder that exists", "no folder " + folder.string());
}

/// The body at rest, without anything that holds or moves it.
reference::MovingBody build_body(const ExportArguments& arguments, const json& options) {
  reference::MovingBody body;
  body.motion.body.material = {*arguments.young_modulus_pa, arguments.poisson_ratio,
                               *arguments.density_kg_m3};
  body.motion.body.strain = arguments.strain == "large" ? StrainSize::kLarge : StrainSize::kSmall;
  body.motion.damping_stiffness_s = arguments.stiffness_s;
  body.motion.damping_mass_per_s = arguments.mass_per_s;
  body.motion.duration_s = 1.0;  // no step is taken
  body.model.method = arguments.method;
  body.model.options = options;
  return body;
}

/// A table knows neither modulus nor density nor damping: it is that of 1 Pa, and of a body at rest.
void check_table_arguments(const ExportArguments& arguments) {
  const std::string method = kTableMethod;
  if (arguments.young_modulus_pa)
    throw InputError("--young-pa: a table of " + method + " serves any Young's modulus: leave it out");
  if (arguments.density_kg_m3)
    throw InputError("--density: a table of " + method + " serves any density: leave it out");
  if (arguments.strain != "small") throw InputError("--strain", 0, "small for " + method, arguments.strain);
  if (arguments.stiffness_s != 0.0 || arguments.mass_per_s != 0.0)
    throw InputError("--damping-stiffness-s, --damping-mass-per-s: a table of " + method +
                     " is of a body at rest");
  check_output(arguments.out, ".compliance");
}

/// The table (docs/reduced.md) comes with an answer: here that of a body at rest on one face.
int export_table(const ExportArguments& arguments, const Registry& registry) {
  std::map<std::string, GivenOption> given = given_options(arguments);
  for (const char* key : {"table", "write_table"}) {
    if (given.contains(key)) throw InputError(std::string("--set: ") + key + " is not taken here");
  }
  given["write_table"] = {"true", "--set"};
  const TetMesh mesh = read_mesh_in_metres(arguments.mesh, arguments.unit_m);
  BoundaryProblem problem;
  problem.material = {1.0, arguments.poisson_ratio, 1.0};
  problem.supports.push_back(
      {{{build_boundary(mesh).front()}, {1.0}}, 1.0 / longest_side(bounding_box(mesh.points)), {}});
  const ScratchFolder scratch;
  ContestantTask task =
      start_task(kTableMethod, reference::problem_to_json(problem), mesh, registry, scratch.file("body"));
  task.options = resolve_options(*task.method.method, given);
  const ContestantAnswer answer = run_moving_task(task, arguments.mesh);
  for (const std::string& note : answer.notes) print_note(note);
  const auto bytes = read_bytes(answer.report.at("table_file").get<std::string>());
  if (!bytes) throw UnavailableError(std::string(kTableMethod) + " left no table");
  write_file_atomically(arguments.out, *bytes);
  std::cout << "Written: " << arguments.out << '\n';
  return kDone;
}

void check_model_arguments(const ExportArguments& arguments) {
  if (!arguments.young_modulus_pa) throw InputError("--young-pa", 0, "a number of Pa", "none");
  if (!arguments.density_kg_m3) throw InputError("--density", 0, "a number of kg/m^3", "none");
  check_material_options(*arguments.young_modulus_pa, arguments.poisson_ratio, arguments.density_kg_m3);
  check_output(arguments.out, ".json");
}

int export_model(const ExportArguments& arguments) {
  if (!(arguments.unit_m > 0.0))
    throw InputError("--unit-m", 0, "a finite number above 0", short_number(arguments.unit_m));
  const bool is_table = arguments.method == kTableMethod;
  is_table ? check_table_arguments(arguments) : check_model_arguments(arguments);
  refuse_output_over_input("-o", arguments.out, {arguments.mesh});
  const Registry registry = load_registry();
  if (is_table) return export_table(arguments, registry);
  const json options = model_options(arguments, registry);
  const TetMesh mesh = read_mesh_in_metres(arguments.mesh, arguments.unit_m);
  const ScratchFolder scratch;
  const ContestantTask task =
      start_moving_task("engine.model", build_body(arguments, options), mesh, registry, scratch.file("body"));
  const ContestantAnswer answer = run_moving_task(task, arguments.mesh);
  for (const std::string& note : answer.notes) print_note(note);
  write_file_atomically(arguments.out, reference::read_text_file(answer.output, kMostBytes));
  std::cout << "Written: " << arguments.out << '\n';
  return kDone;
}

}  // namespace

void add_export_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* command = app.add_subcommand("export", "Write a whole model of a mesh for another simulator");
  const auto a_number = number_from(-kMostNumber, kMostNumber);
  command->add_option("MESH", arguments->mesh, "Mesh of the body")->required();
  command->add_option("-o,--output", arguments->out, "Model to write (.json), or table (.compliance)")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--method", arguments->method,
                   "springs.NAME, smoothed.NAME or reduced.compliance, as in a plan")
      ->required()
      ->type_name("NAME");
  const auto add_number = [&](const char* flag, auto& into, const char* help) {
    return command->add_option(flag, into, help)->check(a_number);
  };
  add_number("--young-pa", arguments->young_modulus_pa, "Young's modulus, Pa; not for a table");
  add_number("--poisson", arguments->poisson_ratio, "Poisson's ratio")->required();
  add_number("--density", arguments->density_kg_m3, "Density, kg/m^3; not for a table");
  add_number("--unit-m", arguments->unit_m, "The mesh's unit in metres (1); 0.001 for millimetres");
  command->add_option("--strain", arguments->strain, "small or large (small)")
      ->check(CLI::IsMember({"small", "large"}));
  command
      ->add_option("--damping-stiffness-s", arguments->stiffness_s, "Damping as a share of stiffness, s (0)")
      ->check(number_from(0.0, kMostNumber));
  command->add_option("--damping-mass-per-s", arguments->mass_per_s, "Damping as a share of mass, 1/s (0)")
      ->check(number_from(0.0, kMostNumber));
  command->add_option("--set", arguments->set, "Option of the method, as often as needed")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  command->footer(
      "Methods and options are those of plans (palpate list contestants): --set calibrate=true, --set "
      "volume=node_average and so on.\nThe file has points, tetrahedra, masses, springs, smoothed energies "
      "and "
      "damping; docs/model_file.md says how, docs/read_model.py reads it. A table has the compliances of the "
      "skin: docs/reduced.md.");
  command->callback([arguments, &exit_code] { exit_code = export_model(*arguments); });
}

}  // namespace palpate::experiments

// export: a whole model of a mesh as one file for another simulator.
#include "experiments/commands/commands_export.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/springs/identification/identify.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/metre_mesh.h"
#include "experiments/commands/usage.h"
#include "experiments/contests/moving_task.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"
#include "reference/door/json_file.h"
#include "reference/door/moving_body.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// Of a modulus, a density or a unit, in size.
constexpr std::size_t kMostBytes = std::size_t{1} << 36U;  ///< of a model

struct ExportArguments {
  std::string mesh;
  std::string out;
  std::string method;
  std::vector<std::string> set;
  Material material;
  std::string strain = "small";
  double stiffness_s = 0.0;
  double mass_per_s = 0.0;
  double unit_m = 1.0;
};

/// The method with its options: those that make the model, none that say how to solve.
json model_options(const ExportArguments& arguments, const Registry& registry) {
  std::vector<std::string> known;
  for (const std::string& name : registry.method_names()) {
    if (name.starts_with("springs.") || name.starts_with("smoothed.")) known.push_back(name);
  }
  if (std::find(known.begin(), known.end(), arguments.method) == known.end())
    throw InputError("--method: \"" + arguments.method + "\" is no springs.NAME or smoothed.NAME" +
                     nearest_hint(arguments.method, known));
  std::map<std::string, GivenOption> given;
  for (const std::string& setting : arguments.set) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0)
      throw InputError("--set", 0, "key=value", "\"" + setting + "\"");
    const std::string key = setting.substr(0, equals);
    if (!given.insert({key, {setting.substr(equals + 1), "--set"}}).second)
      throw InputError("--set: option \"" + key + "\" twice");
  }
  json options = resolve_options(*registry.find(arguments.method)->method, given);
  for (const char* key : {"load_steps", "max_iterations", "tolerance", "solver"}) {
    if (given.contains(key))
      throw InputError(std::string("--set: ") + key + " says how to solve, and is no part of a model");
    options.erase(key);
  }
  return options;
}

/// Before any work: the ending is .json, and the folder is there.
void check_output(const std::filesystem::path& path) {
  std::error_code error;
  if (path.extension() != ".json")
    throw InputError(path.string(), 0, "an output that ends in .json", path.extension().string());
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(folder, error))
    throw InputError(path.string(), 0, "an output in a folder that exists", "no folder " + folder.string());
}

/// The body at rest, without anything that holds or moves it.
reference::MovingBody build_body(const ExportArguments& arguments, const json& options) {
  reference::MovingBody body;
  body.motion.body.material = arguments.material;
  body.motion.body.strain = arguments.strain == "large" ? StrainSize::kLarge : StrainSize::kSmall;
  body.motion.damping_stiffness_s = arguments.stiffness_s;
  body.motion.damping_mass_per_s = arguments.mass_per_s;
  body.motion.duration_s = 1.0;  // no step is taken
  body.model.method = arguments.method;
  body.model.options = options;
  return body;
}

int export_model(const ExportArguments& arguments) {
  springs::check_material(arguments.material, "--");
  if (!(arguments.material.density_kg_m3 > 0.0))
    throw InputError("--density", 0, "a finite number above 0", "0");
  if (!(arguments.unit_m > 0.0))
    throw InputError("--unit-m", 0, "a finite number above 0", short_number(arguments.unit_m));
  check_output(arguments.out);
  const Registry registry = load_registry();
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
  command->add_option("-o,--output", arguments->out, "Model to write (.json)")->required()->type_name("FILE");
  command->add_option("--method", arguments->method, "springs.NAME or smoothed.NAME, as in a plan")
      ->required()
      ->type_name("NAME");
  const auto add_number = [&](const char* flag, double& into, const char* help) {
    return command->add_option(flag, into, help)->check(a_number);
  };
  add_number("--young-pa", arguments->material.young_modulus_pa, "Young's modulus, Pa")->required();
  add_number("--poisson", arguments->material.poisson_ratio, "Poisson's ratio")->required();
  add_number("--density", arguments->material.density_kg_m3, "Density, kg/m^3")->required();
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
      "damping; docs/model_file.md says how, docs/read_model.py reads it.");
  command->callback([arguments, &exit_code] { exit_code = export_model(*arguments); });
}

}  // namespace palpate::experiments

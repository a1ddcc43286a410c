// scene: a first scene of a user's organ.
#include <array>
#include <cstdio>
#include <iostream>
#include <memory>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/files/output_file.h"
#include "experiments/judging/judge_record.h"
#include "experiments/scene_writer/draft_text.h"
#include "experiments/scene_writer/scene_draft.h"
#include "experiments/scene_writer/scene_picture.h"
#include "experiments/scene_writer/unit_guess.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

struct SceneArguments {
  std::string organ;
  std::string out;
  double unit_m = 0.0;  ///< 0: guessed
  std::uint64_t vertices = 0;
  std::string motion = "static";
  std::string up;  ///< empty: found
  bool force = false;
  Material material = kUsualMaterial;
  bool repair = false;
  bool show = false;
  bool as_json = false;
};

SceneWish wish_of(const SceneArguments& arguments) {
  SceneWish wish;
  wish.organ = arguments.organ;
  wish.scene = arguments.out;
  if (arguments.unit_m > 0.0) wish.unit_m = arguments.unit_m;
  if (arguments.vertices > 0) wish.vertices = arguments.vertices;
  wish.repair = arguments.repair;
  wish.material = arguments.material;
  wish.is_dynamic = arguments.motion == "dynamic";
  if (!arguments.up.empty()) wish.up = arguments.up;
  return wish;
}

json describe_draft(const SceneDraft& draft, const SceneArguments& arguments) {
  const Judgement judgement = judge_mesh(draft.mesh);
  return {{"file", arguments.out},
          {"analysis", arguments.motion},
          {"unit_m", draft.unit_m},
          {"unit_guessed", arguments.unit_m <= 0.0},
          {"up", draft.up},
          {"size_m", {draft.size_m.x, draft.size_m.y, draft.size_m.z}},
          {"vertices", draft.mesh.points.size()},
          {"tets", draft.mesh.tets.size()},
          {"percent_above_0_5", judgement.figures.value("percent_above_0_5", json())},
          {"min_dihedral_deg", judgement.figures.value("min_dihedral_deg", json())},
          {"support",
           {{"share", draft.support.share},
            {"faces", draft.support.faces},
            {"area_share", draft.support.area_share}}},
          {"pad",
           {{"center_m", {draft.pad.center_m.x, draft.pad.center_m.y, draft.pad.center_m.z}},
            {"radius_m", draft.pad.radius_m},
            {"faces", draft.pad.faces},
            {"area_share", draft.pad.area_share},
            {"edges_wide", 2.0 * draft.pad.radius_m / draft.pad.mean_edge_m},
            {"thickness_m", draft.pad.thickness_m},
            {"push_m", length(draft.push_m)}}}};
}

std::string formatted(const char* format, double value) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

void print_draft(const json& figures, const SceneDraft& draft) {
  const auto number = [&](const char* key, const char* format) {
    return figures.at(key).is_number() ? formatted(format, figures.at(key).get<double>())
                                       : std::string("none");
  };
  TextTable table({"what", "found"}, "ll");
  table.add({"size", formatted("%.3g x ", 100.0 * draft.size_m.x) +
                         formatted("%.3g x ", 100.0 * draft.size_m.y) +
                         formatted("%.3g cm", 100.0 * draft.size_m.z)});
  table.add({"mesh", std::to_string(draft.mesh.points.size()) + " vertices, " +
                         std::to_string(draft.mesh.tets.size()) + " tetrahedra"});
  table.add({"quality", number("percent_above_0_5", "%.1f%% above 0.5, ") +
                            number("min_dihedral_deg", "least dihedral angle %.1f degrees")});
  table.add({"support", std::to_string(draft.support.faces) + " faces, " +
                            formatted("%.0f%% of the skin", 100.0 * draft.support.area_share)});
  table.add({"pad", formatted("%.3g mm across, ", 2000.0 * draft.pad.radius_m) +
                        std::to_string(draft.pad.faces) + " faces, " +
                        formatted("%.1f edges wide", 2.0 * draft.pad.radius_m / draft.pad.mean_edge_m)});
  table.add({"push", formatted("%.3g mm", 1000.0 * length(draft.push_m)) +
                         formatted(", 5%% of %.3g mm", 1000.0 * draft.pad.thickness_m)});
  std::cout << table.text();
}

/// Reads the scene back and puts it on its mesh as `check` does. A draft that does not pass is ours to mend.
BoundaryProblem verify(const std::filesystem::path& scene) {
  try {
    return resolve_draft(scene);
  } catch (const InputError& error) {
    throw ContractError(std::string("the drafted scene is refused: ") + error.what());
  }
}

/// A scene that was drafted has been edited since, more often than not.
void refuse_to_overwrite(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::exists(file, error))
    throw InputError(file.string(), 0, "a new file (--force writes over one)", "one that is there already");
}

int scene(const SceneArguments& arguments) {
  const std::filesystem::path out = arguments.out;
  check_output_yaml(out);
  refuse_output_over_input("-o", out, {arguments.organ});
  if (!arguments.force) {
    refuse_to_overwrite(out);
    for (const std::filesystem::path& picture : pictures_of(out)) {
      if (arguments.show) refuse_to_overwrite(picture);
    }
  }
  const SceneDraft draft = draft_scene(wish_of(arguments));
  print_note(arguments.organ + ": its unit is the " + unit_name(draft.unit_m) + ", " + draft.unit_reason +
             (arguments.unit_m > 0.0 ? "" : "; --unit-m says otherwise"));
  if (draft.up_is_chosen)
    print_note("it lies on its broad side, with " + draft.up + " up; --up says otherwise");
  for (const std::string& note : draft.notes) print_note(note);
  write_file_atomically(out, draft.yaml);
  const BoundaryProblem problem = verify(out);
  json figures = describe_draft(draft, arguments);
  figures["pictures"] = json::array();
  if (arguments.show) {
    for (const std::filesystem::path& picture : draw_scene(out, draft.mesh, problem))
      figures["pictures"].push_back(picture.string());
  }
  if (arguments.as_json) {
    print_json(figures);
    return kDone;
  }
  print_draft(figures, draft);
  std::cout << "Written: " << arguments.out << '\n';
  for (const json& picture : figures.at("pictures"))
    std::cout << "Written: " << picture.get<std::string>() << '\n';
  return kDone;
}

}  // namespace

void add_scene_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SceneArguments>();
  CLI::App* command =
      app.add_subcommand("scene", "Write a first scene of an organ, ready for check and simulate");
  command
      ->add_option("ORGAN", arguments->organ,
                   "Surface (.stl, .off, .obj, .ply) or mesh (.mesh, .msh, .vtk, .vtu)")
      ->required();
  command->add_option("-o,--output", arguments->out, "Scene to write (.yaml)")->required()->type_name("FILE");
  command
      ->add_option("--unit-m", arguments->unit_m,
                   "Length of the file's unit in m, 0.001 for mm; guessed from the size without it")
      ->check(number_from(1e-9, 1e9))
      ->type_name("U");
  command
      ->add_option("--young-pa", arguments->material.young_modulus_pa,
                   "Young's modulus of the material (10000)")
      ->check(number_from(1e-6, 1e15))
      ->type_name("E");
  command->add_option("--poisson", arguments->material.poisson_ratio, "Its Poisson's ratio (0.45)")
      ->check(number_from(-0.99, 0.4999))
      ->type_name("NU");
  command->add_option("--density", arguments->material.density_kg_m3, "Its density, in kg/m^3 (1050)")
      ->check(number_from(1e-6, 1e9))
      ->type_name("RHO");
  command->add_option("--vertices", arguments->vertices, "About so many vertices, of a surface's mesh (1500)")
      ->transform(whole_number_from(100, 5'000'000))
      ->type_name("N");
  command->add_option("--motion", arguments->motion, "static, or dynamic: pressed and let go (static)")
      ->check(CLI::IsMember({"static", "dynamic"}))
      ->type_name("HOW");
  command
      ->add_option("--up", arguments->up,
                   "What points up, against gravity; without it, the axis along which it is shortest")
      ->check(CLI::IsMember(std::vector<std::string>(kUpNames.begin(), kUpNames.end())))
      ->type_name("AXIS");
  command->add_flag("--repair", arguments->repair,
                    "Mend a surface that is open, inside out or intersects itself");
  command->add_flag("--show", arguments->show,
                    "Draw where it is held and pressed: FILE's name with .png and .svg");
  command->add_flag("--force", arguments->force, "Write over a FILE that is there already");
  command->add_flag("--json", arguments->as_json, "Print what was found as JSON");
  command->footer(
      "The scene holds how its mesh is made, the unit, the material, elastic supports on the underside, "
      "gravity and "
      "an\n"
      "elastic pad on top that is pushed in by 5% of the thickness below it. Everything in it is a starting "
      "point;\n"
      "docs/scenes.md says what else there is.");
  command->callback([arguments, &exit_code] { exit_code = scene(*arguments); });
}

}  // namespace palpate::experiments

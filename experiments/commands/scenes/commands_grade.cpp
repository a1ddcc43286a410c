// grade: from a scene to a mesh that is fine where the scene needs it, and the scene on that mesh.
#include <cmath>
#include <iostream>
#include <memory>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/topology.h"
#include "core/simplify/sizing/size_file.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/simplify_shortfall.h"
#include "experiments/commands/usage.h"
#include "experiments/files/output_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/fit/fit_search.h"
#include "experiments/grading/graded_mesh.h"
#include "experiments/judging/judge_record.h"
#include "experiments/processes/stop_signals.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/scene_writer/placed_text.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

struct GradeArguments {
  std::string scene;
  std::string out;
  std::int64_t tets = 0;  ///< 0: not given
  double ratio = -1.0;
  std::uint64_t vertices = 0;
  std::vector<std::string> near;
  std::string pilot;
  double reach_m = 0.0;  ///< 0: not given
  GradeWish wish;
  std::string method = "palpate.refined";
  std::vector<std::string> set;
  int threads = 1;
  bool as_json = false;
  std::vector<std::string> given;  ///< of the flags that say how sizes go, those that were given
};

Stop stop_of_grade(const GradeArguments& arguments) {
  if ((arguments.tets > 0) == (arguments.ratio >= 0.0))
    throw InputError("grade", 0, "one of --tets and --ratio: how many tetrahedra are to be left",
                     arguments.tets > 0 ? "both" : "neither");
  Stop stop;
  stop.kind = arguments.tets > 0 ? StopKind::kTets : StopKind::kRatio;
  stop.value = arguments.tets > 0 ? static_cast<double>(arguments.tets) : arguments.ratio;
  return stop;
}

GradeWish wish_of_grade(const GradeArguments& arguments, const Registry& registry) {
  GradeWish wish = arguments.wish;
  for (const std::string& text : arguments.near) wish.near.push_back(check_near(text, "--near"));
  wish.pilot = arguments.pilot;
  if (!wish.pilot.empty()) {
    const std::string why = find_pilot(wish.pilot, registry, "--pilot").contestant->unavailable();
    if (!why.empty()) throw UnavailableError(wish.pilot + " is unavailable: " + why);
  }
  if (arguments.reach_m > 0.0) wish.reach_m = arguments.reach_m;
  return wish;
}

/// Says which sizes have no use: they belong to places that are to be fine, or to a pilot.
void note_idle_sizes(const GradeArguments& arguments) {
  const auto say = [](const std::string& flag, const std::string& needed) {
    print_note(flag + " has no use without " + needed);
  };
  for (const std::string& flag : arguments.given) {
    if (flag == "--least-size") {
      if (arguments.pilot.empty()) say(flag, "--pilot");
    } else if (flag == "--growth") {
      if (arguments.pilot.empty() && arguments.near.empty()) say(flag, "--near or --pilot");
    } else if (arguments.near.empty()) {
      say(flag, "--near");
    }
  }
}

MethodEntry grading_method(const GradeArguments& arguments, const Registry& registry) {
  const auto entry = registry.find(arguments.method);
  if (!entry)
    throw InputError("--method: unknown method \"" + arguments.method + "\"" +
                     nearest_hint(arguments.method, registry.method_names()));
  const std::string why = entry->contestant->unavailable();
  if (!why.empty()) throw UnavailableError(arguments.method + " is unavailable: " + why);
  return *entry;
}

std::map<std::string, GivenOption> options_of_grade(const std::vector<std::string>& set) {
  std::map<std::string, GivenOption> options;
  for (const std::string& text : set) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) throw InputError("--set", 0, "KEY=VALUE", text);
    const std::string key = text.substr(0, equals);
    if (key == "sizes") throw InputError("--set", 0, "options beside sizes, which the scene gives", text);
    if (!options.emplace(key, GivenOption{text.substr(equals + 1), "--set"}).second)
      throw InputError("--set", 0, "each option once", key + " twice");
  }
  return options;
}

json describe_grade(const GradedMesh& graded, const TetMesh& whole, const GradeArguments& arguments) {
  json out = graded.wanted.facts;
  out["schema"] = "palpate/grade/1";
  out["scene"] = fs::absolute(arguments.scene).string();
  out["method"] = arguments.method;
  out["vertices_in"] = whole.points.size();
  out["tets_in"] = whole.tets.size();
  out["vertices"] = graded.mesh.points.size();
  out["tets"] = graded.mesh.tets.size();
  out["stop"] = graded.report.value("stop", "");
  if (graded.kernel_s) out["simplify_s"] = *graded.kernel_s;
  const Judgement judgement = judge_mesh(graded.mesh);
  out["valid"] = judgement.violations.empty();
  out["violations"] = judgement.violations;
  for (const char* key : {"percent_above_0_5", "min_dihedral_deg"})
    out[key] = judgement.figures.value(key, json());
  return out;
}

void print_grade(const json& grade) {
  TextTable table({"measure", "value"}, "lr");
  const auto number = [&](const char* name, const char* key, double factor, const char* unit) {
    if (grade.contains(key) && grade.at(key).is_number())
      table.add({name, three_digits(factor * grade.at(key).get<double>()) + unit});
  };
  table.add({"vertices", grade.at("vertices_in").dump() + " -> " + grade.at("vertices").dump()});
  table.add({"tetrahedra", grade.at("tets_in").dump() + " -> " + grade.at("tets").dump()});
  number("wanted edge length, far", "far_m", 1000.0, " mm");
  number("... at its finest, over that", "least_wanted_size", 1.0, "");
  number("quality above 0.5", "percent_above_0_5", 1.0, "%");
  number("least dihedral angle", "min_dihedral_deg", 1.0, " degrees");
  number("pilot solve", "pilot_s", 1.0, " s");
  number("simplifier", "simplify_s", 1.0, " s");
  std::cout << table.text();
}

int grade(const GradeArguments& arguments) {
  const Registry registry = load_registry();
  const Stop stop = stop_of_grade(arguments);
  const GradeWish wish = wish_of_grade(arguments, registry);
  const MethodEntry method = grading_method(arguments, registry);
  const std::map<std::string, GivenOption> options = options_of_grade(arguments.set);
  const Scene scene = read_scene(arguments.scene);
  const fs::path out = arguments.out;
  std::error_code error;
  if (fs::exists(out, error) && !fs::is_empty(out, error))
    throw InputError(out.string(), 0, "a new or an empty folder", "one that holds something");
  std::optional<std::uint64_t> vertices;
  if (arguments.vertices > 0) vertices = arguments.vertices;
  const MadeMesh whole = build_scene_mesh(scene.mesh, vertices);
  for (const std::string& note : whole.notes) print_note(note);
  note_idle_sizes(arguments);
  const BoundaryProblem problem = problem_at_rest(scene, whole.mesh);
  std::vector<Vec3> probes = scene.dynamic.probes_m;  // those with names too
  if (!scene.is_dynamic) {
    probes.reserve(scene.probes.size());
    for (const SceneProbe& probe : scene.probes) probes.push_back(probe.place_m);
  }
  const ScratchFolder scratch;
  const GradedMesh graded =
      make_graded_mesh(wish, {whole.mesh, problem, probes}, method, options, stop,
                       {registry, scratch.path() / "pilot", arguments.threads, catch_stop_signals()});
  if (!graded.failure.empty()) throw UnavailableError(graded.failure);
  for (const std::string& note : graded.notes) print_note(note);
  json report = describe_grade(graded, whole.mesh, arguments);
  create_folder(out);
  const Scene placed = place_scene(scene, whole.mesh);
  json on_graded = placed_scene(placed, "organ.mesh");
  if (placed.whole == nullptr) on_graded["mesh"]["regions_from"] = "whole.mesh";
  on_graded.erase("envelope");
  write_medit(out / "organ.mesh", graded.mesh);
  write_medit(out / "whole.mesh", whole.mesh);
  simplify::write_sizes(out / "sizes.csv", graded.wanted.sizes);
  write_file_atomically(out / "scene.yaml",
                        "# Made by palpate grade: " + std::to_string(graded.mesh.tets.size()) +
                            " tetrahedra by " + arguments.method + "\n" + lines_of_scene(on_graded));
  const bool is_short = report.at("stop") == "limit";
  report["reached"] = !is_short;
  if (is_short) {
    const auto wanted = static_cast<double>(tets_after(stop, whole.mesh.tets.size()));
    report["shortfall"] =
        describe_shortfall(whole.mesh, graded.mesh, build_unpaired_faces(graded.mesh), wanted, graded.report);
    print_note(shortfall_text(report.at("shortfall")) +
               (arguments.method == "palpate.surface"
                    ? ". A larger max_surface_error_m may reach it"
                    : ". --method palpate.surface --set max_surface_error_m=METRES coarsens the skin too"));
  }
  write_file_atomically(out / "grade.json", report.dump(1) + "\n");
  for (const json& violation : report.at("violations")) print_note(violation.get<std::string>());
  if (arguments.as_json) {
    print_json(report);
  } else {
    print_grade(report);
    if (!is_short) std::cout << "Next: palpate simulate " << arguments.out << "/scene.yaml -o DIR\n";
  }
  return report.at("valid").get<bool>() && !is_short ? kDone : kNotAccepted;
}

void add_grade_sizes(CLI::App& command, GradeArguments& arguments) {
  command
      .add_option(
          "--near", arguments.near,
          "Where the mesh is to be fine, as often as needed: loads, pads, forces, supports or probes of the\n"
          "scene, \"sphere X Y Z R\" or \"half_space NX NY NZ OFFSET\" in metres")
      ->allow_extra_args(false)
      ->type_name("PLACE");
  command.add_option("--near-size", arguments.wish.near_size, "Edge length there over that far away (0.6)")
      ->check(number_from(0.01, 1.0))
      ->type_name("S");
  command.add_option("--radius", arguments.wish.radius_m, "Metres around a place that are as fine as it (0)")
      ->check(number_from(0.0, 1e3))
      ->type_name("M");
  command
      .add_option("--reach", arguments.reach_m,
                  "Metres from there to where edges have their full length (a quarter of the box's diagonal)")
      ->check(number_from(1e-9, 1e3))
      ->type_name("M");
  command
      .add_option(
          "--pilot", arguments.pilot,
          "Method of the contest deform that solves the scene first: the mesh is to be fine where it is\n"
          "in error, as far as neighbouring stresses tell")
      ->type_name("NAME");
  command
      .add_option("--least-size", arguments.wish.least_size,
                  "Edge length where the pilot is worst over that where it is best, at least (0.6)")
      ->check(number_from(0.01, 1.0))
      ->type_name("S");
  command
      .add_option("--growth", arguments.wish.growth,
                  "How much longer edges get over a distance of one wanted edge length (0.25)")
      ->check(number_from(0.01, 10.0))
      ->type_name("G");
}

}  // namespace

void add_grade_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<GradeArguments>();
  CLI::App* command = app.add_subcommand(
      "grade", "Make a scene's mesh coarse, everywhere alike or where the scene allows it");
  command->add_option("SCENE", arguments->scene, "Scene (.yaml)")->required();
  command->add_option("-o,--output", arguments->out, "Folder for mesh and scene: new or empty")
      ->required()
      ->type_name("DIR");
  command->add_option("--tets", arguments->tets, "Tetrahedra to be left at most")
      ->transform(whole_number_from(1, std::int64_t{1} << 40))
      ->type_name("N");
  command->add_option("--ratio", arguments->ratio, "Share of the tetrahedra to remove")
      ->check(number_from(0.0, 0.999999))
      ->type_name("R");
  command
      ->add_option("--vertices", arguments->vertices,
                   "Make or fill the scene's body with about so many first, in place of its own count")
      ->transform(whole_number_from(4, 100'000'000))
      ->type_name("N");
  add_grade_sizes(*command, *arguments);
  command
      ->add_option("--method", arguments->method,
                   "palpate.refined (keeps the skin) or palpate.surface (palpate.refined)")
      ->type_name("NAME");
  command->add_option("--set", arguments->set, "Option of the method, as often as needed")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  command->add_option("--threads", arguments->threads, "Threads that the pilot may use (1)")
      ->transform(whole_number_from(1, 1024))
      ->type_name("N");
  command->add_flag("--json", arguments->as_json, "Print grade.json");
  command->footer(
      "Writes organ.mesh (metres), scene.yaml on it, for simulate and fit, grade.json, and what it started "
      "from\n"
      "(whole.mesh, sizes.csv). Without --near and --pilot the mesh is of one size. A mesh is only made\n"
      "coarser: --vertices starts with a finer one. A moving scene is looked at at rest, its loads at their\n"
      "greatest. docs/graded.md has the formulas. Exit codes: 0 done;\n"
      "1 the count was not reached or the mesh is invalid; 2 bad input; 3 something needed could not run.");
  command->callback([arguments, command, &exit_code] {
    for (const char* flag : {"--near-size", "--radius", "--reach", "--least-size", "--growth"}) {
      if (command->count(flag) > 0) arguments->given.emplace_back(flag);
    }
    exit_code = grade(*arguments);
  });
}

}  // namespace palpate::experiments

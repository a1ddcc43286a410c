// make, mesh, quality.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <memory>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/files/output_file.h"
#include "experiments/judging/judge_record.h"
#include "experiments/meshes/mesh_source.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

struct MakeArguments {
  std::string source;  ///< a shape's name or a surface file
  std::string out;
  std::uint64_t vertices = 0;
  double edge_length = 0.0;
  std::uint64_t seed = 0;
  double jitter = -1.0;
  std::string skin = "coarse";
  bool normalize = false;
  bool repair = false;
  bool keeps_skin = false;  ///< a surface's, whatever mesh it gives
  bool as_json = false;
};

MeshSize size_of(const MakeArguments& arguments) {
  MeshSize size;
  if (arguments.vertices > 0) size.vertices = arguments.vertices;
  if (arguments.edge_length > 0.0) size.edge_length = arguments.edge_length;
  return size;
}

void print_table(const json& figures, std::initializer_list<std::pair<const char*, const char*>> rows) {
  TextTable table({"measure", "value"}, "lr");
  for (const auto& [key, name] : rows) {
    if (!figures.contains(key)) continue;
    const json& value = figures.at(key);
    std::string text = value.is_number() ? short_number(value.get<double>()) : value.dump();
    if (value.is_boolean()) text = value.get<bool>() ? "yes" : "no";
    if (value.is_null()) text = "none";
    table.add({name, text});
  }
  std::cout << table.text();
}

void print_findings(const std::vector<std::string>& findings) {
  for (const std::string& finding : findings)
    std::cout << colored("invalid: ", Color::kRed) << finding << '\n';
}

/// Where a skin that was kept as it is gives a poor mesh: what would give a better one.
std::string quality_hint(const json& figures) {
  constexpr double kGoodShare = 90.0;  // % of quality above 0.5
  constexpr double kGoodAngle = 5.0;   // degrees
  const double share = figures.value("percent_above_0_5", 100.0);
  const double angle = figures.value("min_dihedral_deg", 90.0);
  if (share >= kGoodShare && angle >= kGoodAngle) return "";
  const auto skin = figures.value("boundary_vertices", std::uint64_t{0});
  const auto step =
      static_cast<std::uint64_t>(std::pow(10.0, std::floor(std::log10(std::max(10.0, double(skin)))) - 1.0));
  const std::uint64_t fewer = skin / step * step;  // as many as the skin has: it cannot be kept
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "%.0f%% of the tetrahedra have a quality above 0.5, the least dihedral angle is %.1f degrees",
                share, angle);
  return text.data() +
         std::string(": the skin was kept as it is; --vertices N remakes it, with --vertices ") +
         std::to_string(std::max(kFewestVertices, fewer)) +
         " for one, where the body is thicker than an edge is long";
}

/// Normalises if asked, judges, writes and reports a mesh that was made. A made mesh has to be valid.
int deliver(MadeMesh made, const MakeArguments& arguments) {
  for (const std::string& note : made.notes) print_note(note);
  if (arguments.normalize) {
    const double factor = normalize_to_unit_box(made.mesh.points);
    print_note("lengths multiplied by " + short_number(factor) + " to fit [-1, 1]");
  }
  const Judgement judgement = judge_mesh(made.mesh);
  if (!judgement.violations.empty()) {
    throw UnavailableError("the mesh that was made is invalid: " + judgement.violations.front());
  }
  write_mesh(arguments.out, made.mesh);
  json figures = judgement.figures;
  const std::string hint = arguments.keeps_skin ? quality_hint(figures) : "";
  if (!hint.empty()) print_note(hint);
  figures["file"] = arguments.out;
  if (arguments.as_json) {
    print_json(figures);
    return kDone;
  }
  print_table(figures, {{"vertices", "vertices"},
                        {"edges", "edges"},
                        {"tets", "tetrahedra"},
                        {"boundary_vertices", "boundary vertices"},
                        {"euler", "V - E + F - T"},
                        {"volume", "volume"},
                        {"percent_above_0_5", "% of quality above 0.5"},
                        {"min_dihedral_deg", "least dihedral angle, deg"}});
  std::cout << "Written: " << arguments.out << '\n';
  return kDone;
}

int make(const MakeArguments& arguments) {
  check_output_file(arguments.out);
  ShapeRequest request;
  request.name = arguments.source;
  request.size = size_of(arguments);
  request.seed = arguments.seed;
  if (arguments.jitter >= 0.0) request.jitter = arguments.jitter;
  request.skin = kSkinKinds.parse(arguments.skin);
  return deliver(make_shape(request), arguments);
}

int mesh(MakeArguments arguments) {
  check_output_file(arguments.out);
  refuse_output_over_input("-o", arguments.out, {arguments.source});
  arguments.keeps_skin = arguments.vertices == 0;
  return deliver(mesh_surface({arguments.source, size_of(arguments), arguments.repair}), arguments);
}

void print_histogram(const json& histogram, double tets) {
  if (!histogram.is_array() || tets <= 0.0) return;
  constexpr double kBar = 40.0;
  TextTable table({"quality", "tets", "%", ""}, "lrrl");
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    const auto count = histogram[i].get<double>();
    const std::string range =
        "0." + std::to_string(i) + " - " + (i < 9 ? "0." + std::to_string(i + 1) : "1.0");
    table.add({range, short_number(count), short_number(std::round(1000.0 * count / tets) / 10.0),
               std::string(static_cast<std::size_t>(std::lround(kBar * count / tets)), '#')});
  }
  std::cout << '\n' << table.text();
}

int quality(const std::string& path, bool as_json, bool with_linear_elements) {
  MeditFile file = read_mesh(path, ReadOrientation::kKeep);
  Judgement judgement = judge_mesh(file.mesh);
  if (judgement.validity.inverted_tets == file.mesh.tets.size()) {
    for (Tet& tet : file.mesh.tets) std::swap(tet[2], tet[3]);
    file.notes.emplace_back("all tetrahedra were negatively oriented: positive orientation restored");
    judgement = judge_mesh(file.mesh);
  }
  for (const std::string& note : file.notes) print_note(note);
  if (with_linear_elements) add_linear_element_figures(judgement.figures, file.mesh);
  const int code = judgement.violations.empty() ? kDone : kNotAccepted;
  if (as_json) {
    print_json(judgement.figures);
    return code;
  }
  print_table(judgement.figures, {{"vertices", "vertices"},
                                  {"edges", "edges"},
                                  {"faces", "faces"},
                                  {"tets", "tetrahedra"},
                                  {"boundary_vertices", "boundary vertices"},
                                  {"components", "parts"},
                                  {"euler", "V - E + F - T"},
                                  {"volume", "volume"},
                                  {"inverted_tets", "inverted tetrahedra"},
                                  {"surface_self_intersections", "self-intersections of the skin"},
                                  {"percent_above_0_5", "% of quality above 0.5"},
                                  {"percent_above_0_6", "% of quality above 0.6"},
                                  {"mean_quality", "mean quality"},
                                  {"min_quality", "least quality"},
                                  {"min_dihedral_deg", "least dihedral angle, deg"},
                                  {"p1_dihedral_deg", "1st percentile of it, deg"},
                                  {"p5_dihedral_deg", "5th percentile of it, deg"},
                                  {"max_dihedral_deg", "greatest dihedral angle, deg"},
                                  {"p99_max_dihedral_deg", "99th percentile of it, deg"},
                                  {"mean_mean_ratio", "mean ratio, mean"},
                                  {"p5_mean_ratio", "mean ratio, 5th percentile"},
                                  {"mean_radius_ratio", "radius ratio, mean"},
                                  {"p5_radius_ratio", "radius ratio, 5th percentile"},
                                  {"mean_edge_ratio", "edge ratio, mean"},
                                  {"p5_edge_ratio", "edge ratio, 5th percentile"},
                                  {"p1_error", "error of linear elements"},
                                  {"p1_error_worst", "the same, worst field"},
                                  {"explicit_step", "longest explicit step"},
                                  {"stiffness_condition", "condition of the stiffness"},
                                  {"scaled_condition", "the same, scaled"},
                                  {"max_stiffness_eigenvalue", "greatest eigenvalue of the stiffness"},
                                  {"max_scaled_eigenvalue", "the same, scaled"}});
  print_histogram(judgement.figures.value("histogram", json()), judgement.figures.value("tets", 0.0));
  print_findings(judgement.violations);
  return code;
}

void add_size_options(CLI::App* command, const std::shared_ptr<MakeArguments>& arguments) {
  command->add_option("-o,--output", arguments->out, "Mesh to write (.mesh, .vtu)")
      ->required()
      ->type_name("FILE");
  auto* vertices = command->add_option("--vertices", arguments->vertices, "About so many vertices")
                       ->transform(whole_number_from(4, std::int64_t{1} << 29U))
                       ->type_name("N");
  command
      ->add_option("--edge-length", arguments->edge_length,
                   "Length of the inner edges, in the mesh's unit; not with --vertices")
      ->check(number_from(1e-9, 1e9))
      ->excludes(vertices)
      ->type_name("X");
  command->add_flag("--normalize", arguments->normalize, "Scale to the box [-1, 1]");
  command->add_flag("--json", arguments->as_json, "Print the figures as JSON");
}

}  // namespace

void add_make_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<MakeArguments>();
  CLI::App* command = app.add_subcommand("make", "Make a mesh: a real organ, another body or a built shape");
  command->add_option("SHAPE", arguments->source, "One of palpate list meshes")->required();
  add_size_options(command, arguments);
  command
      ->add_option("--seed", arguments->seed, "Another mesh of the same body; cube: seed of its jitter (0)")
      ->transform(whole_number_from(0, std::numeric_limits<std::int64_t>::max()))
      ->type_name("N");
  command
      ->add_option("--skin", arguments->skin,
                   "coarse (as it comes), fine, with edges as short as inside, or scanned, by marching cubes")
      ->check(CLI::IsMember(std::vector<std::string>(kSkinKinds.names.begin(), kSkinKinds.names.end())))
      ->type_name("HOW");
  command->add_option("--jitter", arguments->jitter, "cube: largest move of an inner vertex, in cells")
      ->check(number_from(0.0, 0.5))
      ->type_name("X");
  command->callback([arguments, &exit_code] { exit_code = make(*arguments); });
}

void add_mesh_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<MakeArguments>();
  CLI::App* command = app.add_subcommand("mesh", "Fill a closed surface with tetrahedra");
  command->add_option("SURFACE", arguments->source, "Closed surface (.stl, .off, .obj, .ply)")->required();
  add_size_options(command, arguments);
  command->add_flag("--repair", arguments->repair,
                    "Mend a surface that is open, inside out or intersects itself, and say what was changed");
  command->callback([arguments, &exit_code] { exit_code = mesh(*arguments); });
}

void add_quality_command(CLI::App& app, int& exit_code) {
  auto path = std::make_shared<std::string>();
  auto as_json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("quality", "Judge a mesh: validity, sizes, quality");
  command->add_option("MESH", *path, "Mesh to judge")->required();
  command->add_flag("--json", *as_json, "Print the figures as JSON");
  auto with_linear_elements = std::make_shared<bool>(false);
  command->add_flag("--linear-elements", *with_linear_elements,
                    "Also what the mesh is worth to linear finite elements (seconds at 100k tetrahedra)");
  command->callback([path, as_json, with_linear_elements, &exit_code] {
    exit_code = quality(*path, *as_json, *with_linear_elements);
  });
}

}  // namespace palpate::experiments

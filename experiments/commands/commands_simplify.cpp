// simplify: one mesh through the same door as in a plan.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <map>
#include <memory>
#include <optional>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/topology.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/simplify_shortfall.h"
#include "experiments/commands/usage.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/files/output_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/judging/judge_record.h"
#include "experiments/judging/kept_regions.h"
#include "experiments/judging/poor_skin.h"
#include "experiments/meshes/mesh_source.h"
#include "experiments/processes/bounded_work.h"
#include "experiments/registry/method_options.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// A remesher searches for the edge length with the wanted count, and may miss it by little: the count jumps.
constexpr double kFarAbove = 1.02;
constexpr std::int64_t kMostRemoved = std::int64_t{1} << 40;

struct SimplifyArguments {
  std::string mesh;
  std::string out;
  std::string method;
  std::int64_t fusions = -1;
  std::int64_t tets = -1;
  double ratio = -1.0;
  std::vector<std::string> set;
  std::vector<std::string> keep;
  double timeout_s = 3600.0;
  int threads = 1;
  bool as_json = false;
};

MethodEntry find_method(const Registry& registry, const std::string& name) {
  const auto entry = registry.find(name);
  if (!entry)
    throw InputError("--method: unknown method \"" + name + "\"" +
                     nearest_hint(name, registry.method_names()));
  if (entry->contestant->contest != "simplify") {
    throw InputError("--method: " + name + " is in the contest " + entry->contestant->contest +
                     ", not in simplify");
  }
  const std::string why = entry->contestant->unavailable();
  if (!why.empty()) throw UnavailableError(name + " is unavailable: " + why);
  return *entry;
}

std::vector<std::string> keep_of(const SimplifyArguments& arguments, const MethodSpec& method,
                                 const Registry& registry) {
  std::vector<std::string> keep;
  for (const std::string& region : arguments.keep) keep.push_back(parse_kept_region(region, "--keep"));
  if (!keep.empty() && !method.keeps)
    throw InputError("--keep: method " + method.name + " keeps no regions" + keeping_methods(registry));
  return keep;
}

/// Throws: InputError for a region that no tetrahedron of the input meets.
void check_regions_meet(const std::vector<std::string>& keep, const TetMesh& in) {
  for (const std::string& region : keep) {
    if (!meets_region(region, in))
      throw InputError("--keep", 0, "a region in the mesh's own coordinates that meets it",
                       "\"" + region + "\", which no tetrahedron meets");
  }
}

/// Says which tets had to stay. Returns whether they did.
bool report_kept(const std::vector<std::string>& keep, const TetMesh& in, const TetMesh& out, json& report) {
  if (keep.empty()) return true;
  const judge::RegionFigures kept = judge::compare_in_regions(out, in, judge_regions(keep));
  report["keep"] = keep;
  report["kept_tets"] = kept.input_tets;
  report["kept_tets_changed"] = kept.changed_tets;
  if (kept.changed_tets > 0)
    print_note(std::to_string(kept.changed_tets) + " tetrahedra that were to be kept are not in the output");
  return kept.changed_tets == 0;
}

/// Judges what the method wrote, in a child with bounds. Says what is wrong with it; returns whether it is
/// valid.
bool report_validity(const TetMesh& out, json& report) {
  const auto judge = [&out] {
    const Judgement judgement = judge_mesh(out);
    return json{{"figures", judgement.figures}, {"violations", judgement.violations}};
  };
  const WorkResult judged = run_bounded(judge, {});
  if (judged.end != WorkEnd::kDone) {
    report["valid"] = nullptr;
    print_note("the output was not judged: the judge " + judged.message);
    return false;
  }
  const json& figures = judged.value.at("figures");
  report["valid"] = figures.at("valid");
  for (const char* key : {"inverted_tets", "flat_tets", "findings"}) report[key] = figures.at(key);
  for (const json& violation : judged.value.at("violations"))
    print_note("the output is invalid: " + violation.get<std::string>());
  return judged.value.at("violations").empty();
}

Stop stop_of(const SimplifyArguments& arguments, const MethodSpec& method) {
  const int given = int{arguments.fusions >= 0} + int{arguments.tets >= 0} + int{arguments.ratio >= 0.0};
  if (given > 1) throw InputError("--fusions, --tets, --ratio", 0, "one stop", std::to_string(given));
  Stop stop;
  if (arguments.fusions >= 0) stop = {StopKind::kFusions, static_cast<double>(arguments.fusions), ""};
  if (arguments.tets >= 0) stop = {StopKind::kTets, static_cast<double>(arguments.tets), ""};
  if (arguments.ratio >= 0.0) stop = {StopKind::kRatio, arguments.ratio, ""};
  if (!method.takes_stop(stop_name(stop.kind))) {
    throw InputError(method.name + " cannot stop at " + stop_name(stop.kind) + ", only at " +
                     joined(method.stops));
  }
  return stop;
}

json parse_options(const MethodSpec& method, const std::vector<std::string>& settings) {
  std::map<std::string, GivenOption> given;
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0)
      throw InputError("--set", 0, "key=value", "\"" + setting + "\"");
    const std::string key = setting.substr(0, equals);
    if (!given.emplace(key, GivenOption{setting.substr(equals + 1), "--set"}).second) {
      throw InputError("--set: option \"" + key + "\" twice");
    }
  }
  return resolve_options(method, given);
}

/// The input, oriented and judged. Throws: InputError if the judge finds it invalid.
TetMesh read_valid_mesh(const std::string& path) {
  MeditFile file = read_mesh(path, ReadOrientation::kRestore);
  const std::string before = path + ": ";
  for (const std::string& note : file.notes) print_note(before + note);
  const Judgement judgement = judge_mesh(file.mesh);
  if (!judgement.violations.empty()) throw InputError(path, 0, "a valid mesh", judgement.violations.front());
  return std::move(file.mesh);
}

/// Names of the report's figures for people, in the order in which they are printed.
constexpr std::array<std::pair<const char*, const char*>, 23> kReportNames{{
    {"vertices_in", "vertices before"},
    {"vertices_out", "vertices after"},
    {"tets_in", "tetrahedra before"},
    {"tets_out", "tetrahedra after"},
    {"fusions", "fusions"},
    {"stop", "stopped at"},
    {"kernel_s", "time of the method"},
    {"inverted_tets", "inverted tetrahedra, by the judge"},
    {"kept_tets", "tetrahedra to keep"},
    {"kept_tets_changed", "of these, not in the output"},
    {"boundary", "not fused: on the boundary"},
    {"boundary_neighbour", "not fused: next to the boundary"},
    {"quality", "not fused: a neighbour would lose too much quality"},
    {"flip", "not fused: a neighbour would turn over"},
    {"touched", "not fused: moved by an earlier fusion"},
    {"kept", "not fused: in or next to a region to keep"},
    {"link", "not collapsed: inside, the topology would change"},
    {"shape", "not collapsed: inside, a tetrahedron would be too poor"},
    {"boundary_link", "not collapsed: in the skin, the topology would change"},
    {"boundary_shape", "not collapsed: in the skin, a tetrahedron would be too poor"},
    {"distance", "not collapsed: the skin would stray beyond the bound"},
    {"contact", "not collapsed: the skin would meet itself"},
    {"feature", "not collapsed: a sharp edge would be lost"},
}};

std::string name_of(const std::string& key) {
  const auto known = std::find_if(kReportNames.begin(), kReportNames.end(),
                                  [&](const auto& name) { return key == name.first; });
  return known == kReportNames.end() ? key : known->second;
}

void print_report(const json& report) {
  TextTable table({"measure", "value"}, "lr");
  for (const auto& [key, name] : kReportNames) {
    if (!report.contains(key)) continue;
    const json& value = report.at(key);
    if (std::string(key) == "fusions" && value == 0) continue;  // of what collapses edges
    std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    if (value.is_number()) text = short_number(value.get<double>());
    if (std::string(key) == "kernel_s") text = time_text(value.get<double>());
    table.add({name, text});
  }
  const json rejected = report.value("rejected", json::object());
  for (const auto& [reason, count] : rejected.items()) {
    if (count != 0) table.add({name_of(reason), count.dump()});
  }
  std::cout << table.text();
}

json full_report(const ContestantAnswer& answer, const std::string& method, const TetMesh& in,
                 const TetMesh& out) {
  json report = answer.report;
  report["method"] = method;
  report["kernel_s"] = *answer.kernel_s;
  report["wall_s"] = *answer.wall_s;
  report["peak_rss_bytes"] = *answer.peak_rss_bytes;
  report["vertices_in"] = in.points.size();
  report["tets_in"] = in.tets.size();
  report["vertices_out"] = out.points.size();
  report["tets_out"] = out.tets.size();
  if (!answer.tuned.empty()) {
    report["tuned"] = answer.tuned;
    report["searched"] = answer.searched;
  }
  return report;
}

int simplify(const SimplifyArguments& arguments) {
  const Registry registry = load_registry();
  const MethodEntry method = find_method(registry, arguments.method);
  ContestantTask task;
  task.method = method;
  task.options = parse_options(*method.method, arguments.set);
  task.stop = stop_of(arguments, *method.method);
  task.keep = keep_of(arguments, *method.method, registry);
  check_output_file(arguments.out);
  // By its own name the input may be replaced: that is what was asked for.
  if (arguments.out != arguments.mesh) refuse_output_over_input("-o", arguments.out, {arguments.mesh});
  const TetMesh in = read_valid_mesh(arguments.mesh);
  check_regions_meet(task.keep, in);
  const ScratchFolder scratch;
  task.scratch = scratch.path();
  task.mesh_in = scratch.file("in.mesh");
  write_medit(task.mesh_in, in);
  task.threads = arguments.threads;
  task.timeout_s = arguments.timeout_s;
  const ContestantAnswer answer = run_contestant(task);
  if (answer.outcome == "bad_input") throw InputError(arguments.method + ": " + answer.message);
  if (answer.outcome != "ok") {
    throw UnavailableError(arguments.method + ": " + answer.outcome + ": " + answer.message);
  }
  TetMesh out;
  try {
    out = read_medit(answer.output, ReadOrientation::kKeep).mesh;
  } catch (const InputError& error) {
    throw UnavailableError(arguments.method + ": its mesh cannot be read: " + error.what());
  }
  write_mesh(arguments.out, out);
  for (const std::string& note : answer.notes) print_note(note);
  json report = full_report(answer, arguments.method, in, out);
  const bool is_valid = report_validity(out, report);
  const bool kept = report_kept(task.keep, in, out, report);
  const std::optional<double> wanted = wanted_tets(in, task.stop);
  const bool is_at_limit = report.value("stop", "") == "limit";
  const bool is_far = wanted && static_cast<double>(out.tets.size()) > kFarAbove * *wanted;
  const bool is_short = task.stop.kind != StopKind::kLimit && (is_at_limit || is_far);
  const std::vector<Triangle> skin = build_unpaired_faces(out);
  const bool is_above = wanted && *wanted < static_cast<double>(out.tets.size());
  if (is_short && is_above) {
    report["stop"] = "limit";  // whatever else it says of itself
    json shortfall = describe_shortfall(in, out, skin, *wanted, report);
    find_way_out(task, in, registry, shortfall);
    report["shortfall"] = shortfall;
    print_note(shortfall_text(shortfall));
  } else if (is_above) {
    print_note(std::to_string(out.tets.size()) + " tetrahedra are left, and at most " +
               short_number(*wanted) + " were asked for: " + arguments.method + " comes no closer");
  } else if (is_short && answer.notes.empty()) {
    print_note("stopped early, at the method's limit, with " + std::to_string(out.tets.size()) +
               " tetrahedra left");
  }
  const std::string dense = is_short ? "" : skin_hint(in, out, skin, arguments.method);
  if (!dense.empty()) print_note(dense);
  const json poor = describe_poor_skin(out, skin);
  if (!poor.is_null()) {
    report["poor_skin"] = poor;
    print_note(poor_skin_text(poor));
  }
  if (out.tets.size() == in.tets.size() && answer.notes.empty())
    print_note("nothing was removed: the output is the input");
  if (arguments.as_json) {
    print_json(report);
  } else {
    print_report(report);
    std::cout << "Written: " << arguments.out << '\n';
  }
  const bool is_reached = !report.contains("shortfall");
  return kept && is_valid && is_reached ? kDone : kNotAccepted;
}

}  // namespace

void add_simplify_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SimplifyArguments>();
  CLI::App* command = app.add_subcommand("simplify", "Simplify one mesh with one method");
  command->add_option("MESH", arguments->mesh, "Mesh to simplify")->required();
  command->add_option("-o,--output", arguments->out, "Mesh to write (.mesh, .vtu)")
      ->required()
      ->type_name("FILE");
  command->add_option("--method", arguments->method, "One of palpate list contestants")
      ->required()
      ->type_name("NAME");
  command->add_option("--fusions", arguments->fusions, "Stop after so many fusions")
      ->transform(whole_number_from(0, kMostRemoved))
      ->type_name("N");
  command->add_option("--tets", arguments->tets, "Stop at the first state with at most so many tetrahedra")
      ->transform(whole_number_from(1, kMostRemoved))
      ->type_name("N");
  command->add_option("--ratio", arguments->ratio, "Stop when this share of the tetrahedra is removed")
      ->check(number_from(0.0, 0.999999))
      ->type_name("R");
  command->add_option("--set", arguments->set, "Option of the method, as often as needed")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  command
      ->add_option("--keep", arguments->keep, "Region whose tetrahedra stay as they are, as often as needed")
      ->allow_extra_args(false)
      ->type_name("REGION");
  command->add_option("--timeout", arguments->timeout_s, "Seconds before the method is stopped (3600)")
      ->check(number_from(0.01, 1e7))
      ->type_name("S");
  command->add_option("--threads", arguments->threads, "Threads that the method may use (1)")
      ->transform(whole_number_from(1, 1024))
      ->type_name("N");
  command->footer(
      "Without a stop, a method that has a limit runs to it; others (palpate list contestants) need one.\n"
      "The judge looks at what was written: an invalid mesh is said, and the exit code is 1. So is a count\n"
      "that was not reached: what held it, and which method reaches it, with which bound.\n\n"
      "Regions to keep, in the mesh's own coordinates (palpate list meshes names the units of what palpate "
      "make\n"
      "writes: kidney and liver mm, bean cm):\n"
      "  \"sphere X Y Z R\"               the ball of radius R around a point\n"
      "  \"half_space NX NY NZ OFFSET\"   all x with N . x <= OFFSET\n"
      "  \"patch X Y Z R DEPTH\"          all within DEPTH of the skin's faces that have a vertex in the "
      "ball\n"
      "Around a region, edge lengths grow smoothly from a share of the full ones (--set near_size=0.5) to "
      "all of\n"
      "them (--set reach=DISTANCE; 0 stands for a quarter of the bounding box's diagonal).");
  command->add_flag("--json", arguments->as_json, "Print the report as JSON");
  command->callback([arguments, &exit_code] { exit_code = simplify(*arguments); });
}

}  // namespace palpate::experiments

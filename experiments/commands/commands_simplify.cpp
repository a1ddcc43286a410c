// simplify: one mesh through the same door as in a plan.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <map>
#include <memory>
#include <optional>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/files/output_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/judging/judge_record.h"
#include "experiments/judging/kept_regions.h"
#include "experiments/meshes/mesh_source.h"
#include "experiments/processes/bounded_work.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

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

/// Says which tets had to stay. Returns whether they did.
bool report_kept(const std::vector<std::string>& keep, const TetMesh& in, const TetMesh& out, json& report) {
  if (keep.empty()) return true;
  const judge::RegionFigures kept = judge::compare_in_regions(out, in, judge_regions(keep));
  report["keep"] = keep;
  report["kept_tets"] = kept.input_tets;
  report["kept_tets_changed"] = kept.changed_tets;
  if (kept.input_tets == 0)
    print_note("no tetrahedron meets a region to keep (regions are in the mesh's own coordinates)");
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
constexpr std::array<std::pair<const char*, const char*>, 16> kReportNames{{
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

/// Share of the tets that have a vertex on the skin.
double share_at_skin(const TetMesh& mesh, const std::vector<Triangle>& skin) {
  std::vector<std::uint8_t> is_on_skin(mesh.points.size(), 0);
  for (const Triangle& face : skin) {
    for (const Index v : face) is_on_skin[v] = 1;
  }
  const auto touching = std::count_if(mesh.tets.begin(), mesh.tets.end(), [&](const Tet& tet) {
    return std::any_of(tet.begin(), tet.end(), [&](Index v) { return is_on_skin[v] != 0; });
  });
  return static_cast<double>(touching) / static_cast<double>(mesh.tets.size());
}

constexpr const char* kCoarsensSkin = "palpate.surface";

/// Where a skin that was left as it is keeps the mesh from what was asked for: what would coarsen it too.
std::string skin_hint(const TetMesh& in, const TetMesh& out, const std::string& method) {
  // Of the tets, at the skin. A kidney by palpate.refined: 68% there with 99.8% of all above a quality of 0.5
  // (coarse skin, 70% removed), 76% there with 70% (fine skin, 40% removed), 85% with 51% (50%).
  constexpr double kDense = 0.75;
  if (method == kCoarsensSkin || out.tets.empty() || out.tets.size() == in.tets.size()) return "";
  const std::vector<Triangle> skin = build_unpaired_faces(out);
  if (skin.size() != build_unpaired_faces(in).size()) return "";
  const double share = share_at_skin(out, skin);
  if (share < kDense) return "";
  return method + " leaves the skin as dense as it was: " + std::to_string(std::lround(100.0 * share)) +
         "% of the tetrahedra that are left touch it; --method " + kCoarsensSkin +
         " coarsens skin and inside together";
}

/// The most tets that may be left at a stop by count or by ratio; nothing for other stops.
std::optional<double> wanted_tets(const TetMesh& in, const Stop& stop) {
  if (stop.kind == StopKind::kTets) return stop.value;
  if (stop.kind != StopKind::kRatio) return std::nullopt;
  return std::max(1.0, std::floor(static_cast<double>(in.tets.size()) * (1.0 - stop.value)));
}

/// How far a run came that has not reached its count, and what stood in its way.
json describe_shortfall(const TetMesh& in, const TetMesh& out, double wanted, const json& report) {
  const std::vector<Triangle> skin = build_unpaired_faces(out);
  return {{"wanted_tets", wanted},
          {"reached_tets", out.tets.size()},
          {"skin_faces", skin.size()},
          {"skin_kept", skin.size() == build_unpaired_faces(in).size()},
          {"share_at_skin", out.tets.empty() ? 0.0 : share_at_skin(out, skin)},
          {"kept_tets", report.value("kept_tets", 0)},
          {"rejected", report.value("rejected", json::object())},
          {"way_out", nullptr}};
}

/// The least of some distances, in the mesh's unit, with which palpate.surface reaches the count; null if
/// none does. What was tried is in "tried_bounds".
void find_way_out(const ContestantTask& failed, const TetMesh& in, const Registry& registry,
                  json& shortfall) {
  constexpr std::array kShares{0.0025, 0.005, 0.01, 0.02, 0.04};  // of the box's diagonal
  constexpr std::size_t kMostTets = 200'000;                      // some seconds a try
  constexpr double kMostSeconds = 60.0;
  const auto entry = registry.find(kCoarsensSkin);
  if (failed.method.method->name == kCoarsensSkin || in.tets.size() > kMostTets) return;
  if (!entry || !entry->contestant->unavailable().empty()) return;
  const BoundingBox box = bounding_box(in.points);
  shortfall["tried_bounds"] = json::array();
  for (const double share : kShares) {
    const ScratchFolder scratch;
    ContestantTask task = failed;
    task.method = *entry;
    task.scratch = scratch.path();
    task.timeout_s = kMostSeconds;
    const double bound = share * length(box.high - box.low);
    task.options = resolve_options(*entry->method, {});
    task.options["max_surface_error_m"] = bound;
    const ContestantAnswer answer = run_contestant(task);
    shortfall["tried_bounds"].push_back(bound);
    if (answer.outcome != "ok" || answer.report.value("stop", "limit") == "limit") continue;
    shortfall["way_out"] = {{"method", kCoarsensSkin}, {"bound", bound}};
    return;
  }
}

std::string shortfall_text(const json& shortfall) {
  std::string text = "the count was not reached: " + shortfall.at("reached_tets").dump() + " of " +
                     short_number(shortfall.at("wanted_tets").get<double>()) + " tetrahedra are left. ";
  text += std::to_string(std::lround(100.0 * shortfall.at("share_at_skin").get<double>())) +
          "% of them touch the skin of " + shortfall.at("skin_faces").dump() + " faces" +
          (shortfall.at("skin_kept").get<bool>() ? ", which was kept" : "");
  if (shortfall.at("kept_tets") != 0)
    text += "; " + shortfall.at("kept_tets").dump() + " lie in regions to keep";
  std::string refused;
  for (const auto& [reason, count] : shortfall.at("rejected").items()) {
    if (count != 0) refused += (refused.empty() ? "" : ", ") + reason + " " + count.dump();
  }
  if (!refused.empty()) text += "; operations refused: " + refused;
  const json& way = shortfall.at("way_out");
  if (!way.is_null())
    return text + ". --method palpate.surface --set max_surface_error_m=" +
           three_digits(way.at("bound").get<double>()) + " reaches it (a distance in the mesh's unit)";
  const json tried = shortfall.value("tried_bounds", json::array());
  if (tried.empty()) return text;
  return text + ". palpate.surface does not reach it either within " +
         three_digits(tried.back().get<double>()) + " of the skin";
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
  const TetMesh in = read_valid_mesh(arguments.mesh);
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
  const bool is_short = task.stop.kind != StopKind::kLimit && report.value("stop", "") == "limit";
  const std::optional<double> wanted = wanted_tets(in, task.stop);
  if (is_short && wanted && *wanted < static_cast<double>(out.tets.size())) {
    json shortfall = describe_shortfall(in, out, *wanted, report);
    find_way_out(task, in, registry, shortfall);
    report["shortfall"] = shortfall;
    print_note(shortfall_text(shortfall));
  } else if (is_short && answer.notes.empty()) {
    print_note("stopped early, at the method's limit, with " + std::to_string(out.tets.size()) +
               " tetrahedra left");
  }
  const std::string dense = is_short ? "" : skin_hint(in, out, arguments.method);
  if (!dense.empty()) print_note(dense);
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
      ->check(whole_number_from(0, kMostRemoved))
      ->type_name("N");
  command->add_option("--tets", arguments->tets, "Stop at the first state with at most so many tetrahedra")
      ->check(whole_number_from(1, kMostRemoved))
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
      ->check(whole_number_from(1, 1024))
      ->type_name("N");
  command->footer(
      "Without a stop, the method runs to its limit. The judge looks at what was written: an invalid mesh is "
      "said, and\n"
      "the exit code is 1. So is a count that was not reached: what held it, and the bound with which\n"
      "palpate.surface reaches it.\n\n"
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

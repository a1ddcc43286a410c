#include "experiments/commands/simplify_shortfall.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/grading/graded_mesh.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr const char* kCoarsensSkin = "palpate.surface";
constexpr const char* kKeepsSkin = "palpate.refined";

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

}  // namespace

std::string skin_hint(const TetMesh& in, const TetMesh& out, const std::vector<Triangle>& skin,
                      const std::string& method) {
  // Of the tets, at the skin. A kidney by palpate.refined: 68% there with 99.8% of all above a quality of 0.5
  // (coarse skin, 70% removed), 76% there with 70% (fine skin, 40% removed), 85% with 51% (50%).
  constexpr double kDense = 0.75;
  if (method == kCoarsensSkin || out.tets.empty() || out.tets.size() == in.tets.size()) return "";
  if (skin.size() != build_unpaired_faces(in).size()) return "";
  const double share = share_at_skin(out, skin);
  if (share < kDense) return "";
  return method + " leaves the skin as dense as it was: " + std::to_string(std::lround(100.0 * share)) +
         "% of the tetrahedra that are left touch it; --method " + kCoarsensSkin +
         " coarsens skin and inside together";
}

std::optional<double> wanted_tets(const TetMesh& in, const Stop& stop) {
  if (stop.kind != StopKind::kTets && stop.kind != StopKind::kRatio) return std::nullopt;
  return static_cast<double>(tets_after(stop, in.tets.size()));
}

json describe_shortfall(const TetMesh& in, const TetMesh& out, const std::vector<Triangle>& skin,
                        double wanted, const json& report) {
  return {{"wanted_tets", wanted},
          {"reached_tets", out.tets.size()},
          {"skin_faces", skin.size()},
          {"skin_kept", skin.size() == build_unpaired_faces(in).size()},
          {"share_at_skin", out.tets.empty() ? 0.0 : share_at_skin(out, skin)},
          {"kept_tets", report.value("kept_tets", 0)},
          {"rejected", report.value("rejected", json::object())},
          {"way_out", nullptr}};
}

namespace {

/// Runs a failed task by another method. Returns whether that reaches the count.
bool reaches(const ContestantTask& failed, const MethodEntry& method, json options) {
  constexpr double kMostSeconds = 60.0;
  const ScratchFolder scratch;
  ContestantTask task = failed;
  task.method = method;
  task.scratch = scratch.path();
  task.timeout_s = kMostSeconds;
  task.options = std::move(options);
  const ContestantAnswer answer = run_contestant(task);
  return answer.outcome == "ok" && answer.report.value("stop", "limit") != "limit";
}

/// The entry of a method that can be run here.
std::optional<MethodEntry> find_available(const Registry& registry, const char* name) {
  auto entry = registry.find(name);
  if (!entry || !entry->contestant->unavailable().empty()) return std::nullopt;
  return *entry;
}

/// The bounds to try, the least first, in metres as the option has them: each is the number that is printed.
/// What failed is left out. Smaller ones than that are tried too: which counts are reached does not grow with
/// the bound everywhere.
std::vector<double> bounds_to_try(const TetMesh& in, const json& options, bool is_own) {
  constexpr std::array kShares{0.0, 0.0025, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16};  // of the box's diagonal
  const BoundingBox box = bounding_box(in.points);
  const double diagonal_m = options.value("unit_m", 1.0) * length(box.high - box.low);
  std::vector<double> bounds;
  for (const double share : kShares) {
    const double bound = std::stod(three_digits(share * diagonal_m));
    if (!is_own || bound != options.value("max_surface_error_m", 0.0)) bounds.push_back(bound);
  }
  return bounds;
}

}  // namespace

void find_way_out(const ContestantTask& failed, const TetMesh& in, const Registry& registry,
                  json& shortfall) {
  constexpr std::size_t kMostTets = 200'000;  // some seconds a try
  constexpr double kMostSeconds = 60.0;       // for all; the try that is on then is the last
  const double wanted = shortfall.at("wanted_tets").get<double>();
  if (in.tets.size() > kMostTets || shortfall.at("kept_tets").get<double>() > wanted) return;
  const std::string& own = failed.method.method->name;
  const auto inside = find_available(registry, kKeepsSkin);
  if (inside && own != kKeepsSkin && own != kCoarsensSkin &&
      reaches(failed, *inside, resolve_options(*inside->method, {}))) {
    shortfall["way_out"] = {{"method", kKeepsSkin}, {"bound", nullptr}};
    return;
  }
  const auto surface = find_available(registry, kCoarsensSkin);
  if (!surface) return;
  const bool is_own = own == kCoarsensSkin;
  json options = is_own ? failed.options : resolve_options(*surface->method, {});
  shortfall["tried_bounds"] = json::array();
  const Stopwatch watch;
  for (const double bound : bounds_to_try(in, options, is_own)) {
    if (watch.seconds() > kMostSeconds) return;
    options["max_surface_error_m"] = bound;
    shortfall["tried_bounds"].push_back(bound);
    if (!reaches(failed, *surface, options)) continue;
    shortfall["way_out"] = {{"method", kCoarsensSkin}, {"bound", bound}};
    return;
  }
}

std::string shortfall_text(const json& shortfall) {
  std::string text = "the count was not reached: " + shortfall.at("reached_tets").dump() +
                     " tetrahedra are left, and at most " +
                     short_number(shortfall.at("wanted_tets").get<double>()) + " were asked for. ";
  text += std::to_string(std::lround(100.0 * shortfall.at("share_at_skin").get<double>())) +
          "% of them touch the skin of " + shortfall.at("skin_faces").dump() + " faces" +
          (shortfall.at("skin_kept").get<bool>() ? ", which was kept" : "");
  if (shortfall.at("kept_tets") != 0)
    text += "; " + shortfall.at("kept_tets").dump() + " lie in regions to keep";
  if (shortfall.at("kept_tets").get<double>() > shortfall.at("wanted_tets").get<double>())
    text += ", which is more than that, so nothing gets there";
  std::string refused;
  for (const auto& [reason, count] : shortfall.at("rejected").items()) {
    if (count != 0) refused += (refused.empty() ? "" : ", ") + reason + " " + count.dump();
  }
  if (!refused.empty()) text += "; operations refused: " + refused;
  const json& way = shortfall.at("way_out");
  if (!way.is_null()) {
    text += ". --method " + way.at("method").get<std::string>();
    if (way.at("bound").is_null()) return text + " reaches it, with the skin as it is";
    return text + " --set max_surface_error_m=" + three_digits(way.at("bound").get<double>()) +
           " reaches it (a distance in the mesh's unit; in metres where unit_m says what that is)";
  }
  const json tried = shortfall.value("tried_bounds", json::array());
  if (tried.empty()) return text;
  return text + ". " + kCoarsensSkin + " does not reach it within " +
         three_digits(tried.back().get<double>()) +
         " of the skin either, nor within smaller bounds that were tried";
}

}  // namespace palpate::experiments

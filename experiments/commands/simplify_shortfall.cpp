#include "experiments/commands/simplify_shortfall.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "experiments/files/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr const char* kCoarsensSkin = "palpate.surface";

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

std::optional<double> wanted_tets(const TetMesh& in, const Stop& stop) {
  if (stop.kind == StopKind::kTets) return stop.value;
  if (stop.kind != StopKind::kRatio) return std::nullopt;
  return std::max(1.0, std::floor(static_cast<double>(in.tets.size()) * (1.0 - stop.value)));
}

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

}  // namespace palpate::experiments

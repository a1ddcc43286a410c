#include "experiments/commands/simplify_shortfall.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "experiments/files/scratch_folder.h"

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
std::vector<double> bounds_to_try(const TetMesh& in, const json& options) {
  constexpr std::array kShares{0.0025, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16};  // of the box's diagonal
  const BoundingBox box = bounding_box(in.points);
  const double diagonal_m = options.value("unit_m", 1.0) * length(box.high - box.low);
  const double failed = options.value("max_surface_error_m", 0.0);
  std::vector<double> bounds;
  for (const double share : kShares) {
    const double bound = std::stod(three_digits(share * diagonal_m));
    if (bound > failed) bounds.push_back(bound);
  }
  return bounds;
}

}  // namespace

void find_way_out(const ContestantTask& failed, const TetMesh& in, const Registry& registry,
                  json& shortfall) {
  constexpr std::size_t kMostTets = 200'000;  // some seconds a try
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
  json options = own == kCoarsensSkin ? failed.options : resolve_options(*surface->method, {});
  const std::vector<double> bounds = bounds_to_try(in, options);
  shortfall["tried_bounds"] = json::array();
  const auto is_enough = [&](double bound) {
    options["max_surface_error_m"] = bound;
    shortfall["tried_bounds"].push_back(bound);
    return reaches(failed, *surface, options);
  };
  if (bounds.empty() || !is_enough(bounds.back())) return;
  std::size_t missed = 0;  // as many, from the least on, are taken for too small
  std::size_t found = bounds.size() - 1;
  while (missed < found) {
    const std::size_t middle = (missed + found) / 2;
    if (is_enough(bounds[middle])) {
      found = middle;
    } else {
      missed = middle + 1;
    }
  }
  shortfall["way_out"] = {{"method", kCoarsensSkin}, {"bound", bounds[found]}};
}

namespace {

constexpr double kBestMeanRatio = 0.3;  // of a tet on a face that is named
constexpr double kLeastAngleDeg = 10.0;
constexpr std::size_t kMostNamed = 10;

/// Something of the skin, and how bad it is: the less, the worse.
struct PoorPart {
  double value = 0.0;
  std::vector<Index> vertices;

  bool operator<(const PoorPart& other) const {
    return std::tie(value, vertices) < std::tie(other.value, other.vertices);
  }
};

/// The mean ratio of the best tet on a triangle.
double best_mean_ratio(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double area = 0.5 * length(cross(b - a, c - a));
  const double squares = length_sq(b - a) + length_sq(c - b) + length_sq(a - c);
  if (!(squares > 0.0)) return 0.0;
  return std::pow(12.0 * area / (std::sqrt(3.0) * squares), 2.0 / 3.0);
}

/// The angle inside, in degrees, at the edge (a, b) of the outside face (a, b, c), whose other face has d.
double inner_angle_deg(const TetMesh& mesh, Index a, Index b, Index c, Index d) {
  constexpr double kHalfTurnDeg = 180.0;
  const Vec3 edge = mesh.points[b] - mesh.points[a];
  const Vec3 one = cross(edge, mesh.points[c] - mesh.points[a]);
  const Vec3 other = cross(mesh.points[d] - mesh.points[a], edge);
  const double turn = std::atan2(length(cross(one, other)), dot(one, other)) * kHalfTurnDeg / std::acos(-1.0);
  return dot(one, mesh.points[d] - mesh.points[a]) < 0.0 ? kHalfTurnDeg - turn : kHalfTurnDeg + turn;
}

std::vector<PoorPart> poor_faces(const TetMesh& mesh, const std::vector<Triangle>& skin) {
  std::vector<PoorPart> poor;
  for (const Triangle& f : skin) {
    const double best = best_mean_ratio(mesh.points[f[0]], mesh.points[f[1]], mesh.points[f[2]]);
    if (best < kBestMeanRatio) poor.push_back({best, {f.begin(), f.end()}});
  }
  std::sort(poor.begin(), poor.end());
  return poor;
}

std::vector<PoorPart> poor_edges(const TetMesh& mesh, const std::vector<Triangle>& skin) {
  std::map<std::pair<Index, Index>, Index> opposite;  // of each edge of a face, as the face has it
  for (const Triangle& f : skin) {
    for (std::size_t k = 0; k < 3; ++k) opposite[{f[k], f[(k + 1) % 3]}] = f[(k + 2) % 3];
  }
  std::vector<PoorPart> poor;
  for (const auto& [edge, c] : opposite) {
    const auto other = opposite.find({edge.second, edge.first});
    if (edge.first > edge.second || other == opposite.end()) continue;
    const double angle = inner_angle_deg(mesh, edge.first, edge.second, c, other->second);
    if (angle < kLeastAngleDeg) poor.push_back({angle, {edge.first, edge.second}});
  }
  std::sort(poor.begin(), poor.end());
  return poor;
}

json describe_parts(const TetMesh& mesh, const std::vector<PoorPart>& parts, const char* value) {
  json named = json::array();
  for (std::size_t i = 0; i < std::min(parts.size(), kMostNamed); ++i) {
    json numbers = json::array();
    Vec3 middle{};
    for (const Index v : parts[i].vertices) {
      numbers.push_back(v + 1);
      middle = middle + (1.0 / static_cast<double>(parts[i].vertices.size())) * mesh.points[v];
    }
    named.push_back({{"vertices", numbers}, {"at", {middle.x, middle.y, middle.z}}, {value, parts[i].value}});
  }
  return {{"count", parts.size()}, {"worst", named}};
}

/// "vertices 3, 17 and 90, near (1.2, 3, 4)", of the worst.
std::string place_text(const json& parts) {
  const json& worst = parts.at("worst").front();
  std::string text = "vertices ";
  const json& vertices = worst.at("vertices");
  for (std::size_t k = 0; k < vertices.size(); ++k)
    text += (k == 0 ? "" : k + 1 == vertices.size() ? " and " : ", ") + vertices[k].dump();
  text += ", near (";
  for (std::size_t k = 0; k < 3; ++k)
    text += (k == 0 ? "" : ", ") + three_digits(worst.at("at")[k].get<double>());
  return text + ")";
}

}  // namespace

json describe_poor_skin(const TetMesh& mesh) {
  const std::vector<Triangle> skin = build_unpaired_faces(mesh);
  const std::vector<PoorPart> faces = poor_faces(mesh, skin);
  const std::vector<PoorPart> edges = poor_edges(mesh, skin);
  if (faces.empty() && edges.empty()) return nullptr;
  return {{"skin_faces", skin.size()},
          {"best_mean_ratio", kBestMeanRatio},
          {"least_angle_deg", kLeastAngleDeg},
          {"faces", describe_parts(mesh, faces, "mean_ratio")},
          {"edges", describe_parts(mesh, edges, "angle_deg")}};
}

std::string poor_skin_text(const json& skin) {
  const json& faces = skin.at("faces");
  const json& edges = skin.at("edges");
  std::string text = "the skin itself is poor, and no inside makes up for it: ";
  if (faces.at("count") != 0)
    text += "on " + faces.at("count").dump() + " of its " + skin.at("skin_faces").dump() +
            " faces no tetrahedron has a mean ratio above " +
            short_number(skin.at("best_mean_ratio").get<double>()) + " (on the worst, " + place_text(faces) +
            ", none above " + three_digits(faces.at("worst").front().at("mean_ratio").get<double>()) + ")";
  if (faces.at("count") != 0 && edges.at("count") != 0) text += "; ";
  if (edges.at("count") != 0)
    text += "at " + edges.at("count").dump() + " edges its faces meet at less than " +
            short_number(skin.at("least_angle_deg").get<double>()) + " degrees inside (the sharpest, " +
            place_text(edges) + ": " + three_digits(edges.at("worst").front().at("angle_deg").get<double>()) +
            ")";
  return text;
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
  std::string refused;
  for (const auto& [reason, count] : shortfall.at("rejected").items()) {
    if (count != 0) refused += (refused.empty() ? "" : ", ") + reason + " " + count.dump();
  }
  if (!refused.empty()) text += "; operations refused: " + refused;
  const json& way = shortfall.at("way_out");
  if (!way.is_null() && way.at("bound").is_null())
    return text + ". --method " + way.at("method").get<std::string>() + " reaches it, with the skin as it is";
  if (!way.is_null())
    return text + ". --method " + kCoarsensSkin +
           " --set max_surface_error_m=" + three_digits(way.at("bound").get<double>()) +
           " reaches it (a distance in the mesh's unit; in metres where unit_m says what that is)";
  const json tried = shortfall.value("tried_bounds", json::array());
  if (tried.empty()) return text;
  return text + ". " + kCoarsensSkin + " does not reach it within " +
         three_digits(tried.front().get<double>()) + " of the skin either";
}

}  // namespace palpate::experiments

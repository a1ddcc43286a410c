#include "experiments/judging/poor_skin.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include "core/base/number_text.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

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
  const double turn =
      std::atan2(length(cross(one, other)), dot(one, other)) * kHalfTurnDeg / std::numbers::pi;
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

json describe_poor_skin(const TetMesh& mesh, const std::vector<Triangle>& skin) {
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

}  // namespace palpate::experiments

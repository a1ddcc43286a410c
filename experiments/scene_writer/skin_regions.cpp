#include "experiments/scene_writer/skin_regions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "experiments/scene_reader/scene_problem.h"

namespace palpate::experiments {
namespace {

constexpr double kRestingArea = 0.2;  // of the skin
constexpr double kPadArea = 0.04;

/// The skin, face by face.
struct SkinFace {
  Triangle corners{};
  Vec3 area;  ///< outward, its length is the area
  Vec3 centroid;
};

std::vector<SkinFace> read_skin(const TetMesh& mesh) {
  std::vector<SkinFace> skin;
  for (const Triangle& t : build_boundary(mesh)) {
    const Vec3& a = mesh.points[t[0]];
    const Vec3& b = mesh.points[t[1]];
    const Vec3& c = mesh.points[t[2]];
    skin.push_back({t, 0.5 * cross(b - a, c - a), (1.0 / 3.0) * (a + b + c)});
  }
  return skin;
}

double skin_area(const std::vector<SkinFace>& skin) {
  double area = 0.0;
  for (const SkinFace& face : skin) area += length(face.area);
  return area;
}

double mean_skin_edge(const std::vector<SkinFace>& skin, const TetMesh& mesh) {
  double sum = 0.0;
  for (const SkinFace& face : skin) {
    for (std::size_t k = 0; k < 3; ++k)
      sum += length(mesh.points[face.corners[k]] - mesh.points[face.corners[(k + 1) % 3]]);
  }
  return sum / (3.0 * static_cast<double>(skin.size()));
}

/// What a region takes hold of, by the code that puts every scene on its mesh.
FacePatch take_hold(const Region& region, const TetMesh& mesh) {
  Scene scene;
  SceneClamp clamp;
  clamp.region = region;
  clamp.elastic_pa_per_m = 1.0;
  scene.clamps.push_back(clamp);
  return resolve_problem(place_scene(scene, mesh), mesh).supports.front().patch;
}

Vec3 area_vector_of(const TetMesh& mesh, const Triangle& t) {
  const Vec3& a = mesh.points[t[0]];
  return 0.5 * cross(mesh.points[t[1]] - a, mesh.points[t[2]] - a);
}

double skin_area(const FacePatch& patch, const TetMesh& mesh) {
  double area = 0.0;
  for (std::size_t i = 0; i < patch.faces.size(); ++i)
    area += patch.weight[i] * length(area_vector_of(mesh, patch.faces[i]));
  return area;
}

Vec3 mean_normal(const FacePatch& patch, const TetMesh& mesh) {
  Vec3 sum;
  for (std::size_t i = 0; i < patch.faces.size(); ++i)
    sum = sum + patch.weight[i] * area_vector_of(mesh, patch.faces[i]);
  const double size = length(sum);
  if (!(size > 1e-9 * skin_area(patch, mesh)))
    throw InputError("the pad on top", 0, "a part of the skin that has a front",
                     "the whole of it: its faces are as long as the body; finer ones have room for a pad");
  return (1.0 / size) * sum;
}

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double size() const { return high - low; }
};

Region sphere_at(const Vec3& center, double radius) {
  Region region;
  region.text = "sphere";
  region.where = "pad";
  region.kind = Region::Kind::kSphere;
  region.center = center;
  region.radius = radius;
  return region;
}

Region half_space_below(const Vec3& up, double share) {
  Region region;
  region.text = "half_space";
  region.where = "support";
  region.kind = Region::Kind::kHalfSpace;
  region.normal = up;
  region.share = share;
  return region;
}

/// Where the ray along `up` leaves the body, or nothing.
std::optional<Vec3> find_top(const TetMesh& mesh, const Vec3& up) {
  Region region = sphere_at({}, 1.0);
  region.surface_direction = up;
  try {
    return place_region(region, mesh).center;
  } catch (const InputError&) {  // a bent or hollow body
    return std::nullopt;
  }
}

/// Extent of the body along the normal, within `radius` of the line through the centre. Vertices are few
/// where edges are long, so the centre itself counts.
double measure_thickness(const TetMesh& mesh, const PadRegion& pad) {
  Extent along;
  along.add(0.0);
  for (const Vec3& p : mesh.points) {
    const Vec3 from = p - pad.center_m;
    const double height = dot(from, pad.normal);
    if (length(from - height * pad.normal) <= pad.radius_m) along.add(height);
  }
  return along.size();
}

Vec3 center_of_mass(const TetMesh& mesh) {
  Vec3 sum;
  double whole = 0.0;
  for (const Tet& t : mesh.tets) {
    const auto& p = mesh.points;
    const double volume = signed_volume(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
    sum = sum + 0.25 * volume * (p[t[0]] + p[t[1]] + p[t[2]] + p[t[3]]);
    whole += volume;
  }
  return (1.0 / whole) * sum;
}

/// Whether a body that rests on a patch does not tip over: whichever way one looks along the ground, its
/// centre of mass is over the middle half of the patch.
bool stands_on(const FacePatch& patch, const TetMesh& mesh, const Vec3& up, const Vec3& center) {
  constexpr int kWays = 24;  // half a turn
  constexpr double kLeastShare = 0.25;
  const Vec3 other = std::abs(up.x) < 0.5 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
  const Vec3 across = cross(up, other);
  const Vec3 first = (1.0 / length(across)) * across;
  const Vec3 second = cross(up, first);
  for (int k = 0; k < kWays; ++k) {
    const double angle = std::numbers::pi * k / kWays;
    const Vec3 way = std::cos(angle) * first + std::sin(angle) * second;
    Extent reach;
    for (const Triangle& face : patch.faces) {
      for (const Index corner : face) reach.add(dot(way, mesh.points[corner] - center));
    }
    if (std::min(reach.high, -reach.low) < kLeastShare * reach.size()) return false;
  }
  return true;
}

}  // namespace

RestingRegion find_resting_region(const TetMesh& mesh, const Vec3& up) {
  std::vector<SkinFace> skin = read_skin(mesh);
  Extent extent;
  for (const Vec3& p : mesh.points) extent.add(dot(up, p));
  std::sort(skin.begin(), skin.end(),
            [&](const SkinFace& a, const SkinFace& b) { return dot(up, a.centroid) < dot(up, b.centroid); });
  const double whole = skin_area(skin);
  double area = 0.0;
  RestingRegion found;
  for (const SkinFace& face : skin) {
    area += length(face.area);
    found.share = (dot(up, face.centroid) - extent.low) / extent.size();
    if (area >= kRestingArea * whole) break;
  }
  constexpr int kMostHundredths = 60;
  const Vec3 center = center_of_mass(mesh);
  FacePatch patch;
  for (int hundredths = std::clamp(static_cast<int>(std::ceil(100.0 * found.share)), 2, kMostHundredths);
       hundredths <= kMostHundredths; ++hundredths) {
    found.share = hundredths / 100.0;
    patch = take_hold(half_space_below(up, found.share), mesh);
    found.stands = stands_on(patch, mesh, up, center);
    if (found.stands) break;
  }
  found.faces = patch.faces.size();
  found.area_share = skin_area(patch, mesh) / whole;
  return found;
}

namespace {

/// The nearest number of three digits: what a scene's text has, so that it takes hold of what was looked at.
double to_three_digits(double length_m) {
  const double step = std::pow(10.0, std::floor(std::log10(length_m)) - 2.0);
  return step * std::round(length_m / step);
}

}  // namespace

PadRegion find_pad_region(const TetMesh& mesh, const Vec3& up) {
  constexpr double kSmaller = 0.85;
  constexpr double kWidestShare = 0.25;  // of the longest side
  const std::vector<SkinFace> skin = read_skin(mesh);
  const double whole = skin_area(skin);
  PadRegion pad;
  pad.mean_edge_m = mean_skin_edge(skin, mesh);
  if (const auto top = find_top(mesh, up)) {
    pad.direction = up;
    pad.center_m = *top;
  } else {
    pad.center_m = std::max_element(skin.begin(), skin.end(), [&](const SkinFace& a, const SkinFace& b) {
                     return dot(up, a.centroid) < dot(up, b.centroid);
                   })->centroid;
  }
  pad.radius_m = to_three_digits(
      std::max({pad.mean_edge_m,
                std::min(std::max(std::sqrt(kPadArea * whole / std::numbers::pi), 1.5 * pad.mean_edge_m),
                         kWidestShare * longest_side(bounding_box(mesh.points)))}));
  FacePatch patch;
  while (true) {
    patch = take_hold(sphere_at(pad.center_m, pad.radius_m), mesh);
    pad.normal = mean_normal(patch, mesh);
    pad.reaches_round = std::any_of(patch.faces.begin(), patch.faces.end(), [&](const Triangle& face) {
      const Vec3 area = area_vector_of(mesh, face);
      return dot(area, pad.normal) < -0.5 * length(area);
    });
    const double smaller = to_three_digits(kSmaller * pad.radius_m);
    if (!pad.reaches_round || smaller < pad.mean_edge_m) break;
    pad.radius_m = smaller;
  }
  pad.faces = patch.faces.size();
  pad.area_share = skin_area(patch, mesh) / whole;
  pad.thickness_m = measure_thickness(mesh, pad);
  return pad;
}

}  // namespace palpate::experiments

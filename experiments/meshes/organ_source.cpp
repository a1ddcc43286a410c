#include "experiments/meshes/organ_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "experiments/meshes/body_surface.h"
#include "experiments/meshes/mesh_cache.h"
#include "experiments/meshes/mesh_fill.h"
#include "experiments/meshes/skin_jitter.h"

namespace palpate::experiments {
namespace {

constexpr std::uint64_t kMostOrganVertices = 2'000'000;
constexpr double kCoarseSkin = 2.2;         // skin to interior: gives the thesis's ratio of edges to vertices
constexpr double kFineSkin = 1.0;           // as users' meshes have
constexpr double kFirstInteriorSize = 4.0;  // mm, for kidney of 159 ml and 1503 vertices
constexpr double kFirstVolume = 159.5e3;    // mm^3

/// The body's skin remeshed to edges of about `edge_length`, each seed's its own.
SurfaceMesh remesh_skin(const BodySurface& body, double edge_length, std::uint64_t seed) {
  SurfaceMesh skin = remesh_surface(body.surface, edge_length);
  if (skin_euler(skin) != skin_euler(body.surface)) {
    throw UnavailableError("remeshing changed the topology of the body's surface");
  }
  jitter_skin(seed, skin);
  return skin;
}

/// Skin that goes with edges of `interior` inside, scaled about its vertices' mean to the body's volume.
SurfaceMesh make_skin(const BodySurface& body, SkinKind kind, double interior, std::uint64_t seed) {
  const double ratio = kind == SkinKind::kCoarse ? kCoarseSkin : kFineSkin;
  SurfaceMesh skin = kind == SkinKind::kScanned ? march_surface(body.surface, interior, seed)
                                                : remesh_skin(body, ratio * interior, seed);
  Vec3 centre;
  for (const Vec3& p : skin.points) centre = centre + p;
  centre = (1.0 / static_cast<double>(skin.points.size())) * centre;
  const double factor = std::cbrt(body.volume / enclosed_volume(skin));
  for (Vec3& p : skin.points) p = centre + factor * (p - centre);
  return skin;
}

std::string describe_organ(const ShapeRequest& request, const BodySurface& body,
                           const FilledSurface& filled) {
  std::array<char, 320> text{};
  std::snprintf(text.data(), text.size(),
                "%s: %s, mesh %.1f ml; skin of %zu vertices scaled to %s; interior edges about %.3g mm%s",
                request.name.c_str(), body.source.c_str(), total_volume(filled.mesh) / 1000.0,
                filled.skin.points.size(), body.volume_of.c_str(), filled.interior_size, body.origin.c_str());
  return text.data();
}

}  // namespace

bool is_body(const std::string& name) {
  const auto& bodies = list_bodies();
  return std::any_of(bodies.begin(), bodies.end(), [&](const BodyInfo& body) { return body.name == name; });
}

MadeMesh make_body(const ShapeRequest& request) {
  require(is_body(request.name), "make_body: not a body");
  const MeshSize& size = request.size;
  const std::uint64_t vertices = size.vertices.value_or(kDefaultVertices);
  if (vertices < kFewestVertices || vertices > kMostOrganVertices) {
    throw InputError(request.name, 0, "100 to 2000000 vertices", std::to_string(vertices));
  }
  if (size.edge_length) check_interior_size(kFirstVolume, *size.edge_length);
  const BodySurface body = load_body_surface(request.name);
  const auto skin = [&](double interior) { return make_skin(body, request.skin, interior, request.seed); };
  FilledSurface filled;
  if (size.edge_length) {
    check_interior_size(body.volume, *size.edge_length);
    filled = fill_surface(skin(*size.edge_length), *size.edge_length);
  } else {
    const double start =
        kFirstInteriorSize * std::cbrt(body.volume / kFirstVolume * static_cast<double>(kDefaultVertices) /
                                       static_cast<double>(vertices));
    filled = fill_with_skin(skin, vertices, start, request.name);
  }
  MadeMesh made;
  made.notes.push_back(describe_organ(request, body, filled));
  made.mesh = std::move(filled.mesh);
  return made;
}

}  // namespace palpate::experiments

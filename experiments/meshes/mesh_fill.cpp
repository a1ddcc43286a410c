#include "experiments/meshes/mesh_fill.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <utility>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/io/off.h"
#include "core/mesh/orientation.h"
#include "core/mesh/topology.h"
#include "experiments/meshes/mesh_tools.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

constexpr double kVerticesPerCube = 0.48;  // inner vertices for each h^3 of volume, as gmsh fills
constexpr double kLargestVertexCount = 2e7;
constexpr double kSkinToInterior = 2.25;  // of a user's surface that has to be remeshed
constexpr double kLongestInside = 1.1;    // edges inside over those of a user's skin that is kept
constexpr double kLargestSurface = 1e60;  // gmsh 4.8 aborts on 1e80, and fails slowly on 1e-60
constexpr double kSmallestSurface = 1e-40;
constexpr double kSmallestBodyM = 1e-9;  // what --unit-m may make of one
constexpr double kLargestBodyM = 1e6;
constexpr double kAcceptedError = 0.01;
constexpr double kSkinError = 0.08;  // close enough to keep the skin and adapt the interior alone
constexpr int kSkinTries = 6;
constexpr int kInteriorTries = 14;

/// Large meshes take a second or more a try, so they are aimed less finely.
double aimed_error(std::uint64_t vertices) {
  return vertices <= 3000 ? 0.003 : 0.008;
}

double relative_error(const FilledSurface& filled, std::uint64_t vertices) {
  return static_cast<double>(filled.mesh.points.size()) / static_cast<double>(vertices) - 1.0;
}

bool is_better(const FilledSurface& a, const FilledSurface& b, std::uint64_t vertices) {
  return b.mesh.points.empty() ||
         std::fabs(relative_error(a, vertices)) < std::fabs(relative_error(b, vertices));
}

/// The skin must be the mesh's boundary, and the mesh as simple as the skin.
void check_filled(const SurfaceMesh& skin, const TetMesh& mesh) {
  const auto& p = mesh.points;
  const bool keeps_points =
      p.size() >= skin.points.size() && std::equal(skin.points.begin(), skin.points.end(), p.begin());
  if (!keeps_points) throw UnavailableError("gmsh moved vertices of the skin");
  for (const Tet& t : mesh.tets) {
    if (orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]) <= 0) {
      throw UnavailableError("gmsh left an inverted tetrahedron");
    }
  }
  if (build_boundary(mesh).size() != skin.triangles.size()) {
    throw UnavailableError("gmsh changed the triangles of the skin");
  }
  const auto faces = static_cast<std::int64_t>(build_faces(mesh).size());
  const auto edges = static_cast<std::int64_t>(build_edges(mesh).size());
  const std::int64_t euler =
      static_cast<std::int64_t>(p.size()) - edges + faces - static_cast<std::int64_t>(mesh.tets.size());
  if (2 * euler != skin_euler(skin)) throw UnavailableError("gmsh left holes inside the surface");
}

/// Says now and then how far a search is that takes long.
class SearchNote {
 public:
  explicit SearchNote(std::uint64_t vertices) : vertices_(vertices) {}

  void look(const FilledSurface& best) {
    if (watch_.seconds() < next_s_) return;
    print_note("still looking for a filling with " + std::to_string(vertices_) +
               " vertices: the nearest so far has " + std::to_string(best.mesh.points.size()));
    next_s_ = watch_.seconds() + kEveryS;
  }

 private:
  static constexpr double kEveryS = 10.0;
  std::uint64_t vertices_;
  Stopwatch watch_;
  double next_s_ = kEveryS;
};

/// The triangles of a surface, connected piece by connected piece.
std::vector<std::vector<Triangle>> pieces_of(const SurfaceMesh& surface) {
  std::vector<Index> above(surface.points.size());
  std::iota(above.begin(), above.end(), Index{0});
  const auto root = [&above](Index v) {
    while (above[v] != v) v = above[v] = above[above[v]];
    return v;
  };
  for (const Triangle& t : surface.triangles) {
    above[root(t[1])] = root(t[0]);
    above[root(t[2])] = root(t[0]);
  }
  std::map<Index, std::vector<Triangle>> pieces;
  for (const Triangle& t : surface.triangles) pieces[root(t[0])].push_back(t);
  std::vector<std::vector<Triangle>> all;
  all.reserve(pieces.size());
  for (auto& [first, triangles] : pieces) all.push_back(std::move(triangles));
  return all;
}

/// Whether a piece encloses a body, and no cavity: the sign of its volume.
bool is_outward(const SurfaceMesh& surface, const std::vector<Triangle>& piece) {
  const Vec3& from = surface.points[piece.front()[0]];
  double volume = 0.0;
  for (const Triangle& t : piece) {
    volume +=
        dot(surface.points[t[0]] - from, cross(surface.points[t[1]] - from, surface.points[t[2]] - from));
  }
  return volume > 0.0;
}

}  // namespace

void check_fillable(const std::string& where, const SurfaceMesh& surface) {
  double most = 0.0;
  for (const Vec3& p : surface.points)
    most = std::max({most, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  if (!(most <= kLargestSurface))
    throw InputError(where, 0, "coordinates within +-" + short_number(kLargestSurface), short_number(most));
  const double longest = longest_side(bounding_box(surface.points));
  if (!(longest >= kSmallestSurface))
    throw InputError(where, 0, "a surface that is at least " + short_number(kSmallestSurface) + " long",
                     short_number(longest));
  const std::vector<std::vector<Triangle>> pieces = pieces_of(surface);
  const auto outer = static_cast<std::size_t>(std::count_if(
      pieces.begin(), pieces.end(), [&](const auto& piece) { return is_outward(surface, piece); }));
  const std::size_t cavities = pieces.size() - outer;
  if (outer > 1 && cavities > 0)
    throw InputError(where, 0, "one piece with its cavities, or several without any",
                     std::to_string(outer) + " pieces and " + std::to_string(cavities) +
                         (cavities == 1 ? " cavity" : " cavities") + ": mesh each piece by itself");
}

void require_body_size(double across_m) {
  if (!(across_m >= kSmallestBodyM && across_m <= kLargestBodyM))
    throw InputError("--unit-m", 0, "a unit in which the body is 1 nm to 1000 km across",
                     short_number(across_m) + " m");
}

std::int64_t skin_euler(const SurfaceMesh& skin) {
  return static_cast<std::int64_t>(skin.points.size()) - static_cast<std::int64_t>(skin.triangles.size() / 2);
}

FilledSurface fill_surface(const SurfaceMesh& skin, double interior_size) {
  const ScratchFolder scratch;
  write_off(scratch.file("skin.off"), skin);
  const double expected = static_cast<double>(skin.points.size()) +
                          estimate_interior_vertices(enclosed_volume(skin), interior_size);
  ToolCall call{"mesh", "gmsh.delaunay", scratch.file("skin.off"), scratch.file("filled.mesh"), {}, 60.0};
  call.options = {{"interior_size", interior_size}};
  call.timeout_s += expected / 500.0;  // gmsh fills ten times as many a second
  run_tool(kGmshTool, call);
  FilledSurface filled{skin, {}, interior_size};
  filled.mesh = read_medit(call.output, ReadOrientation::kKeep).mesh;
  check_filled(skin, filled.mesh);
  return filled;
}

SurfaceMesh remesh_surface(const SurfaceMesh& surface, double edge_length) {
  const ScratchFolder scratch;
  write_off(scratch.file("surface.off"), surface);
  ToolCall call{"mesh", "cgal.remesh_surface", scratch.file("surface.off"), scratch.file("skin.off"), {},
                600.0};
  call.options = {{"edge_length", edge_length}};
  run_tool(kSurfaceTool, call);
  return read_off(call.output);
}

SurfaceMesh march_surface(const SurfaceMesh& surface, double spacing, std::uint64_t seed) {
  const ScratchFolder scratch;
  write_off(scratch.file("surface.off"), surface);
  ToolCall call{"mesh", "vtk.march", scratch.file("surface.off"), scratch.file("skin.off"), {}, 600.0};
  call.options = {{"spacing", spacing}, {"seed", seed}};
  run_tool(kVtkTool, call);
  SurfaceMesh marched = read_off(call.output);
  if (skin_euler(marched) != skin_euler(surface))
    throw UnavailableError("on so coarse a grid marching cubes change the topology of the surface");
  return marched;
}

double estimate_interior_vertices(double volume, double interior_size) {
  return kVerticesPerCube * volume / (interior_size * interior_size * interior_size);
}

double estimate_interior_size(double volume, double vertices) {
  return std::cbrt(kVerticesPerCube * volume / vertices);
}

void check_interior_size(double volume, double interior_size) {
  if (!(interior_size > 0.0) || !std::isfinite(interior_size)) {
    throw InputError("edge length", 0, "a positive number", short_number(interior_size));
  }
  const double expected = estimate_interior_vertices(volume, interior_size);
  if (expected > kLargestVertexCount) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%g, which takes about %.3g", interior_size, expected);
    throw InputError("edge length", 0, "a length that takes fewer than 20 million vertices", text.data());
  }
}

double mean_edge(const SurfaceMesh& surface) {
  double sum = 0.0;
  for (const Triangle& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) sum += length(surface.points[t[k]] - surface.points[t[(k + 1) % 3]]);
  }
  return sum / (3.0 * static_cast<double>(surface.triangles.size()));
}

FilledSurface fill_user_surface(const SurfaceMesh& surface, std::uint64_t vertices,
                                std::vector<std::string>& notes) {
  const double volume = enclosed_volume(surface);
  const std::size_t skin_count = surface.points.size();
  if (skin_count < vertices) {
    const double start =
        estimate_interior_size(volume, static_cast<double>(vertices) - static_cast<double>(skin_count));
    if (start <= kLongestInside * mean_edge(surface)) {
      FilledSurface filled = fill_to_vertices(surface, vertices, start);
      if (is_close_enough(filled.mesh.points.size(), vertices)) return filled;
    }
  }
  notes.push_back("the skin of " + std::to_string(skin_count) + " vertices is too " +
                  (skin_count < vertices ? "coarse" : "fine") + " for a mesh of " + std::to_string(vertices) +
                  ": it was remeshed");
  const auto skin = [&](double interior) { return remesh_surface(surface, kSkinToInterior * interior); };
  return fill_with_skin(skin, vertices, estimate_interior_size(volume, 0.8 * static_cast<double>(vertices)),
                        "vertices");
}

bool is_close_enough(std::uint64_t found, std::uint64_t wanted) {
  const std::uint64_t gap = found > wanted ? found - wanted : wanted - found;
  return gap <= 1 || static_cast<double>(gap) <= kAcceptedError * static_cast<double>(wanted);
}

void require_vertices(const FilledSurface& filled, std::uint64_t vertices, const std::string& name) {
  const std::uint64_t found = filled.mesh.points.size();
  if (is_close_enough(found, vertices)) return;
  throw InputError(name, 0, "a number of vertices that it can be made with",
                   std::to_string(vertices) + " (the nearest found is " + std::to_string(found) + ")");
}

FilledSurface fill_to_vertices(const SurfaceMesh& skin, std::uint64_t vertices, double start) {
  const auto skin_count = static_cast<double>(skin.points.size());
  const auto wanted = static_cast<double>(vertices) - skin_count;
  require(wanted > 0.0, "fill_to_vertices: the skin alone has as many vertices");
  FilledSurface best;
  double too_fine = 0.0;
  double too_coarse = 0.0;
  double size = start;
  SearchNote note(vertices);
  for (int i = 0; i < kInteriorTries; ++i) {
    FilledSurface filled = fill_surface(skin, size);
    const double error = relative_error(filled, vertices);
    const double inner = std::max(1.0, static_cast<double>(filled.mesh.points.size()) - skin_count);
    if (is_better(filled, best, vertices)) best = std::move(filled);
    if (std::fabs(error) <= aimed_error(vertices)) break;
    note.look(best);
    (error > 0.0 ? too_fine : too_coarse) = size;
    double next = size * std::clamp(std::cbrt(inner / wanted), 0.5, 2.0);
    const bool has_bracket = too_fine > 0.0 && too_coarse > 0.0;
    const double low = std::min(too_fine, too_coarse);
    const double high = std::max(too_fine, too_coarse);
    if (has_bracket && (next <= low || next >= high || i > kInteriorTries / 2)) next = std::sqrt(low * high);
    if (next == size || (has_bracket && high - low < 1e-9 * high)) break;
    size = next;
  }
  return best;
}

FilledSurface fill_with_skin(const SkinMaker& make_skin, std::uint64_t vertices, double start,
                             const std::string& name) {
  FilledSurface best;
  double size = start;
  SearchNote note(vertices);
  for (int i = 0; i < kSkinTries; ++i) {
    FilledSurface filled = fill_surface(make_skin(size), size);
    const double error = relative_error(filled, vertices);
    if (is_better(filled, best, vertices)) best = std::move(filled);
    if (std::fabs(error) <= kSkinError) break;
    note.look(best);
    size *= std::clamp(std::cbrt(1.0 + error), 0.3, 3.0);
  }
  if (std::fabs(relative_error(best, vertices)) > aimed_error(vertices) &&
      best.skin.points.size() < vertices) {
    FilledSurface closer = fill_to_vertices(best.skin, vertices, best.interior_size);
    if (is_better(closer, best, vertices)) best = std::move(closer);
  }
  // Over one skin the count may jump across what is wanted: others nearby have their jumps elsewhere.
  for (const double factor : {0.98, 1.02, 0.96, 1.04}) {
    if (is_close_enough(best.mesh.points.size(), vertices)) break;
    const SurfaceMesh other = make_skin(factor * size);
    if (other.points.size() >= vertices) continue;
    FilledSurface filled = fill_to_vertices(other, vertices, best.interior_size);
    if (is_better(filled, best, vertices)) best = std::move(filled);
  }
  require_vertices(best, vertices, name);
  return best;
}

}  // namespace palpate::experiments

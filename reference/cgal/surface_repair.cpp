// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "reference/cgal/surface_cgal.h"
#include "reference/cgal/surface_tools.h"

namespace palpate::reference {
namespace {

namespace repairing = CGAL::Polygon_mesh_processing;

constexpr double kSamePoint = 1e-6;     // of the box's diagonal
constexpr double kLoosePiece = 0.01;    // of the surface's area
constexpr double kFillDensity = 1.414;  // CGAL's own: triangles in a hole as small as around it
constexpr int kIntersectionRounds = 3;  // a removal may leave holes, and their filling intersections

/// What has become of a triangle of the file.
enum Fate : std::uint8_t { kAsItWas, kTurned, kNew };

struct Soup {
  std::vector<SurfaceKernel::Point_3> points;
  std::vector<std::vector<std::size_t>> triangles;
};

/// Merges each point with the first one that is nearer than `reach`.
std::vector<Index> merge_points(const std::vector<Vec3>& points, double reach) {
  using Cell = std::array<std::int64_t, 3>;
  std::map<Cell, std::vector<Index>> cells;
  std::vector<Index> merged(points.size());
  const auto cell_of = [&](double x) { return static_cast<std::int64_t>(std::floor(x / reach)); };
  const auto find = [&](const Vec3& p) {
    const Cell home{cell_of(p.x), cell_of(p.y), cell_of(p.z)};
    for (int k = 0; k < 27; ++k) {
      const auto near = cells.find({home[0] + k % 3 - 1, home[1] + k / 3 % 3 - 1, home[2] + k / 9 - 1});
      if (near == cells.end()) continue;
      for (const Index other : near->second) {
        if (length(points[other] - p) < reach) return other;
      }
    }
    return kNoIndex;
  };
  for (Index v = 0; v < points.size(); ++v) {
    const Vec3& p = points[v];
    const Index known = find(p);
    merged[v] = known == kNoIndex ? v : known;
    if (known == kNoIndex) cells[{cell_of(p.x), cell_of(p.y), cell_of(p.z)}].push_back(v);
  }
  return merged;
}

/// The triangles with merged points, without those that have lost a corner or are there twice.
Soup clean_soup(const SurfaceMesh& surface, SurfaceRepair& repair) {
  const BoundingBox box = bounding_box(surface.points);
  const double reach = kSamePoint * length(box.high - box.low);
  const std::vector<Index> merged = merge_points(surface.points, std::max(reach, 1e-300));
  for (Index v = 0; v < merged.size(); ++v) repair.points_merged += merged[v] != v ? 1 : 0;
  Soup soup;
  std::vector<std::size_t> place(surface.points.size(), surface.points.size());
  std::set<Triangle> known;
  for (const Triangle& triangle : surface.triangles) {
    Triangle corners{merged[triangle[0]], merged[triangle[1]], merged[triangle[2]]};
    Triangle sorted = corners;
    std::sort(sorted.begin(), sorted.end());
    if (sorted[0] == sorted[1] || sorted[1] == sorted[2] || !known.insert(sorted).second) {
      ++repair.triangles_dropped;
      continue;
    }
    std::vector<std::size_t>& polygon = soup.triangles.emplace_back();
    for (const Index v : corners) {
      if (place[v] == surface.points.size()) {
        place[v] = soup.points.size();
        soup.points.emplace_back(surface.points[v].x, surface.points[v].y, surface.points[v].z);
      }
      polygon.push_back(place[v]);
    }
  }
  return soup;
}

/// Does the polygon, of the same three places, run the other way round?
bool is_reversed(const std::vector<SurfaceKernel::Point_3>& points,
                 const std::array<SurfaceKernel::Point_3, 3>& before, const std::vector<std::size_t>& after) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (points[after[k]] == before[0]) return points[after[(k + 1) % 3]] != before[1];
  }
  return false;
}

/// Mends one surface, pass by pass.
class Mender {
 public:
  explicit Mender(const SurfaceMesh& surface) {
    measure_before(surface);
    Soup soup = clean_soup(surface, repair_);
    std::vector<std::array<SurfaceKernel::Point_3, 3>> before;
    for (const auto& t : soup.triangles)
      before.push_back({soup.points[t[0]], soup.points[t[1]], soup.points[t[2]]});
    const std::size_t points = soup.points.size();
    repairing::orient_polygon_soup(soup.points, soup.triangles);
    repair_.points_split = soup.points.size() - points;
    repairing::polygon_soup_to_polygon_mesh(soup.points, soup.triangles, mesh_);
    fate_ = mesh_.add_property_map<CgalSurface::Face_index, std::uint8_t>("f:fate", kNew).first;
    std::size_t i = 0;
    for (const auto face : mesh_.faces()) {
      fate_[face] = is_reversed(soup.points, before[i], soup.triangles[i]) ? kTurned : kAsItWas;
      ++i;
    }
  }

  SurfaceRepair mend() {
    repairing::stitch_borders(mesh_);
    drop_flat_triangles();
    drop_loose_pieces();
    fill_holes();
    remove_intersections();
    if (CGAL::is_closed(mesh_) && !repairing::does_self_intersect(mesh_)) turn_outward();
    for (const auto face : mesh_.faces()) repair_.triangles_turned += fate_[face] == kTurned ? 1 : 0;
    mesh_.collect_garbage();
    repair_.surface = from_cgal(mesh_);
    repair_.area_after = area_of(repair_.surface);
    repair_.volume_after = enclosed_volume(repair_.surface);
    return std::move(repair_);
  }

 private:
  static double area_of(const SurfaceMesh& surface) {
    double area = 0.0;
    for (const Triangle& t : surface.triangles) {
      const Vec3& a = surface.points[t[0]];
      area += 0.5 * length(cross(surface.points[t[1]] - a, surface.points[t[2]] - a));
    }
    return area;
  }

  void measure_before(const SurfaceMesh& surface) {
    repair_.area_before = area_of(surface);
    repair_.volume_before = enclosed_volume(surface);
    std::map<Edge, int> sides;
    for (const Triangle& t : surface.triangles) {
      for (std::size_t k = 0; k < 3; ++k)
        ++sides[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
    }
    repair_.was_closed =
        std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side.second == 2; });
  }

  void drop_flat_triangles() {
    const std::size_t before = mesh_.number_of_faces();
    repairing::remove_degenerate_faces(mesh_);
    repair_.triangles_dropped += before - std::min(before, std::size_t{mesh_.number_of_faces()});
  }

  void drop_loose_pieces() {
    auto piece = mesh_.add_property_map<CgalSurface::Face_index, std::size_t>("f:piece", 0).first;
    const std::size_t count = repairing::connected_components(mesh_, piece);
    std::vector<double> area(count, 0.0);
    std::vector<bool> is_open(count, false);
    double total = 0.0;
    for (const auto face : mesh_.faces()) {
      const double own = 0.5 * length(normal_of(mesh_, face));
      area[piece[face]] += own;
      total += own;
      for (const auto h : mesh_.halfedges_around_face(mesh_.halfedge(face)))
        if (mesh_.is_border(mesh_.opposite(h))) is_open[piece[face]] = true;
    }
    std::vector<std::size_t> loose;
    for (std::size_t k = 0; k < count; ++k)
      if (is_open[k] && area[k] < kLoosePiece * total) loose.push_back(k);
    repair_.pieces_dropped = loose.size();
    if (!loose.empty()) repairing::remove_connected_components(mesh_, loose, piece);
    mesh_.remove_property_map(piece);
  }

  double rim_length(CgalSurface::Halfedge_index start) const {
    double sum = 0.0;
    auto h = start;
    do {
      sum += length(point_of(mesh_, mesh_.target(h)) - point_of(mesh_, mesh_.source(h)));
      h = mesh_.next(h);
    } while (h != start);
    return sum;
  }

  void fill_holes() {
    std::vector<CgalSurface::Halfedge_index> rims;
    repairing::extract_boundary_cycles(mesh_, std::back_inserter(rims));
    for (const auto rim : rims) {
      const double rim_size = rim_length(rim);
      std::vector<CgalSurface::Face_index> faces;
      std::vector<CgalSurface::Vertex_index> vertices;
      repairing::triangulate_and_refine_hole(mesh_, rim, std::back_inserter(faces),
                                             std::back_inserter(vertices),
                                             repairing::parameters::density_control_factor(kFillDensity));
      if (faces.empty()) continue;
      ++repair_.holes_filled;
      repair_.hole_triangles += faces.size();
      repair_.longest_rim = std::max(repair_.longest_rim, rim_size);
    }
  }

  std::size_t count_intersections() const {
    std::vector<std::pair<CgalSurface::Face_index, CgalSurface::Face_index>> pairs;
    repairing::self_intersections(mesh_, std::back_inserter(pairs));
    return pairs.size();
  }

  void remove_intersections() {
    repair_.intersecting_pairs = count_intersections();
    if (repair_.intersecting_pairs == 0) return;
    const auto count_old = [&] {
      std::size_t count = 0;
      for (const auto face : mesh_.faces()) count += fate_[face] != kNew ? 1 : 0;
      return count;
    };
    const std::size_t before = count_old();
    for (int round = 0; round < kIntersectionRounds; ++round) {
      repairing::experimental::remove_self_intersections(mesh_,
                                                         repairing::parameters::preserve_genus(round == 0));
      fill_holes();
      if (count_intersections() == 0) break;
    }
    repair_.triangles_replaced = before - std::min(before, count_old());
  }

  void turn_outward() {
    auto normal = mesh_.add_property_map<CgalSurface::Face_index, Vec3>("f:normal", Vec3{}).first;
    for (const auto face : mesh_.faces()) normal[face] = normal_of(mesh_, face);
    repairing::orient_to_bound_a_volume(mesh_);
    for (const auto face : mesh_.faces()) {
      if (fate_[face] == kNew || dot(normal[face], normal_of(mesh_, face)) >= 0.0) continue;
      fate_[face] = fate_[face] == kTurned ? kAsItWas : kTurned;
    }
    mesh_.remove_property_map(normal);
  }

  CgalSurface mesh_;
  CgalSurface::Property_map<CgalSurface::Face_index, std::uint8_t> fate_;
  SurfaceRepair repair_;
};

std::string counted(std::size_t count, const char* one, const char* more) {
  return std::to_string(count) + " " + (count == 1 ? one : more);
}

/// "12.3": four digits are enough to see what changed.
std::string four_digits(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

}  // namespace

std::string SurfaceRepair::text() const {
  std::vector<std::string> changes;
  if (points_merged > 0)
    changes.push_back(counted(points_merged, "point", "points") + " merged with another next to it");
  if (triangles_dropped > 0)
    changes.push_back(counted(triangles_dropped, "triangle", "triangles") +
                      " without area or doubled taken out");
  if (pieces_dropped > 0)
    changes.push_back(counted(pieces_dropped, "small open piece", "small open pieces") + " taken out");
  if (points_split > 0)
    changes.push_back(counted(points_split, "point", "points") + " split where sheets touched");
  if (holes_filled > 0)
    changes.push_back(counted(holes_filled, "hole", "holes") + " filled with " +
                      counted(hole_triangles, "triangle", "triangles") + " (longest rim " +
                      four_digits(longest_rim) + ")");
  if (intersecting_pairs > 0)
    changes.push_back(counted(triangles_replaced, "triangle", "triangles") + " replaced because of " +
                      counted(intersecting_pairs, "pair", "pairs") + " that intersected");
  if (triangles_turned > 0)
    changes.push_back(counted(triangles_turned, "triangle", "triangles") + " turned around");
  if (changes.empty()) return "repair: nothing had to be changed";
  std::string text = "repaired: ";
  for (const std::string& change : changes) text += change + "; ";
  text += "area " + four_digits(area_before) + " before, " + four_digits(area_after) + " after; volume ";
  text += was_closed ? four_digits(volume_before) + " before, " : "none before (it was not closed), ";
  return text + four_digits(volume_after) + " after";
}

SurfaceRepair repair_surface(const SurfaceMesh& surface) {
  return Mender(surface).mend();
}

}  // namespace palpate::reference

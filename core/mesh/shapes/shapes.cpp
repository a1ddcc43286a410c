#include "core/mesh/shapes/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/orientation.h"
#include "core/mesh/topology.h"

namespace palpate {
namespace {

// Only + - * / and sqrt, which IEEE 754 rounds correctly: the bytes do not depend on the maths library.

/// Cells along x, y and z, and the lattice points between them, x fastest.
struct Grid {
  std::array<Index, 3> cells;

  Index point(Index i, Index j, Index k) const { return (k * (cells[1] + 1) + j) * (cells[0] + 1) + i; }
  Index cell(Index i, Index j, Index k) const { return (k * cells[1] + j) * cells[0] + i; }
  std::size_t cell_count() const { return std::size_t{cells[0]} * cells[1] * cells[2]; }
  std::size_t point_count() const {
    return (std::size_t{cells[0]} + 1) * (std::size_t{cells[1]} + 1) * (std::size_t{cells[2]} + 1);
  }
};

Index checked_size(const char* what, int size, int largest) {
  if (size < 1 || size > largest) {
    throw InputError(what, 0, "a whole number from 1 to " + std::to_string(largest), std::to_string(size));
  }
  return static_cast<Index>(size);
}

/// The lattice points of the grid, `cells_per_unit` cells a unit of length.
void add_grid_points(const Grid& grid, double cells_per_unit, std::vector<Vec3>& points) {
  for (Index k = 0; k <= grid.cells[2]; ++k) {
    for (Index j = 0; j <= grid.cells[1]; ++j) {
      for (Index i = 0; i <= grid.cells[0]; ++i) {
        points.push_back({i / cells_per_unit, j / cells_per_unit, k / cells_per_unit});
      }
    }
  }
}

constexpr int kKuhnTetsPerCell = 6;

/// Corners of the six Kuhn tets of a cell, as 3-bit offsets (1: +x, 2: +y, 4: +z): the paths from corner 0 to
/// corner 7 along the axes, one for each order of the axes, positively oriented.
constexpr std::array<std::array<Index, 4>, kKuhnTetsPerCell> kKuhnCorners{
    {{0, 1, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 3, 2, 7}, {0, 6, 4, 7}, {0, 5, 1, 7}}};

TetMesh build_kuhn_grid(const Grid& grid, double cells_per_unit) {
  TetMesh mesh;
  mesh.points.reserve(grid.point_count());
  add_grid_points(grid, cells_per_unit, mesh.points);
  mesh.tets.reserve(kKuhnTetsPerCell * grid.cell_count());
  for (Index k = 0; k < grid.cells[2]; ++k) {
    for (Index j = 0; j < grid.cells[1]; ++j) {
      for (Index i = 0; i < grid.cells[0]; ++i) {
        for (const auto& corners : kKuhnCorners) {
          Tet tet;
          for (std::size_t c = 0; c < 4; ++c) {
            tet[c] = grid.point(i + (corners[c] & 1U), j + (corners[c] >> 1U & 1U), k + (corners[c] >> 2U));
          }
          mesh.tets.push_back(tet);
        }
      }
    }
  }
  return mesh;
}

/// The tets around an inner lattice point, as steps back to the cell and the number of the tet in it.
struct KuhnStar {
  struct Entry {
    Index back_i, back_j, back_k;
    Index tet;
  };
  std::array<Entry, 24> entries{};

  KuhnStar() {
    std::size_t size = 0;
    for (Index tet = 0; tet < kKuhnTetsPerCell; ++tet) {
      for (const Index corner : kKuhnCorners[tet]) {
        entries[size++] = {corner & 1U, corner >> 1U & 1U, corner >> 2U, tet};
      }
    }
  }
};

bool is_positive(const TetMesh& mesh, const Tet& t) {
  return orientation(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]) > 0;
}

/// Moves each inner point by up to `distance` an axis; halves a move until the tets around stay positive.
void jitter_inner_points(const Grid& grid, double distance, std::uint64_t seed, TetMesh& mesh) {
  constexpr int kMostHalvings = 40;
  const KuhnStar star;
  SplitMix64 random(seed);
  for (Index k = 1; k < grid.cells[2]; ++k) {
    for (Index j = 1; j < grid.cells[1]; ++j) {
      for (Index i = 1; i < grid.cells[0]; ++i) {
        const auto is_valid = [&] {
          return std::all_of(star.entries.begin(), star.entries.end(), [&](const KuhnStar::Entry& e) {
            const std::size_t cell = grid.cell(i - e.back_i, j - e.back_j, k - e.back_k);
            return is_positive(mesh, mesh.tets[kKuhnTetsPerCell * cell + e.tet]);
          });
        };
        Vec3 move;
        move.x = distance * (2.0 * random.uniform() - 1.0);
        move.y = distance * (2.0 * random.uniform() - 1.0);
        move.z = distance * (2.0 * random.uniform() - 1.0);
        Vec3& point = mesh.points[grid.point(i, j, k)];
        const Vec3 home = point;
        point = home + move;
        for (int halvings = 0; !is_valid(); ++halvings) {
          move = 0.5 * move;
          point = halvings < kMostHalvings ? home + move : home;
        }
      }
    }
  }
}

/// Adds the four tets between apexes `low` and `high` and the square a, b, c, d between them, which is
/// counter-clockwise seen from `high`.
void add_square_bipyramid(Index low, Index high, const std::array<Index, 4>& square, std::vector<Tet>& tets) {
  for (std::size_t s = 0; s < 4; ++s) tets.push_back({low, square[s], square[(s + 1) % 4], high});
}

/// The corners of the lower face of cell (i, j, k) across `axis`, counter-clockwise seen from above.
std::array<Index, 4> lower_face(const Grid& grid, std::size_t axis, const std::array<Index, 3>& cell) {
  const std::size_t u = (axis + 1) % 3;
  const std::size_t v = (axis + 2) % 3;
  std::array<std::array<Index, 3>, 4> corners{cell, cell, cell, cell};
  ++corners[1][u];
  ++corners[2][u];
  ++corners[2][v];
  ++corners[3][v];
  std::array<Index, 4> face;
  for (std::size_t c = 0; c < 4; ++c) face[c] = grid.point(corners[c][0], corners[c][1], corners[c][2]);
  return face;
}

/// Adds the tets around the faces across `axis`: from centre to centre inside, and from the centre to a new
/// vertex in the middle of the face on the boundary.
void add_bcc_tets(const Grid& grid, double cells_per_unit, std::size_t axis, TetMesh& mesh) {
  const Index first_centre = static_cast<Index>(grid.point_count());
  std::array<Index, 3> slots = grid.cells;
  ++slots[axis];
  std::array<Index, 3> at{};
  for (at[2] = 0; at[2] < slots[2]; ++at[2]) {
    for (at[1] = 0; at[1] < slots[1]; ++at[1]) {
      for (at[0] = 0; at[0] < slots[0]; ++at[0]) {
        std::array<Index, 3> below = at;
        const bool has_below = at[axis] > 0;
        const bool has_above = at[axis] < grid.cells[axis];
        if (has_below) --below[axis];
        Index middle = kNoIndex;
        if (!has_below || !has_above) {
          std::array<double, 3> p;
          for (std::size_t a = 0; a < 3; ++a) p[a] = (at[a] + (a == axis ? 0.0 : 0.5)) / cells_per_unit;
          middle = static_cast<Index>(mesh.points.size());
          mesh.points.push_back({p[0], p[1], p[2]});
        }
        const Index low = has_below ? first_centre + grid.cell(below[0], below[1], below[2]) : middle;
        const Index high = has_above ? first_centre + grid.cell(at[0], at[1], at[2]) : middle;
        add_square_bipyramid(low, high, lower_face(grid, axis, at), mesh.tets);
      }
    }
  }
}

/// The icosahedron: golden rectangles in the three coordinate planes; faces counter-clockwise from outside.
struct Icosahedron {
  std::array<Vec3, 12> corners;
  std::vector<Triangle> faces;

  Icosahedron() {
    const double golden = 0.5 * (1.0 + std::sqrt(5.0));
    std::size_t size = 0;
    for (const double a : {-1.0, 1.0}) {
      for (const double b : {-golden, golden}) {
        corners[size++] = {0.0, a, b};
        corners[size++] = {a, b, 0.0};
        corners[size++] = {b, 0.0, a};
      }
    }
    const auto adjacent = [&](Index a, Index b) { return length_sq(corners[a] - corners[b]) < 5.0; };
    for (Index a = 0; a < 12; ++a) {
      for (Index b = a + 1; b < 12; ++b) {
        for (Index c = b + 1; c < 12; ++c) {
          if (!adjacent(a, b) || !adjacent(b, c) || !adjacent(a, c)) continue;
          const bool outward = dot(corners[a], cross(corners[b], corners[c])) > 0.0;
          faces.push_back(outward ? Triangle{a, b, c} : Triangle{a, c, b});
        }
      }
    }
  }
};

Vec3 on_unit_sphere(const Vec3& p) {
  return (1.0 / length(p)) * p;
}

/// Numbers the vertices of a divided icosahedron: 12 corners, then the points inside the 30 edges, then the
/// points inside the 20 faces.
class GeodesicNumbers {
 public:
  GeodesicNumbers(const Icosahedron& solid, Index frequency) : frequency_(frequency) {
    for (const Triangle& face : solid.faces) {
      for (std::size_t s = 0; s < 3; ++s) {
        const Index a = face[s];
        const Index b = face[(s + 1) % 3];
        if (a < b) edge_number_[a][b] = edge_count_++;
      }
    }
  }

  /// The vertex of face `f` at barycentric steps (i, j, frequency - i - j) of its corners 1, 2 and 0.
  Index of(const Icosahedron& solid, Index f, Index i, Index j) const {
    const Triangle& corner = solid.faces[f];
    const Index rest = frequency_ - i - j;
    if (i == frequency_) return corner[1];
    if (j == frequency_) return corner[2];
    if (rest == frequency_) return corner[0];
    if (j == 0) return on_edge(corner[0], corner[1], i);
    if (rest == 0) return on_edge(corner[1], corner[2], j);
    if (i == 0) return on_edge(corner[2], corner[0], rest);
    const Index inside = (frequency_ - 1) * (frequency_ - 2) / 2;
    const Index before = (j - 1) * (frequency_ - 1) - (j - 1) * j / 2;
    return 12 + 30 * (frequency_ - 1) + f * inside + before + i - 1;
  }

 private:
  Index on_edge(Index a, Index b, Index step) const {
    const Index edge = a < b ? edge_number_[a][b] : edge_number_[b][a];
    return 12 + edge * (frequency_ - 1) + (a < b ? step : frequency_ - step) - 1;
  }

  Index frequency_;
  Index edge_count_ = 0;
  std::array<std::array<Index, 12>, 12> edge_number_{};
};

/// Takes a point of the unit sphere to the kidney, in centimetres: 11.0 long, 5.5 wide, 4.5 thick.
///
///   along       t = x - s x (1 - x^2): the poles get some of the equator's vertices
///   section     half axes r(t) (w, h), r(t)^2 = (1 - t^2) (1 + e t^2): an ellipsoid with fuller ends
///   hilum       y is pushed in by d ((1 + y) / 2)^6, deepest in the middle of the inner side
///   bend        the axis becomes the parabola y = k X^2 / 2, sections stay normal to it
Vec3 bean_point(const Vec3& p) {
  constexpr double kHalfLength = 5.3;
  constexpr double kHalfWidth = 3.05;
  constexpr double kHalfThickness = 2.25;
  constexpr double kSpread = 0.25;
  constexpr double kFullness = 0.35;
  constexpr double kHilumDepth = 1.6;
  constexpr double kCurvature = 0.09;
  const double t = p.x - kSpread * p.x * (1.0 - p.x * p.x);
  // (1 - t^2) / (1 - x^2), without the division by zero at the poles.
  const double ratio = (1.0 + kSpread * p.x * (1.0 + p.x)) * (1.0 - kSpread * p.x * (1.0 - p.x));
  const double radius = std::sqrt(ratio * (1.0 + kFullness * t * t));
  const double near_hilum = 0.5 * (1.0 + p.y);
  const double dent = near_hilum * near_hilum * near_hilum;
  const double y = kHalfWidth * radius * p.y - kHilumDepth * dent * dent;
  const double along = kHalfLength * t;
  const double slope = kCurvature * along;
  const double normal = y / std::sqrt(1.0 + slope * slope);
  return {along - slope * normal, 0.5 * slope * along + normal, kHalfThickness * radius * p.z};
}

}  // namespace

TetMesh build_kuhn_cube(int cells_per_side, double jitter, std::uint64_t seed) {
  const Index n = checked_size("cells a side of the cube", cells_per_side, 560);
  if (!(jitter >= 0.0 && jitter <= 0.5)) {
    throw InputError("jitter of the cube", 0, "a number from 0 to 0.5", std::to_string(jitter));
  }
  const Grid grid{{n, n, n}};
  TetMesh mesh = build_kuhn_grid(grid, n);
  if (jitter > 0.0) jitter_inner_points(grid, jitter / n, seed, mesh);
  return mesh;
}

TetMesh build_bar(int cells_per_side) {
  const Index n = checked_size("cells a side of the bar", cells_per_side, 350);
  return build_kuhn_grid({{4 * n, n, n}}, n);
}

SurfaceMesh build_bar_surface(int cells_per_side) {
  const TetMesh bar = build_bar(cells_per_side);
  SurfaceMesh skin;
  skin.triangles = build_boundary(bar);
  std::vector<Index> place(bar.points.size(), kNoIndex);
  for (Triangle& t : skin.triangles) {
    for (Index& v : t) {
      if (place[v] == kNoIndex) {
        place[v] = static_cast<Index>(skin.points.size());
        skin.points.push_back(bar.points[v]);
      }
      v = place[v];
    }
  }
  return skin;
}

TetMesh build_bcc_bar(int cells_per_side) {
  const Index n = checked_size("cells a side of the BCC bar", cells_per_side, 270);
  const Grid grid{{4 * n, n, n}};
  const std::size_t boundary_faces = std::size_t{18} * n * n;
  TetMesh mesh;
  mesh.points.reserve(grid.point_count() + grid.cell_count() + boundary_faces);
  add_grid_points(grid, n, mesh.points);
  for (Index k = 0; k < grid.cells[2]; ++k) {
    for (Index j = 0; j < grid.cells[1]; ++j) {
      for (Index i = 0; i < grid.cells[0]; ++i) {
        mesh.points.push_back({(i + 0.5) / n, (j + 0.5) / n, (k + 0.5) / n});
      }
    }
  }
  mesh.tets.reserve(12 * grid.cell_count() + 2 * boundary_faces);
  for (std::size_t axis = 0; axis < 3; ++axis) add_bcc_tets(grid, n, axis, mesh);
  return mesh;
}

SurfaceMesh build_geodesic_sphere(int frequency) {
  const Index f = checked_size("frequency of the geodesic sphere", frequency, 1000);
  const Icosahedron solid;
  const GeodesicNumbers number(solid, f);
  SurfaceMesh sphere;
  sphere.points.resize(std::size_t{10} * f * f + 2);
  sphere.triangles.reserve(std::size_t{20} * f * f);
  for (Index face = 0; face < solid.faces.size(); ++face) {
    const Triangle& corner = solid.faces[face];
    for (Index j = 0; j <= f; ++j) {
      for (Index i = 0; i + j <= f; ++i) {
        const Index v = number.of(solid, face, i, j);
        const Vec3 flat = (f - i - j) * solid.corners[corner[0]] + i * solid.corners[corner[1]] +
                          j * solid.corners[corner[2]];
        sphere.points[v] = on_unit_sphere(flat);
        if (i + j == f) continue;
        const Index right = number.of(solid, face, i + 1, j);
        const Index up = number.of(solid, face, i, j + 1);
        sphere.triangles.push_back({v, right, up});
        if (i + j + 1 < f) sphere.triangles.push_back({right, number.of(solid, face, i + 1, j + 1), up});
      }
    }
  }
  return sphere;
}

SurfaceMesh build_bean_surface(int frequency) {
  SurfaceMesh bean = build_geodesic_sphere(frequency);
  for (Vec3& p : bean.points) p = bean_point(p);
  return bean;
}

}  // namespace palpate

#include "reference/closed_form/structured_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/mesh/orientation.h"
#include "core/mesh/topology.h"

namespace palpate::reference {
namespace {

constexpr int kMostCells = 400;

void check_cells(int cells) {
  if (cells < 1 || cells > kMostCells) {
    throw InputError("cells", 0, "1 to " + std::to_string(kMostCells), std::to_string(cells));
  }
}

int orientation_of(const TetMesh& mesh, const Tet& t) {
  return orientation(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
}

/// Numbers the columns of the triangle grid: row i holds cells + 1 - i of them.
struct TriangleGrid {
  int cells;

  Index columns() const { return static_cast<Index>((cells + 1) * (cells + 2) / 2); }
  Index column(int i, int j) const { return static_cast<Index>(i * (2 * cells + 3 - i) / 2 + j); }
};

/// Splits the prism over the three columns between the layers `low` and `low + columns` into three tets. Each
/// of its quadrilaterals is cut from the bottom of its smaller column, so neighbours agree.
void add_prism(TetMesh& mesh, Triangle columns, Index low, Index layer_size) {
  std::sort(columns.begin(), columns.end());
  Triangle bottom{};
  Triangle top{};
  for (std::size_t i = 0; i < 3; ++i) {
    bottom[i] = low + columns[i];
    top[i] = bottom[i] + layer_size;
  }
  const std::array<Tet, 3> tets{{{bottom[0], bottom[1], bottom[2], top[2]},
                                 {bottom[0], bottom[1], top[1], top[2]},
                                 {bottom[0], top[0], top[1], top[2]}}};
  for (Tet tet : tets) {
    if (orientation_of(mesh, tet) < 0) std::swap(tet[2], tet[3]);
    mesh.tets.push_back(tet);
  }
}

}  // namespace

TetMesh build_mapped_block(const BlockCells& cells, const std::function<Vec3(const Vec3&)>& map) {
  for (const int side : {cells.x, cells.y, cells.z}) check_cells(side);
  TetMesh mesh;
  for (int k = 0; k <= cells.z; ++k) {
    for (int j = 0; j <= cells.y; ++j) {
      for (int i = 0; i <= cells.x; ++i) {
        mesh.points.push_back(map({static_cast<double>(i) / cells.x, static_cast<double>(j) / cells.y,
                                   static_cast<double>(k) / cells.z}));
      }
    }
  }
  const Index row = static_cast<Index>(cells.x) + 1;
  const std::array<Index, 3> step{1, row, row * (static_cast<Index>(cells.y) + 1)};
  for (int k = 0; k < cells.z; ++k) {
    for (int j = 0; j < cells.y; ++j) {
      for (int i = 0; i < cells.x; ++i) {
        const Index corner =
            static_cast<Index>(i) + static_cast<Index>(j) * step[1] + static_cast<Index>(k) * step[2];
        std::array<std::size_t, 3> axes{0, 1, 2};
        do {  // one tet for each way from the corner to the opposite one
          Tet tet{corner, 0, 0, 0};
          for (std::size_t s = 0; s < 3; ++s) tet[s + 1] = tet[s] + step[axes[s]];
          const bool is_even = axes[1] == (axes[0] + 1) % 3;
          if (!is_even) std::swap(tet[2], tet[3]);
          require(orientation_of(mesh, tet) > 0, "build_mapped_block: the map turns a tet over");
          mesh.tets.push_back(tet);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
    }
  }
  return mesh;
}

TetMesh build_shell_octant(int cells, int layers, double inner, double outer) {
  check_cells(cells);
  check_cells(layers);
  if (!(inner > 0.0 && outer > inner && std::isfinite(outer))) {
    throw InputError("radii of a shell", 0, "0 < inner < outer",
                     std::to_string(inner) + " and " + std::to_string(outer));
  }
  const TriangleGrid grid{cells};
  TetMesh mesh;
  for (int layer = 0; layer <= layers; ++layer) {
    const double radius = inner + (outer - inner) * layer / layers;
    for (int i = 0; i <= cells; ++i) {
      for (int j = 0; j <= cells - i; ++j) {
        const Vec3 flat{static_cast<double>(cells - i - j), static_cast<double>(i), static_cast<double>(j)};
        mesh.points.push_back((radius / length(flat)) * flat);
      }
    }
  }
  for (int layer = 0; layer < layers; ++layer) {
    const Index low = static_cast<Index>(layer) * grid.columns();
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells - i; ++j) {
        add_prism(mesh, {grid.column(i, j), grid.column(i + 1, j), grid.column(i, j + 1)}, low,
                  grid.columns());
        if (i + j + 2 > cells) continue;
        add_prism(mesh, {grid.column(i + 1, j), grid.column(i + 1, j + 1), grid.column(i, j + 1)}, low,
                  grid.columns());
      }
    }
  }
  return mesh;
}

std::vector<Triangle> select_boundary(const TetMesh& mesh, const std::function<bool(const Vec3&)>& holds) {
  std::vector<Triangle> selected;
  for (const Triangle& face : build_boundary(mesh)) {
    if (std::all_of(face.begin(), face.end(), [&](Index v) { return holds(mesh.points[v]); })) {
      selected.push_back(face);
    }
  }
  return selected;
}

}  // namespace palpate::reference

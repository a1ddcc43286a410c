#include "tests/support/small_meshes.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace palpate::testing_support {
namespace {

constexpr std::array<std::array<int, 3>, 6> kAxisOrders{
    {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};

/// Grid points sort by z, then y, then x.
Cell sort_key(const Cell& p) {
  return {p[2], p[1], p[0]};
}

}  // namespace

TetMesh make_corner_tet() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
}

TetMesh make_regular_tet() {
  return {{{0, 0, 0},
           {1, 0, 0},
           {0.5, std::sqrt(3.0) / 2.0, 0},
           {0.5, std::sqrt(3.0) / 6.0, std::sqrt(6.0) / 3.0}},
          {{0, 1, 2, 3}}};
}

TetMesh make_kuhn_cells(std::span<const Cell> cells) {
  std::map<Cell, Index> numbers;
  for (const Cell& cell : cells) {
    for (int corner = 0; corner < 8; ++corner) {
      numbers[sort_key({cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2)})] = 0;
    }
  }
  TetMesh mesh;
  for (auto& [key, number] : numbers) {
    number = static_cast<Index>(mesh.points.size());
    mesh.points.push_back(
        {static_cast<double>(key[2]), static_cast<double>(key[1]), static_cast<double>(key[0])});
  }
  for (const Cell& cell : cells) {
    for (std::size_t order = 0; order < kAxisOrders.size(); ++order) {
      Tet tet{};
      Cell at = cell;
      tet[0] = numbers.at(sort_key(at));
      for (std::size_t step = 0; step < 3; ++step) {
        ++at[static_cast<std::size_t>(kAxisOrders[order][step])];
        tet[step + 1] = numbers.at(sort_key(at));
      }
      if (order >= 3) std::swap(tet[2], tet[3]);  // odd orders of the axes turn the other way
      mesh.tets.push_back(tet);
    }
  }
  return mesh;
}

TetMesh make_kuhn_block(int nx, int ny, int nz) {
  std::vector<Cell> cells;
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) cells.push_back({x, y, z});
    }
  }
  return make_kuhn_cells(cells);
}

TetMesh make_cube_ring() {
  std::vector<Cell> cells;
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) {
      if (x != 1 || y != 1) cells.push_back({x, y, 0});
    }
  }
  return make_kuhn_cells(cells);
}

TetMesh make_hollow_cube() {
  std::vector<Cell> cells;
  for (int i = 0; i < 27; ++i) {
    if (i != 13) cells.push_back({i % 3, i / 3 % 3, i / 9});
  }
  return make_kuhn_cells(cells);
}

Index block_vertex(int nx, int ny, int x, int y, int z) {
  return static_cast<Index>((z * (ny + 1) + y) * (nx + 1) + x);
}

std::vector<Index> interior_vertices_of_block(int nx, int ny, int nz) {
  std::vector<Index> interior;
  for (int z = 1; z < nz; ++z) {
    for (int y = 1; y < ny; ++y) {
      for (int x = 1; x < nx; ++x) interior.push_back(block_vertex(nx, ny, x, y, z));
    }
  }
  return interior;
}

TetMesh make_two_tets() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}}, {{0, 1, 2, 3}, {0, 2, 1, 4}}};
}

int count_shared(const Tet& a, const Tet& b) {
  return static_cast<int>(
      std::count_if(a.begin(), a.end(), [&](Index v) { return std::count(b.begin(), b.end(), v); }));
}

TetMesh join_meshes(const TetMesh& a, const TetMesh& b) {
  TetMesh both = a;
  const auto shift = static_cast<Index>(a.points.size());
  both.points.insert(both.points.end(), b.points.begin(), b.points.end());
  for (Tet tet : b.tets) {
    for (Index& v : tet) v += shift;
    both.tets.push_back(tet);
  }
  return both;
}

TetMesh translated(TetMesh mesh, const Vec3& by) {
  for (Vec3& p : mesh.points) p = p + by;
  return mesh;
}

SurfaceMesh random_triangles(int triangles, double size, SplitMix64& random) {
  const auto point = [&](double extent) {
    return Vec3{extent * random.uniform(), extent * random.uniform(), extent * random.uniform()};
  };
  SurfaceMesh soup;
  for (Index i = 0; i < static_cast<Index>(triangles); ++i) {
    const Vec3 corner = point(1.0);
    for (int k = 0; k < 3; ++k) soup.points.push_back(corner + point(size));
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return soup;
}

}  // namespace palpate::testing_support

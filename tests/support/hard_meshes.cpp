#include "tests/support/hard_meshes.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/subdivision/bisection.h"
#include "core/mesh/topology.h"
#include "core/simplify/sizing/triangle_tree.h"
#include "tests/support/marching_tets.h"

namespace palpate::testing_support {
namespace {

std::vector<Cell> plate(int nx, int ny, int nz, const std::vector<Cell>& without) {
  std::vector<Cell> cells;
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        const Cell cell{x, y, z};
        if (std::find(without.begin(), without.end(), cell) == without.end()) cells.push_back(cell);
      }
    }
  }
  return cells;
}

bool are_positive(const TetMesh& mesh, std::span<const Index> tets) {
  return std::all_of(tets.begin(), tets.end(), [&](Index t) {
    const Tet& v = mesh.tets[t];
    return orientation(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]) > 0;
  });
}

std::vector<Index> inner_vertices(const TetMesh& mesh) {
  const std::vector<std::uint8_t> flags = build_boundary_vertex_flags(mesh);
  std::vector<Index> inner;
  for (Index v = 0; v < flags.size(); ++v) {
    if (flags[v] == 0) inner.push_back(v);
  }
  return inner;
}

/// The face of `tet` opposite to v, such that (v, face) is positive.
Triangle face_opposite(const Tet& tet, Index v) {
  const auto corner = static_cast<std::size_t>(std::find(tet.begin(), tet.end(), v) - tet.begin());
  const auto& f = kTetFaces[corner];
  return {tet[static_cast<std::size_t>(f[0])], tet[static_cast<std::size_t>(f[1])],
          tet[static_cast<std::size_t>(f[2])]};
}

}  // namespace

std::vector<Cell> divided(std::span<const Cell> cells, int n) {
  std::vector<Cell> fine;
  for (const Cell& c : cells) {
    for (int i = 0; i < n * n * n; ++i)
      fine.push_back({c[0] * n + i % n, c[1] * n + i / n % n, c[2] * n + i / (n * n)});
  }
  return fine;
}

TetMesh make_three_holes(int n, std::uint64_t seed) {
  const auto cells = plate(7, 3, 1, {{1, 1, 0}, {3, 1, 0}, {5, 1, 0}});
  return shaken(make_kuhn_cells(divided(cells, n)), 0.3, seed);
}

TetMesh make_divided_ring(int n, std::uint64_t seed) {
  return shaken(make_kuhn_cells(divided(plate(3, 3, 1, {{1, 1, 0}}), n)), 0.3, seed);
}

TetMesh make_divided_hollow(int n, std::uint64_t seed) {
  return shaken(make_kuhn_cells(divided(plate(3, 3, 3, {{1, 1, 1}}), n)), 0.3, seed);
}

TetMesh make_three_parts(int n, std::uint64_t seed) {
  const TetMesh ball = shaken(make_kuhn_block(2 * n, 2 * n, 2 * n), 0.3, seed);
  const double apart = 10.0 * n;
  return join_meshes(join_meshes(ball, translated(ball, {apart, 0, 0})),
                     translated(make_divided_ring(n, seed + 1), {0, apart, 0}));
}

namespace {

/// Moves these vertices by up to `amount` per axis, less where a tet would not stay positive.
TetMesh moved(TetMesh mesh, const std::vector<Index>& vertices, double amount, std::uint64_t seed) {
  SplitMix64 random(seed);
  const VertexStars stars = build_vertex_stars(mesh);
  for (const Index v : vertices) {
    const auto one = [&] { return amount * (2.0 * random.uniform() - 1.0); };
    const double x = one();
    const double y = one();
    Vec3 by{x, y, one()};
    const Vec3 from = mesh.points[v];
    for (int halvings = 0; halvings < 8; ++halvings) {
      mesh.points[v] = from + by;
      if (are_positive(mesh, stars.of(v))) break;
      by = 0.5 * by;
      mesh.points[v] = from;
    }
  }
  return mesh;
}

}  // namespace

TetMesh shaken(TetMesh mesh, double amount, std::uint64_t seed) {
  const std::vector<Index> inner = inner_vertices(mesh);
  return moved(std::move(mesh), inner, amount, seed);
}

TetMesh roughened(TetMesh mesh, double amount, std::uint64_t seed) {
  const std::vector<std::uint8_t> flags = build_boundary_vertex_flags(mesh);
  std::vector<Index> outer;
  for (Index v = 0; v < flags.size(); ++v) {
    if (flags[v] != 0) outer.push_back(v);
  }
  return moved(std::move(mesh), outer, amount, seed);
}

TetMesh with_fine_skin(const TetMesh& mesh, double factor) {
  const simplify::TriangleTree skin(mesh.points, build_boundary(mesh));
  const BoundingBox box = bounding_box(mesh.points);
  const double reach = 0.15 * longest_side(box);
  const auto size = [&](const Vec3& place) { return 0.3 + skin.distance(place, reach) / reach; };
  const auto wanted = static_cast<std::size_t>(factor * static_cast<double>(mesh.points.size()));
  return bisect_edges(mesh, wanted, size).mesh;
}

TetMesh squashed(TetMesh mesh, double relative, std::uint64_t every, std::uint64_t seed) {
  SplitMix64 random(seed);
  const VertexStars stars = build_vertex_stars(mesh);
  for (const Index v : inner_vertices(mesh)) {
    if (random.below(every) != 0) continue;
    const auto star = stars.of(v);
    const Triangle face = face_opposite(mesh.tets[star[random.below(star.size())]], v);
    const Vec3 a = mesh.points[face[0]];
    const Vec3 b = mesh.points[face[1]];
    const Vec3 c = mesh.points[face[2]];
    const Vec3 area = cross(b - a, c - a);
    const double longest = std::sqrt(std::max({length_sq(b - a), length_sq(c - a), length_sq(c - b)}));
    // A third of the way along each side; 6 V = height * |area|, towards v.
    const double height = 6.0 * relative * longest * longest * longest / length(area);
    const Vec3 from = mesh.points[v];
    mesh.points[v] = (1.0 / 3.0) * (a + b + c) - (height / length(area)) * area;
    if (!are_positive(mesh, star)) mesh.points[v] = from;
  }
  return mesh;
}

TetMesh stretched(TetMesh mesh, int power_x, int power_y, int power_z) {
  for (Vec3& p : mesh.points)
    p = {std::ldexp(p.x, power_x), std::ldexp(p.y, power_y), std::ldexp(p.z, power_z)};
  return mesh;
}

std::vector<HardMesh> list_hard_meshes(std::uint64_t seed) {
  const TetMesh cube = build_kuhn_cube(8, 0.35, seed);
  std::vector<HardMesh> all{
      {"single tet", make_regular_tet()},
      {"two tets", make_two_tets()},
      {"all vertices on the boundary", make_kuhn_block(1, 1, 9)},
      {"one inner vertex", make_kuhn_block(2, 2, 2)},
      {"genus 1", make_divided_ring(4, seed)},
      {"genus 3", make_three_holes(4, seed)},
      {"cavity", make_divided_hollow(3, seed)},
      {"three parts", make_three_parts(4, seed)},
      {"cube, all ties", build_kuhn_cube(7, 0.0, 0)},
      {"lattice bar", build_bcc_bar(4)},
      {"slivers", stretched(cube, 0, 0, -24)},
      {"needles", stretched(cube, -20, -20, 0)},
      {"slivers in a needle", stretched(cube, -30, 0, -12)},
      {"rough skin", roughened(build_kuhn_cube(6, 0.2, seed), 0.04, seed)},
      {"fine skin", with_fine_skin(roughened(build_kuhn_cube(5, 0.2, seed), 0.04, seed), 3.0)},
      {"fine skin, genus 1", with_fine_skin(roughened(make_divided_ring(2, seed), 0.2, seed), 4.0)},
      {"fine skin, genus 3", with_fine_skin(roughened(make_three_holes(2, seed), 0.2, seed), 3.0)},
      {"fine skin, cavity", with_fine_skin(roughened(make_divided_hollow(2, seed), 0.2, seed), 3.0)},
      {"fine skin, flat",
       stretched(with_fine_skin(roughened(make_three_holes(2, seed), 0.2, seed), 3.0), 0, 0, -6)},
      {"tiny", stretched(cube, -100, -100, -100)},
      {"huge", stretched(cube, 90, 90, 90)},
  };
  for (const double relative : {1e-6, 1e-10, 1e-14}) {
    all.push_back({"tets of relative volume " + std::to_string(static_cast<int>(std::log10(relative))),
                   squashed(build_kuhn_cube(8, 0.2, seed), relative, 4, seed)});
  }
  for (const double offset : {1e6, 1e9}) {
    all.push_back({"far from the origin", translated(cube, {offset, -offset, 0.5 * offset})});
    all.push_back(
        {"squashed and far from the origin",
         translated(squashed(build_kuhn_cube(8, 0.2, seed), 1e-5, 4, seed), {offset, offset, offset})});
  }
  all.push_back({"a scanner's skin, genus 1", make_marching_ring(2)});
  return all;
}

}  // namespace palpate::testing_support

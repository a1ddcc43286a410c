#include "tests/support/operation_fuzz/random_body.h"

#include <algorithm>
#include <vector>

#include "core/judge/mesh/judge.h"
#include "core/mesh/orientation.h"
#include "core/mesh/shapes/body_surfaces.h"
#include "core/mesh/shapes/shapes.h"
#include "core/simplify/refined/refined.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/small_meshes.h"

namespace palpate::testing_support {
namespace {

bool is_one_manifold(const TetMesh& mesh) {
  return judge::check_validity(mesh).is_valid() && judge::count_elements(mesh).components == 1;
}

void add_positive(TetMesh& mesh, Tet tet) {
  const std::vector<Vec3>& p = mesh.points;
  if (orientation(p[tet[0]], p[tet[1]], p[tet[2]], p[tet[3]]) < 0) std::swap(tet[2], tet[3]);
  mesh.tets.push_back(tet);
}

/// The outer skin kept, the inside coarsened: what a scanned organ looks like after simplification.
TetMesh with_fine_skin(TetMesh mesh) {
  simplify::RefinedOptions options;
  options.stop.ratio = 0.5;
  simplify_refined(mesh, options);
  return mesh;
}

TetMesh make_random_shells(SplitMix64& random) {
  const auto frequency = static_cast<int>(2 + random.below(4));
  const SurfaceMesh skin =
      random.below(2) == 0 ? build_geodesic_sphere(frequency) : build_lobes_surface(frequency);
  const auto layers = static_cast<int>(1 + random.below(3));
  const double shrink = 0.5 + 0.35 * random.uniform();
  TetMesh mesh = make_shells(skin, layers, shrink, layers > 1 && random.below(3) == 0);
  return shaken(std::move(mesh), 0.1, random.next());
}

}  // namespace

TetMesh make_random_cells(SplitMix64& random) {
  const bool is_plate = random.below(2) == 0;
  const auto nx = static_cast<int>(is_plate ? 3 + random.below(4) : 2 + random.below(3));
  const auto ny = static_cast<int>(is_plate ? 3 + random.below(3) : 2 + random.below(3));
  const auto nz = static_cast<int>(is_plate ? 1 : 2 + random.below(2));
  std::vector<Cell> cells;
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) cells.push_back({x, y, z});
    }
  }
  const std::uint64_t wanted_out = random.below(1 + cells.size() / 2);
  for (std::uint64_t out = 0, tries = 0; out < wanted_out && tries < 4 * cells.size(); ++tries) {
    std::vector<Cell> left = cells;
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(random.below(left.size())));
    if (!is_one_manifold(make_kuhn_cells(left))) continue;
    cells = std::move(left);
    ++out;
  }
  const int finer = cells.size() > 20 ? 2 : 3;
  return shaken(make_kuhn_cells(divided(cells, finer)), 0.4 * random.uniform(), random.next());
}

TetMesh make_shells(const SurfaceMesh& skin, int layers, double shrink, bool is_hollow) {
  TetMesh mesh;
  const auto count = static_cast<Index>(skin.points.size());
  double scale = 1.0;
  for (int layer = 0; layer <= layers; ++layer, scale *= shrink) {
    for (const Vec3& p : skin.points) mesh.points.push_back(scale * p);
  }
  for (Index layer = 0; layer < static_cast<Index>(layers); ++layer) {
    for (Triangle face : skin.triangles) {
      std::sort(face.begin(), face.end());  // neighbours then cut the wall between them alike
      const Index out = layer * count;
      const Index in = out + count;
      const auto [a, b, c] = face;
      add_positive(mesh, {out + a, out + b, out + c, in + c});
      add_positive(mesh, {out + a, out + b, in + b, in + c});
      add_positive(mesh, {out + a, in + a, in + b, in + c});
    }
  }
  if (is_hollow) return mesh;
  const auto middle = static_cast<Index>(mesh.points.size());
  const Index last = static_cast<Index>(layers) * count;
  mesh.points.push_back({});
  for (const Triangle& face : skin.triangles)
    add_positive(mesh, {last + face[0], last + face[1], last + face[2], middle});
  return mesh;
}

RandomBody make_random_body(std::uint64_t seed) {
  SplitMix64 random(seed);
  const auto side = static_cast<int>(4 + random.below(4));
  switch (random.below(8)) {
    case 0:
    case 1:
      return {"cells with handles and cavities", make_random_cells(random)};
    case 2:
    case 3:
      return {"shells", make_random_shells(random)};
    case 4:
      return {"fine skin", with_fine_skin(build_kuhn_cube(side + 2, 0.35, random.next()))};
    case 5:
      return {"fine skin with a cavity", with_fine_skin(make_divided_hollow(2, random.next()))};
    case 6:
      return {"near to flat tets",
              squashed(build_kuhn_cube(side, 0.2, random.next()), 1e-9, 4, random.next())};
    default:
      return {"slivers", stretched(build_kuhn_cube(side, 0.4, random.next()), 0,
                                   -static_cast<int>(random.below(10)), -static_cast<int>(random.below(20)))};
  }
}

}  // namespace palpate::testing_support

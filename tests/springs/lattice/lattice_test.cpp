// Cells cut to a body: volumes that are known, and what the boundary options make of them.
#include "core/springs/lattice/lattice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/springs/lattice/cell_faces.h"
#include "core/springs/lattice/cell_volumes.h"
#include "tests/support/small_meshes.h"

namespace palpate::springs {
namespace {

using testing::HasSubstr;
using testing_support::make_kuhn_cells;

TetMesh scaled(TetMesh mesh, double factor, const Vec3& shift = {}) {
  for (Vec3& x : mesh.points) x = factor * x + shift;
  return mesh;
}

TEST(CellVolumes, OfACornerCutByAPlane) {
  const TetMesh tet{{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}}, {{0, 1, 2, 3}}};
  const std::vector<double> volumes = measure_cell_volumes(tet, {2, 2, 2});
  const std::vector<double> expected{5.0 / 6, 1.0 / 6, 1.0 / 6, 0, 1.0 / 6, 0, 0, 0};
  for (std::size_t cell = 0; cell < 8; ++cell) EXPECT_NEAR(volumes[cell], expected[cell], 1e-15) << cell;
}

TEST(CellVolumes, AddUpToTheBodyOnAnyGrid) {
  const TetMesh body = build_kuhn_cube(4, 0.3, 11);
  for (const double cells : {1.0, 2.7, 5.3, 9.9}) {
    const int size = static_cast<int>(std::ceil(cells)) + 1;
    const TetMesh in_cells = scaled(body, cells, {0.31, 0.17, 0.53});
    const std::vector<double> volumes = measure_cell_volumes(in_cells, {size, size, size});
    const double sum = std::accumulate(volumes.begin(), volumes.end(), 0.0);
    EXPECT_NEAR(sum, cells * cells * cells, 1e-12 * sum);
    // The cube's own overlap with a cell, side by side.
    const auto overlap = [&](int i, double from) {
      return std::max(0.0, std::min(i + 1.0, from + cells) - std::max<double>(i, from));
    };
    for (int k = 0; k < size; ++k) {
      for (int j = 0; j < size; ++j) {
        for (int i = 0; i < size; ++i) {
          const double exact = overlap(i, 0.31) * overlap(j, 0.17) * overlap(k, 0.53);
          EXPECT_NEAR(volumes[static_cast<std::size_t>(i + size * (j + size * k))], exact, 1e-12);
        }
      }
    }
  }
}

TEST(CellFaces, PartsLieInOneCellAndAddUp) {
  SplitMix64 random(5);
  const auto point = [&] {
    return Vec3{6.0 * random.uniform() - 3.0, 6.0 * random.uniform() - 3.0, 6.0 * random.uniform() - 3.0};
  };
  for (int k = 0; k < 50; ++k) {
    const std::array<Vec3, 3> face{point(), point(), point()};
    const Vec3 whole = cross(face[1] - face[0], face[2] - face[0]);
    Vec3 sum;
    for (const std::array<Vec3, 3>& part : split_at_cells(face)) {
      const Vec3 area = cross(part[1] - part[0], part[2] - part[0]);
      EXPECT_GT(dot(area, whole), 0.0);
      sum = sum + area;
      const Vec3 middle = (1.0 / 3.0) * (part[0] + part[1] + part[2]);
      for (const Vec3& corner : part) {
        for (const double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
          EXPECT_GE(corner.*axis, std::floor(middle.*axis) - 1e-12);
          EXPECT_LE(corner.*axis, std::floor(middle.*axis) + 1.0 + 1e-12);
        }
      }
    }
    EXPECT_NEAR(length(sum - whole), 0.0, 1e-12 * length(whole));
  }
  // A face in a plane between cells stays whole across it.
  EXPECT_EQ(split_at_cells({Vec3{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}).size(), 1U);
}

TEST(Lattice, FillsACubeExactly) {
  const TetMesh body = scaled(build_kuhn_cube(3, 0.2, 4), 0.06, {0.01, -0.02, 0.03});
  for (const LatticeKind kind : {LatticeKind::kHexahedral, LatticeKind::kBodyCentred}) {
    LatticeOptions options;
    options.kind = kind;
    options.spacing_m = 0.015;
    for (const LatticeBoundary boundary :
         {LatticeBoundary::kKeep, LatticeBoundary::kRemove, LatticeBoundary::kWeight}) {
      options.boundary = boundary;
      const Lattice lattice = build_lattice(body, options);
      EXPECT_EQ(lattice.cells(), 64U);
      EXPECT_EQ(lattice.cut_cells(), 0U);
      EXPECT_NEAR(lattice.volume_ratio(), 1.0, 1e-12);
      EXPECT_EQ(lattice.nodes.size(), kind == LatticeKind::kHexahedral ? 125U : 189U);
      const BoundingBox box = bounding_box(lattice.nodes);
      EXPECT_NEAR(length(box.low - Vec3{0.01, -0.02, 0.03}), 0.0, 1e-15);
      EXPECT_NEAR(length(box.high - Vec3{0.07, 0.04, 0.09}), 0.0, 1e-15);
    }
  }
}

TEST(Lattice, BoundaryOptionsKeepRemoveAndWeight) {
  // 2.5 cells a side: of 27 cells 1 is full, 6 are filled by 3/4, 12 by 9/16 and 8 by 27/64.
  const TetMesh body = build_kuhn_cube(2, 0.0, 1);
  LatticeOptions options;
  options.spacing_m = 0.4;
  options.boundary = LatticeBoundary::kWeight;
  const Lattice weighted = build_lattice(body, options);
  EXPECT_EQ(weighted.cells(), 27U);
  EXPECT_EQ(weighted.cut_cells(), 26U);
  EXPECT_NEAR(weighted.volume_ratio(), 1.0, 1e-12);
  EXPECT_NEAR(*std::min_element(weighted.share.begin(), weighted.share.end()), 27.0 / 64, 1e-12);
  options.fraction = 0.6;  // no cell counts less
  EXPECT_NEAR(build_lattice(body, options).volume_ratio(), (1 + 6 * 0.75 + 20 * 0.6) * 0.064, 1e-12);
  options.boundary = LatticeBoundary::kKeep;
  options.fraction.reset();
  EXPECT_NEAR(build_lattice(body, options).volume_ratio(), 1.728, 1e-12);
  options.fraction = 0.5;
  EXPECT_EQ(build_lattice(body, options).cells(), 19U);
  options.boundary = LatticeBoundary::kRemove;
  options.fraction.reset();
  EXPECT_NEAR(build_lattice(body, options).volume_ratio(), 19 * 0.064, 1e-12);
  options.fraction = 0.7;
  EXPECT_EQ(build_lattice(body, options).cells(), 7U);
}

TEST(Lattice, FindsASpacingForACount) {
  const TetMesh body = scaled(build_kuhn_cube(9, 0.2, 2), 0.05);
  for (const LatticeKind kind : {LatticeKind::kHexahedral, LatticeKind::kBodyCentred}) {
    LatticeOptions options;
    options.kind = kind;
    options.turn_deg = 25.0;
    const auto wanted = static_cast<double>(body.points.size());
    EXPECT_NEAR(static_cast<double>(build_lattice(body, options).nodes.size()), wanted, 0.05 * wanted);
    options.vertices = 400;
    EXPECT_NEAR(static_cast<double>(build_lattice(body, options).nodes.size()), 400.0, 40.0);
  }
}

TEST(Lattice, TurnsAboutTheDiagonal) {
  // A third of a turn takes the axes to each other: the same cells. A sixth does not.
  const TetMesh body = build_bar(2);
  LatticeOptions options;
  options.spacing_m = 0.25;
  const std::size_t straight = build_lattice(body, options).cells();
  options.turn_deg = 120.0;
  const Lattice turned = build_lattice(body, options);
  EXPECT_EQ(turned.cells(), straight);
  EXPECT_NEAR(length(turned.frame.axes[0] - Vec3{0, 1, 0}), 0.0, 1e-15);
  options.turn_deg = 60.0;
  const Lattice sixth = build_lattice(body, options);
  EXPECT_GT(sixth.cells(), straight);
  EXPECT_NEAR(sixth.volume_ratio(), 1.0, 0.05);  // but for the least share of a cell
  const Vec3 there{1.3, 0.2, 0.7};
  EXPECT_NEAR(length(sixth.frame.to_body(sixth.frame.to_cells(there)) - there), 0.0, 1e-14);
}

TEST(Lattice, LeavesOutWhatHingesAndRefusesWhatFallsApart) {
  LatticeOptions options;
  options.spacing_m = 1.0;
  // A row of cells, and one at its end that touches it by an edge alone: two groups.
  std::vector<testing_support::Cell> cells{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {5, 1, 0}};
  try {
    build_lattice(make_kuhn_cells(cells), options);
    FAIL() << "a sixth of the body hangs on an edge";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("2 groups"));
  }
  // A block with one such cell in two hundred does without it.
  cells.clear();
  for (int k = 0; k < 200; ++k) cells.push_back({k % 10, k / 10 % 5, k / 50});
  cells.push_back({10, 5, 0});
  const Lattice lattice = build_lattice(make_kuhn_cells(cells), options);
  EXPECT_EQ(lattice.cells(), 200U);
  EXPECT_EQ(lattice.loose_cells, 1U);
}

TEST(Lattice, RefusesBadOptions) {
  const TetMesh body = build_kuhn_cube(2, 0.0, 1);
  const auto message = [&](const LatticeOptions& options) -> std::string {
    try {
      build_lattice(body, options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  LatticeOptions options;
  options.spacing_m = 1e-4;
  EXPECT_THAT(message(options), HasSubstr("2^25"));
  options.spacing_m = std::nan("");
  EXPECT_THAT(message(options), HasSubstr("spacing_m"));
  options = {};
  options.fraction = 1.5;
  EXPECT_THAT(message(options), HasSubstr("fraction"));
  options.fraction = 0.0;
  EXPECT_THAT(message(options), HasSubstr("without stiffness"));
  options = {};
  options.spacing_m = 3.0;
  options.boundary = LatticeBoundary::kRemove;
  EXPECT_THAT(message(options), HasSubstr("none"));
}

}  // namespace
}  // namespace palpate::springs

#include "core/simplify/sizing/size_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/shapes/shapes.h"
#include "core/simplify/sizing/size_file.h"
#include "core/simplify/sizing/sizing.h"
#include "tests/support/scratch_folder.h"

namespace palpate::simplify {
namespace {

constexpr int kCells = 8;
const TetMesh kCube = build_kuhn_cube(kCells, 0.15, 3);

/// A unit cube's spacing of vertices, times 0.75: the cell of its grid.
double cell_of_cube() {
  return 0.75 * std::cbrt(1.0 / static_cast<double>(kCube.points.size()));
}

double linear_size(const Vec3& x) {
  return (1.0 + 2.0 * x.x) / 3.0;
}

std::vector<double> linear_sizes() {
  std::vector<double> sizes;
  sizes.reserve(kCube.points.size());
  for (const Vec3& p : kCube.points) sizes.push_back(7.0 * linear_size(p));  // any unit
  return sizes;
}

/// The greatest difference between the grid and a linear function, at random places at least `margin` from
/// the cube's sides.
template <typename Function>
double worst_difference(const SizeGrid& grid, double margin, const Function& expected) {
  SplitMix64 random(11);
  double worst = 0.0;
  const auto along = [&] { return margin + (1.0 - 2.0 * margin) * random.uniform(); };
  for (int i = 0; i < 2000; ++i) {
    const double x = along();
    const double y = along();
    const Vec3 p{x, y, along()};
    worst = std::max(worst, std::fabs(grid.at(p) - expected(p)));
  }
  return worst;
}

TEST(SizeGrid, HasALinearFieldExactlyInsideAndNearlyAtTheSides) {
  const SizeGrid grid(kCube, linear_sizes());
  const double rounding = 1e-6;  // values are kept in single precision
  EXPECT_LE(worst_difference(grid, cell_of_cube(), linear_size), rounding);
  // At the sides a node outside counts, whose value is that of a neighbour: a change over a diagonal.
  EXPECT_LE(worst_difference(grid, 0.0, linear_size), 2.0 / 3.0 * std::sqrt(3.0) * cell_of_cube());
  EXPECT_NEAR(grid.least(), 1.0 / 3.0, 2.0 / 3.0 * cell_of_cube());
  // The check rejects another field.
  EXPECT_GT(worst_difference(grid, cell_of_cube(), [](const Vec3& x) { return (1.0 + 2.0 * x.y) / 3.0; }),
            0.1);
}

TEST(SizeGrid, APlaceOutsideHasTheNearestValue) {
  const SizeGrid grid(kCube, linear_sizes());
  EXPECT_NEAR(grid.at({9.0, 0.5, 0.5}), 1.0, 2.0 / 3.0 * 2.0 * cell_of_cube());
  EXPECT_NEAR(grid.at({-9.0, 0.5, 0.5}), 1.0 / 3.0, 2.0 / 3.0 * 2.0 * cell_of_cube());
}

TEST(SizeGrid, EqualSizesAreNoField) {
  EXPECT_EQ(make_size_grid(kCube, std::vector<double>(kCube.points.size(), 0.3)), nullptr);
  SizingOptions options;
  EXPECT_TRUE(SizingField(options, kCube).is_empty());
  options.sizes = make_size_grid(kCube, linear_sizes());
  const SizingField field(options, kCube);
  EXPECT_FALSE(field.is_empty());
  EXPECT_FALSE(field.keeps_any());
  EXPECT_TRUE(build_kept_tets(field, kCube).empty());
  EXPECT_EQ(field.relative_size({0.5, 0.5, 0.5}), options.sizes->at({0.5, 0.5, 0.5}));
  EXPECT_EQ(field.near_size(), options.sizes->least());
}

TEST(SizeGrid, RoomIsTheIntegralOfTheFieldsThirdPower) {
  SizingOptions options;
  options.sizes = make_size_grid(kCube, linear_sizes());
  // integral of 27 / (1 + 2 x)^3 from 0 to 1 is 27 / 4 (1 - 1 / 9) = 6. A midpoint's value and the sides
  // leave 4%: second order in the cells of 1 / 8.
  EXPECT_NEAR(graded_volume(kCube, SizingField(options, kCube)), 6.0, 0.04 * 6.0);
  EXPECT_NEAR(graded_volume(kCube, SizingField()), 1.0, 1e-12);
}

TEST(SizeGrid, RefusesWhatIsNoSize) {
  const auto with = [](double value) {
    std::vector<double> sizes = linear_sizes();
    sizes[5] = value;
    return sizes;
  };
  for (const double value :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e5})
    EXPECT_THROW(make_size_grid(kCube, with(value)), InputError) << value;
  std::vector<double> few = linear_sizes();
  few.pop_back();
  EXPECT_THROW(make_size_grid(kCube, few), InputError);
}

TEST(SizeFile, ReadsBackToTheSameBits) {
  const test::ScratchFolder folder;
  const std::vector<double> sizes{1.0 / 3.0, 1e-9, 12345.678, 2.0};
  write_sizes(folder / "sizes.csv", sizes);
  EXPECT_EQ(read_sizes(folder / "sizes.csv", 4), sizes);
}

TEST(SizeFile, RefusesWithPlaceAndReason) {
  const test::ScratchFolder folder;
  const auto message = [&](const std::string& text, std::size_t vertices = 2) {
    std::ofstream(folder / "sizes.csv") << text;
    try {
      read_sizes(folder / "sizes.csv", vertices);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_EQ(message("vertex,size\n0,1\n1,2\n"), "no error");
  for (const char* row : {"1,nan", "1,-2", "1,0", "1,inf", "1,", "2,1", "1;2", "1,2,3", "1,2 "})
    EXPECT_NE(message("vertex,size\n0,1\n" + std::string(row) + "\n").find("sizes.csv:3"), std::string::npos)
        << row;
  EXPECT_NE(message("v,s\n0,1\n1,2\n").find("vertex,size"), std::string::npos);
  EXPECT_NE(message("vertex,size\n0,1\n").find("2 rows"), std::string::npos);
  EXPECT_NE(message("vertex,size\n0,1\n1,2\n2,3\n").find("2 rows"), std::string::npos);
  EXPECT_THROW(read_sizes(folder / "none.csv", 2), InputError);
}

}  // namespace
}  // namespace palpate::simplify

#include "tests/support/lattices.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace palpate::springs {
namespace {

constexpr int kMostCells = 200;

void check_block(const LatticeBlock& block) {
  for (const int cells : block.cells) {
    if (cells < 1 || cells > kMostCells)
      throw InputError("cells", 0, "1 to " + std::to_string(kMostCells) + " a side", std::to_string(cells));
  }
  const auto check_positive = [](double value, const char* what) {
    if (!(value > 0.0) || !std::isfinite(value))
      throw InputError(what, 0, "a finite number above 0", std::to_string(value));
  };
  check_positive(block.spacing_m, "spacing_m");
  check_positive(block.young_modulus_pa, "young_modulus_pa");
}

/// One grid of points, nx x ny x nz, numbered from `first` on.
struct Grid {
  std::array<int, 3> size;
  Index first = 0;

  std::size_t count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]);
  }
  bool holds(const std::array<int, 3>& at) const {
    return at[0] < size[0] && at[1] < size[1] && at[2] < size[2];
  }
  Index number(const std::array<int, 3>& at) const {
    return first + static_cast<Index>(at[0] + size[0] * (at[1] + size[1] * at[2]));
  }
};

/// Calls visit({i, j, l}) for each point of the grid, in order.
template <typename Visit>
void for_each_point(const Grid& grid, Visit&& visit) {
  for (int l = 0; l < grid.size[2]; ++l) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) visit(std::array<int, 3>{i, j, l});
    }
  }
}

void add_points(const Grid& grid, double spacing, double shift, std::vector<Vec3>& points) {
  for_each_point(grid, [&](const std::array<int, 3>& at) {
    points.push_back({spacing * (at[0] + shift), spacing * (at[1] + shift), spacing * (at[2] + shift)});
  });
}

/// What one cell gives to one pair of vertices.
struct Share {
  Edge pair;
  double rest_length = 0.0;
  double stiffness = 0.0;
};

Edge in_order(Index a, Index b) {
  return {std::min(a, b), std::max(a, b)};
}

/// Adds up the shares of each pair.
SpringNetwork merge_shares(std::vector<Share> shares) {
  std::stable_sort(shares.begin(), shares.end(),
                   [](const Share& a, const Share& b) { return a.pair < b.pair; });
  SpringNetwork network;
  for (const Share& share : shares) {
    if (network.springs.empty() || network.springs.back() != share.pair) {
      network.springs.push_back(share.pair);
      network.rest_length_m.push_back(share.rest_length);
      network.stiffness_n_per_m.push_back(0.0);
    }
    network.stiffness_n_per_m.back() += share.stiffness;
  }
  return network;
}

std::array<int, 3> corner_of(const std::array<int, 3>& cell, int corner) {
  return {cell[0] + (corner & 1), cell[1] + ((corner >> 1) & 1), cell[2] + ((corner >> 2) & 1)};
}

/// The springs between the corners of one cell; `shares[n]` is what a pair that differs in n + 1 coordinates
/// gets. A share of zero makes no spring.
void add_cell_springs(const Grid& corners, const std::array<int, 3>& cell, double spacing,
                      const std::array<double, 3>& stiffness, std::vector<Share>& shares) {
  for (int a = 0; a < 8; ++a) {
    for (int b = a + 1; b < 8; ++b) {
      const int differing = a ^ b;
      const int n = (differing & 1) + ((differing >> 1) & 1) + ((differing >> 2) & 1);
      const double k = stiffness[static_cast<std::size_t>(n - 1)];
      if (k == 0.0) continue;
      shares.push_back({in_order(corners.number(corner_of(cell, a)), corners.number(corner_of(cell, b))),
                        std::sqrt(static_cast<double>(n)) * spacing, k});
    }
  }
}

}  // namespace

LatticeNetwork build_hexahedral_network(const LatticeBlock& block, double body_share) {
  check_block(block);
  if (!(body_share >= 0.0 && body_share <= 1.0))
    throw InputError("body_share", 0, "a number from 0 to 1", std::to_string(body_share));
  const double eh = block.young_modulus_pa * block.spacing_m;
  const std::array<double, 3> stiffness{(0.4 + 0.4 * body_share) * eh / 4.0,
                                        0.4 * (1.0 - body_share) * eh / 2.0, 0.3 * body_share * eh};
  const Grid cells{block.cells};
  const Grid corners{{block.cells[0] + 1, block.cells[1] + 1, block.cells[2] + 1}};
  LatticeNetwork lattice;
  add_points(corners, block.spacing_m, 0.0, lattice.points);
  std::vector<Share> shares;
  for_each_point(cells, [&](const std::array<int, 3>& cell) {
    add_cell_springs(corners, cell, block.spacing_m, stiffness, shares);
  });
  lattice.network = merge_shares(std::move(shares));
  return lattice;
}

LatticeNetwork build_bcc_network(const LatticeBlock& block) {
  check_block(block);
  const double h = block.spacing_m;
  const double eh = block.young_modulus_pa * h;
  const Grid corners{{block.cells[0] + 1, block.cells[1] + 1, block.cells[2] + 1}};
  const Grid centers{block.cells, static_cast<Index>(corners.count())};
  LatticeNetwork lattice;
  add_points(corners, h, 0.0, lattice.points);
  add_points(centers, h, 0.5, lattice.points);
  std::vector<Share> shares;
  for_each_point(centers, [&](const std::array<int, 3>& cell) {
    add_cell_springs(corners, cell, h, {0.1 * eh, 0.0, 0.0}, shares);
    const Index center = centers.number(cell);
    for (int corner = 0; corner < 8; ++corner) {
      shares.push_back(
          {{corners.number(corner_of(cell, corner)), center}, 0.5 * std::sqrt(3.0) * h, 0.6 * eh});
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<int, 3> next = cell;
      ++next[axis];
      if (centers.holds(next)) shares.push_back({{center, centers.number(next)}, h, 0.4 * eh});
    }
  });
  lattice.network = merge_shares(std::move(shares));
  return lattice;
}

}  // namespace palpate::springs

#include "core/springs/lattice/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/springs/lattice/cell_volumes.h"

namespace palpate::springs {
namespace {

/// A cell that is fuller than this is full, one that is emptier than the other way round is empty: rounding.
constexpr double kRounding = 1e-9;

/// The axes turned about (1, 1, 1), by Rodrigues' formula.
std::array<Vec3, 3> turned_axes(double degrees) {
  const double angle = degrees * std::numbers::pi / 180.0;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const Vec3 axis = (1.0 / std::sqrt(3.0)) * Vec3{1, 1, 1};
  std::array<Vec3, 3> axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  if (degrees == 0.0) return axes;
  for (Vec3& v : axes) v = c * v + s * cross(axis, v) + ((1.0 - c) * dot(axis, v)) * axis;
  return axes;
}

void check_options(const LatticeOptions& options) {
  const auto check = [](const char* what, double value, double least, double most) {
    if (!(value >= least && value <= most))
      throw InputError(what, 0, "a number from " + std::to_string(least) + " to " + std::to_string(most),
                       std::to_string(value));
  };
  check("fraction", options.fraction.value_or(0.0), 0.0, 1.0);
  if (options.boundary == LatticeBoundary::kWeight && options.fraction == 0.0)
    throw InputError("fraction", 0,
                     "above 0 for boundary weight: a cell of no share leaves its nodes without stiffness",
                     "0");
  check("spacing_m", options.spacing_m, 0.0, std::numeric_limits<double>::max());
  check("turn_deg", options.turn_deg, -180.0, 180.0);
}

double default_fraction(LatticeBoundary boundary) {
  switch (boundary) {
    case LatticeBoundary::kKeep:
      return 0.0;
    case LatticeBoundary::kRemove:
      return 0.5;
    case LatticeBoundary::kWeight:
      return 0.01;
  }
  throw ContractError("default_fraction: unknown boundary");
}

/// The grid of cells of one side in the middle of the body's box.
void lay_grid(const TetMesh& body, double spacing_m, Lattice& lattice) {
  std::vector<Vec3> points;
  points.reserve(body.points.size());
  for (const Vec3& x : body.points)
    points.push_back(
        {dot(lattice.frame.axes[0], x), dot(lattice.frame.axes[1], x), dot(lattice.frame.axes[2], x)});
  const BoundingBox box = bounding_box(points);
  const Vec3 sides = box.high - box.low;
  double places = 1.0;
  const std::array<double, 3> lengths{sides.x, sides.y, sides.z};
  for (std::size_t i = 0; i < 3; ++i) {
    const double cells = std::max(1.0, std::ceil(lengths[i] / spacing_m - kRounding));
    places *= cells;
    lattice.size[i] = static_cast<int>(std::min(cells, 1e9));
  }
  constexpr double kMostPlaces = 1U << 25U;
  if (!(places <= kMostPlaces))
    throw InputError("spacing_m", 0, "at most 2^25 cells in the body's box", std::to_string(places));
  lattice.frame.spacing_m = spacing_m;
  const Vec3 middle = 0.5 * (box.low + box.high);
  const auto start = [&](double centre, int cells) { return centre - 0.5 * spacing_m * cells; };
  lattice.frame.origin_m = lattice.frame.turn(
      {start(middle.x, lattice.size[0]), start(middle.y, lattice.size[1]), start(middle.z, lattice.size[2])});
}

/// How full each place of the grid is.
std::vector<double> measure_filled(const TetMesh& body, const Lattice& lattice) {
  TetMesh scaled{{}, body.tets};
  scaled.points.reserve(body.points.size());
  for (const Vec3& x : body.points) scaled.points.push_back(lattice.frame.to_cells(x));
  std::vector<double> filled = measure_cell_volumes(scaled, lattice.size);
  for (double& phi : filled) {
    if (phi > 1.0 - kRounding) phi = 1.0;
    if (phi < kRounding) phi = 0.0;
  }
  return filled;
}

/// 0 for a cell that is not there.
double share_of(double filled, LatticeBoundary boundary, double fraction) {
  if (filled == 0.0) return 0.0;
  switch (boundary) {
    case LatticeBoundary::kKeep:
      return filled > fraction ? 1.0 : 0.0;
    case LatticeBoundary::kRemove:
      return filled >= fraction ? 1.0 : 0.0;
    case LatticeBoundary::kWeight:
      return std::max(filled, fraction);
  }
  throw ContractError("share_of: unknown boundary");
}

std::array<int, 3> place_of(std::size_t number, const std::array<int, 3>& size) {
  const auto nx = static_cast<std::size_t>(size[0]);
  const auto ny = static_cast<std::size_t>(size[1]);
  return {static_cast<int>(number % nx), static_cast<int>(number / nx % ny),
          static_cast<int>(number / nx / ny)};
}

std::size_t number_of(const std::array<int, 3>& place, const std::array<int, 3>& size) {
  return static_cast<std::size_t>(place[0]) +
         static_cast<std::size_t>(size[0]) *
             (static_cast<std::size_t>(place[1]) +
              static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(place[2]));
}

/// The group of each place that is there: places that a chain of faces joins. kNoIndex elsewhere.
std::vector<Index> group_by_faces(const std::vector<double>& share, const std::array<int, 3>& size,
                                  Index& groups) {
  std::vector<Index> group(share.size(), kNoIndex);
  std::vector<std::size_t> open;
  groups = 0;
  for (std::size_t seed = 0; seed < share.size(); ++seed) {
    if (share[seed] == 0.0 || group[seed] != kNoIndex) continue;
    group[seed] = groups;
    open.assign(1, seed);
    while (!open.empty()) {
      const std::array<int, 3> here = place_of(open.back(), size);
      open.pop_back();
      for (std::size_t side = 0; side < 6; ++side) {
        std::array<int, 3> next = here;
        next[side / 2] += side % 2 == 0 ? -1 : 1;
        if (next[side / 2] < 0 || next[side / 2] >= size[side / 2]) continue;
        const std::size_t number = number_of(next, size);
        if (share[number] == 0.0 || group[number] != kNoIndex) continue;
        group[number] = groups;
        open.push_back(number);
      }
    }
    ++groups;
  }
  return group;
}

/// Sets the share of all cells but the largest group's to 0.
void drop_loose(const std::vector<double>& filled, std::vector<double>& share, Lattice& lattice) {
  Index groups = 0;
  const std::vector<Index> group = group_by_faces(share, lattice.size, groups);
  if (groups == 0)
    throw InputError("lattice", 0, "cells that the body fills: a smaller spacing_m or fraction", "none");
  std::vector<double> held(groups, 0.0);
  for (std::size_t cell = 0; cell < share.size(); ++cell) {
    if (group[cell] != kNoIndex) held[group[cell]] += filled[cell];
  }
  const auto largest = static_cast<Index>(std::max_element(held.begin(), held.end()) - held.begin());
  double all = 0.0;
  for (const double each : held) all += each;
  constexpr double kMostLoose = 0.01;
  if (held[largest] < (1.0 - kMostLoose) * all)
    throw InputError("lattice", 0,
                     "cells that hang together by faces: a smaller spacing_m or fraction, or one body",
                     std::to_string(groups) + " groups, the largest with " +
                         std::to_string(100.0 * held[largest] / all) + "% of their volume");
  for (std::size_t cell = 0; cell < share.size(); ++cell) {
    if (group[cell] == kNoIndex || group[cell] == largest) continue;
    share[cell] = 0.0;
    ++lattice.loose_cells;
  }
}

/// Numbers the cells and makes their nodes.
void number_cells(const std::vector<double>& filled, const std::vector<double>& share, Lattice& lattice) {
  const std::array<int, 3> grid{lattice.size[0] + 1, lattice.size[1] + 1, lattice.size[2] + 1};
  std::vector<Index> node_at(static_cast<std::size_t>(grid[0]) * static_cast<std::size_t>(grid[1]) *
                                 static_cast<std::size_t>(grid[2]),
                             kNoIndex);
  lattice.cell_at.assign(share.size(), kNoIndex);
  for (std::size_t number = 0; number < share.size(); ++number) {
    if (share[number] == 0.0) continue;
    const std::array<int, 3> place = place_of(number, lattice.size);
    lattice.cell_at[number] = static_cast<Index>(lattice.cells());
    lattice.place.push_back(place);
    lattice.filled.push_back(filled[number]);
    lattice.share.push_back(share[number]);
    std::array<Index, 8>& corners = lattice.corners.emplace_back();
    for (std::size_t c = 0; c < 8; ++c) {
      const std::array<int, 3> at{place[0] + static_cast<int>(c % 2), place[1] + static_cast<int>(c / 2 % 2),
                                  place[2] + static_cast<int>(c / 4)};
      Index& node = node_at[number_of(at, grid)];
      if (node == kNoIndex) {
        node = static_cast<Index>(lattice.nodes.size());
        lattice.nodes.push_back(lattice.frame.to_body(
            {static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2])}));
      }
      corners[c] = node;
    }
  }
  if (lattice.kind != LatticeKind::kBodyCentred) return;
  for (const std::array<int, 3>& place : lattice.place) {
    lattice.centres.push_back(static_cast<Index>(lattice.nodes.size()));
    lattice.nodes.push_back(lattice.frame.to_body({place[0] + 0.5, place[1] + 0.5, place[2] + 0.5}));
  }
}

Lattice build_with_spacing(const TetMesh& body, const LatticeOptions& options, double spacing_m) {
  Lattice lattice;
  lattice.kind = options.kind;
  lattice.frame.axes = turned_axes(options.turn_deg);
  lattice.body_volume_m3 = total_volume(body);
  lay_grid(body, spacing_m, lattice);
  const std::vector<double> filled = measure_filled(body, lattice);
  const double fraction = options.fraction.value_or(default_fraction(options.boundary));
  std::vector<double> share;
  share.reserve(filled.size());
  for (const double phi : filled) share.push_back(share_of(phi, options.boundary, fraction));
  drop_loose(filled, share, lattice);
  number_cells(filled, share, lattice);
  return lattice;
}

}  // namespace

Vec3 LatticeFrame::to_cells(const Vec3& x) const {
  const Vec3 d = (1.0 / spacing_m) * (x - origin_m);
  return {dot(axes[0], d), dot(axes[1], d), dot(axes[2], d)};
}

Vec3 LatticeFrame::to_body(const Vec3& cells) const {
  return origin_m + spacing_m * turn(cells);
}

Index Lattice::at(const std::array<int, 3>& where) const {
  for (std::size_t i = 0; i < 3; ++i) {
    if (where[i] < 0 || where[i] >= size[i]) return kNoIndex;
  }
  return cell_at[number_of(where, size)];
}

std::size_t Lattice::cut_cells() const {
  return static_cast<std::size_t>(
      std::count_if(filled.begin(), filled.end(), [](double phi) { return phi < 1.0; }));
}

double Lattice::volume_ratio() const {
  double sum = 0.0;
  for (const double each : share) sum += each;
  return sum * cell_volume_m3() / body_volume_m3;
}

Lattice build_lattice(const TetMesh& body, const LatticeOptions& options) {
  check_options(options);
  if (options.spacing_m > 0.0) return build_with_spacing(body, options, options.spacing_m);
  constexpr int kMostTries = 8;
  constexpr double kNearEnough = 0.02;
  constexpr double kPower = 2.6;  // between the powers of the nodes inside (3) and of those on the skin (2)
  const double wanted = static_cast<double>(options.vertices > 0 ? options.vertices : body.points.size());
  const double nodes_a_cell = options.kind == LatticeKind::kBodyCentred ? 2.0 : 1.0;
  double spacing_m = std::cbrt(nodes_a_cell * total_volume(body) / wanted);
  Lattice best;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kMostTries && least > kNearEnough; ++k) {
    Lattice next = build_with_spacing(body, options, spacing_m);
    const double off = std::log(static_cast<double>(next.nodes.size()) / wanted);
    if (std::fabs(off) < least) {
      least = std::fabs(off);
      best = std::move(next);
    }
    spacing_m *= std::exp(off / kPower);
  }
  return best;
}

}  // namespace palpate::springs

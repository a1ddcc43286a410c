// The springs of lattices: moduli and forces in closed form, inside and at the surface.
#include "core/springs/lattice/lattice_network.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/lattices.h"
#include "tests/support/random_gradient.h"
#include "tests/support/small_meshes.h"

namespace palpate::springs {
namespace {

using dynamics::Mat3;
using testing_support::make_affine_field;
using testing_support::make_gradient;

constexpr double kModulus = 7000.0;
constexpr double kSide = 0.02;

struct LatticeCase {
  LatticeKind kind = LatticeKind::kHexahedral;
  LatticeMix mix;
};
const std::array<LatticeCase, 4> kCases{
    LatticeCase{LatticeKind::kHexahedral, {}}, LatticeCase{LatticeKind::kHexahedral, {0.6, 0.0}},
    LatticeCase{LatticeKind::kBodyCentred, {}}, LatticeCase{LatticeKind::kBodyCentred, {0.0, 0.3}}};

/// A block of whole cells, turned by some degrees with its body.
Lattice make_block(LatticeKind kind, int nx, int ny, int nz) {
  TetMesh body = testing_support::make_kuhn_block(nx, ny, nz);
  for (Vec3& x : body.points) x = kSide * x;
  LatticeOptions options;
  options.kind = kind;
  options.spacing_m = kSide;
  return build_lattice(body, options);
}

double pull_of(const HalfAxis& axis, const std::vector<Vec3>& u) {
  Vec3 mean;
  for (const Index corner : axis.corners) mean = mean + 0.25 * u[corner];
  return axis.stiffness_n_per_m * dot(axis.direction, u[axis.centre] - mean);
}

double energy_of(const Lattice& lattice, const LatticeSprings& springs, const std::vector<Vec3>& u) {
  double energy = 0.0;
  const SpringNetwork& network = springs.network;
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    const auto [a, b] = network.springs[s];
    const Vec3 d = lattice.nodes[b] - lattice.nodes[a];
    const double stretch = dot(d, u[b] - u[a]) / length(d);
    energy += 0.5 * network.stiffness_n_per_m[s] * stretch * stretch;
  }
  for (const HalfAxis& axis : springs.half_axes) {
    const double pull = pull_of(axis, u);
    energy += 0.5 * pull * pull / axis.stiffness_n_per_m;
  }
  return energy;
}

/// What the springs pull at each node.
std::vector<Vec3> forces_of(const Lattice& lattice, const LatticeSprings& springs,
                            const std::vector<Vec3>& u) {
  std::vector<Vec3> forces(lattice.nodes.size());
  const SpringNetwork& network = springs.network;
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    const auto [a, b] = network.springs[s];
    const Vec3 d = lattice.nodes[b] - lattice.nodes[a];
    const Vec3 pull = (network.stiffness_n_per_m[s] * dot(d, u[b] - u[a]) / length_sq(d)) * d;
    forces[a] = forces[a] + pull;
    forces[b] = forces[b] - pull;
  }
  for (const HalfAxis& axis : springs.half_axes) {
    const Vec3 pull = pull_of(axis, u) * axis.direction;
    forces[axis.centre] = forces[axis.centre] - pull;
    for (const Index corner : axis.corners) forces[corner] = forces[corner] + 0.25 * pull;
  }
  return forces;
}

Mat3 strain_of(const Mat3& gradient) {
  return 0.5 * (gradient + transpose(gradient));
}

/// 1/2 lambda (tr e)^2 + mu e : e with nu = 1/4: lambda = mu = 0.4 E.
double density_of(const Mat3& strain) {
  return 0.4 * kModulus * (0.5 * trace(strain) * trace(strain) + contract(strain, strain));
}

/// The largest error of the block's energy in random uniform strains, relative.
double worst_energy_error(const Lattice& lattice, const LatticeSprings& springs) {
  double worst = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Mat3 gradient = make_gradient(seed);
    const double volume = static_cast<double>(lattice.cells()) * lattice.cell_volume_m3();
    const double exact = volume * density_of(strain_of(gradient));
    const std::vector<Vec3> u = make_affine_field(lattice.nodes, gradient, {0.1, -0.2, 0.3});
    worst = std::max(worst, std::fabs(energy_of(lattice, springs, u) / exact - 1.0));
  }
  return worst;
}

TEST(LatticeSprings, EveryBlockOfCellsIsIsotropicWithTheMaterialsModuli) {
  for (const LatticeCase& each : kCases) {
    for (const std::array<int, 3>& n : {std::array<int, 3>{1, 1, 1}, {2, 1, 1}, {3, 4, 2}}) {
      const Lattice lattice = make_block(each.kind, n[0], n[1], n[2]);
      EXPECT_LT(worst_energy_error(lattice, build_lattice_springs(lattice, kModulus, each.mix)), 1e-12);
    }
  }
}

// The oracle sees one constant that is a tenth too small.
TEST(LatticeSprings, AWrongConstantIsNotIsotropic) {
  for (const LatticeCase& each : kCases) {
    const Lattice lattice = make_block(each.kind, 3, 3, 3);
    LatticeSprings springs = build_lattice_springs(lattice, kModulus, each.mix);
    for (std::size_t s = 0; s < springs.network.springs.size(); ++s) {
      if (std::fabs(springs.network.rest_length_m[s] - kSide) < 1e-12)
        springs.network.stiffness_n_per_m[s] *= 0.9;
    }
    EXPECT_GT(worst_energy_error(lattice, springs), 0.01);
  }
}

// Of an inner node, as if the lattice had no end: sum k l^2 e(x)e(x)e(x)e = 12 E V <e(x)4>.
TEST(LatticeSprings, TheConstantsInsideAreThoseThatAreDerived) {
  for (const LatticeCase& each : kCases) {
    const Lattice lattice = make_block(each.kind, 4, 4, 4);
    const LatticeSprings springs = build_lattice_springs(lattice, kModulus, each.mix);
    const Index middle = lattice.corners[static_cast<std::size_t>(lattice.at({2, 2, 2}))][0];
    std::map<long, double> stiffness;  // by the square of the length, in quarters of h^2
    std::map<long, int> count;
    for (std::size_t s = 0; s < springs.network.springs.size(); ++s) {
      const auto [a, b] = springs.network.springs[s];
      if (a != middle && b != middle) continue;
      const double l = springs.network.rest_length_m[s] / kSide;
      const long key = std::lround(4.0 * l * l);
      stiffness[key] = springs.network.stiffness_n_per_m[s] / (kModulus * kSide);
      ++count[key];
    }
    if (each.kind == LatticeKind::kBodyCentred) {
      const double t = each.mix.face_share;
      EXPECT_NEAR(stiffness[3], 0.6 * (1.0 - t), 1e-12);
      EXPECT_NEAR(stiffness[4], 0.4, 1e-12);
      if (t > 0.0) {
        EXPECT_NEAR(stiffness[8], 0.4 * t, 1e-12);
      } else {
        EXPECT_EQ(count, (std::map<long, int>{{3, 8}, {4, 6}}));
      }
      EXPECT_EQ(springs.half_axes.size(), 96U);  // one a face of the block
    } else {
      const double s = each.mix.body_share;
      EXPECT_NEAR(stiffness[4], 0.4 * (1.0 + s), 1e-12);
      EXPECT_NEAR(stiffness[8], 0.4 * (1.0 - s), 1e-12);
      if (s > 0.0) {
        EXPECT_NEAR(stiffness[12], 0.3 * s, 1e-12);
      }
      EXPECT_EQ(count[4], 6);
      EXPECT_EQ(count[8], 12);
      EXPECT_TRUE(springs.half_axes.empty());
    }
  }
}

// Against the block that tests of identification use, which is built in another way.
TEST(LatticeSprings, AHexahedralBlockIsTheKnownOne) {
  const Lattice lattice = make_block(LatticeKind::kHexahedral, 3, 2, 4);
  for (const double share : {0.0, 0.5}) {
    const LatticeNetwork known = build_hexahedral_network({{3, 2, 4}, kSide, kModulus}, share);
    const LatticeSprings ours = build_lattice_springs(lattice, kModulus, {share, 0.0});
    const auto key = [](const Vec3& a, const Vec3& b) {
      std::array<long, 6> out{};
      const Vec3 low = (1.0 / kSide) * a;
      const Vec3 high = (1.0 / kSide) * b;
      std::array<long, 3> first{std::lround(low.x), std::lround(low.y), std::lround(low.z)};
      std::array<long, 3> second{std::lround(high.x), std::lround(high.y), std::lround(high.z)};
      if (second < first) std::swap(first, second);
      std::copy(first.begin(), first.end(), out.begin());
      std::copy(second.begin(), second.end(), out.begin() + 3);
      return out;
    };
    std::map<std::array<long, 6>, double> expected;
    for (std::size_t s = 0; s < known.network.springs.size(); ++s) {
      const auto [a, b] = known.network.springs[s];
      if (known.network.stiffness_n_per_m[s] > 0.0)
        expected[key(known.points[a], known.points[b])] = known.network.stiffness_n_per_m[s];
    }
    ASSERT_EQ(ours.network.springs.size(), expected.size());
    for (std::size_t s = 0; s < ours.network.springs.size(); ++s) {
      const auto [a, b] = ours.network.springs[s];
      EXPECT_NEAR(ours.network.stiffness_n_per_m[s], expected.at(key(lattice.nodes[a], lattice.nodes[b])),
                  1e-9);
    }
  }
}

/// What a uniform stress asks of each corner node: a quarter of each outer face, and the corners' own part.
std::vector<Vec3> expected_forces(const Lattice& lattice, const std::array<int, 3>& n, const Mat3& strain,
                                  double body_share) {
  const Mat3 stress = (0.4 * kModulus) * (trace(strain) * dynamics::kIdentity + 2.0 * strain);
  std::vector<Vec3> forces(lattice.nodes.size());
  for (std::size_t cell = 0; cell < lattice.cells(); ++cell) {
    for (std::size_t c = 0; c < 8; ++c) {
      std::array<double, 3> sign{};
      bool is_corner_of_block = true;
      Vec3 pull;
      for (std::size_t i = 0; i < 3; ++i) {
        const bool is_high = ((c >> i) & 1U) != 0;
        sign[i] = is_high ? 1.0 : -1.0;
        if (lattice.place[cell][i] != (is_high ? n[i] - 1 : 0)) {
          is_corner_of_block = false;
          continue;
        }
        pull = pull - (0.25 * kSide * kSide * sign[i]) * stress.row(i);
      }
      if (is_corner_of_block) {
        const double size = -0.2 * body_share * kModulus * kSide * kSide * sign[0] * sign[1] * sign[2];
        pull = pull + size * Vec3{strain(1, 2), strain(2, 0), strain(0, 1)};
      }
      Vec3& force = forces[lattice.corners[cell][c]];
      force = force + pull;
    }
  }
  return forces;
}

TEST(LatticeSprings, BalanceAUniformStressAtEveryNodeButTheCornersOfABlock) {
  const std::array<int, 3> n{3, 2, 4};
  for (const LatticeCase& each : kCases) {
    const Lattice lattice = make_block(each.kind, n[0], n[1], n[2]);
    const LatticeSprings springs = build_lattice_springs(lattice, kModulus, each.mix);
    const double s = each.kind == LatticeKind::kBodyCentred ? 1.0 - each.mix.face_share : each.mix.body_share;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Mat3 gradient = make_gradient(seed);
      const std::vector<Vec3> u = make_affine_field(lattice.nodes, gradient, {});
      const std::vector<Vec3> forces = forces_of(lattice, springs, u);
      const std::vector<Vec3> expected = expected_forces(lattice, n, strain_of(gradient), s);
      const double scale = kModulus * kSide * kSide * 0.02;
      for (std::size_t v = 0; v < forces.size(); ++v)
        EXPECT_NEAR(length(forces[v] - expected[v]), 0.0, 1e-12 * scale) << "node " << v;
    }
  }
}

TEST(LatticeSprings, CentresOfWeightedCellsAreAtRestInAUniformStrain) {
  const TetMesh body = build_kuhn_cube(3, 0.2, 7);
  LatticeOptions options;
  options.kind = LatticeKind::kBodyCentred;
  options.spacing_m = 0.17;
  options.turn_deg = 20.0;
  const Lattice lattice = build_lattice(body, options);
  ASSERT_GT(lattice.cut_cells(), 0U);
  const LatticeSprings springs = build_lattice_springs(lattice, kModulus);
  const Mat3 gradient = make_gradient(3);
  const std::vector<Vec3> forces =
      forces_of(lattice, springs, make_affine_field(lattice.nodes, gradient, {}));
  for (const Index centre : lattice.centres)
    EXPECT_LT(length(forces[centre]), 1e-12 * kModulus * 0.17 * 0.17 * 0.02);
}

TEST(LatticeSprings, RefuseWhatHasNoStiffness) {
  const Lattice lattice = make_block(LatticeKind::kHexahedral, 2, 2, 2);
  EXPECT_THROW(build_lattice_springs(lattice, kModulus, {1.0, 0.0}), InputError);
  EXPECT_THROW(build_lattice_springs(lattice, 0.0), InputError);
  EXPECT_THROW(build_lattice_masses(lattice, -1.0), InputError);
  // Why body diagonals alone are refused: a wave of neighbours that go up and down strains no other spring.
  std::vector<Vec3> wave;
  for (const Vec3& x : lattice.nodes)
    wave.push_back({0, 0, std::lround((x.x + x.y) / kSide) % 2 == 0 ? 1e-3 : -1e-3});
  const auto energy = [&](double share) {
    return energy_of(lattice, build_lattice_springs(lattice, kModulus, {share, 0.0}), wave);
  };
  EXPECT_NEAR(energy(0.9), 0.1 * energy(0.0), 1e-12 * energy(0.0));
}

// The top of one body-centred cell turned about its axis: no spring of the pure lattice is strained.
TEST(LatticeSprings, ABodyCentredCellResistsTorsionByItsFaceDiagonalsAlone) {
  const Lattice lattice = make_block(LatticeKind::kBodyCentred, 1, 1, 1);
  std::vector<Vec3> torsion(lattice.nodes.size());
  for (std::size_t c = 4; c < 8; ++c) {
    const Vec3& x = lattice.nodes[lattice.corners[0][c]];
    torsion[lattice.corners[0][c]] = 0.01 * cross(Vec3{0, 0, 1}, x - lattice.nodes[lattice.centres[0]]);
  }
  const auto energy = [&](double share) {
    return energy_of(lattice, build_lattice_springs(lattice, kModulus, {0.0, share}), torsion);
  };
  const double scale = kModulus * std::pow(kSide, 3) * 1e-4;
  EXPECT_LT(energy(0.0), 1e-14 * scale);
  EXPECT_GT(energy(0.1), 0.01 * scale);
}

TEST(LatticeMasses, AddUpToThatOfTheCells) {
  const TetMesh body = build_kuhn_cube(3, 0.2, 7);
  for (const LatticeKind kind : {LatticeKind::kHexahedral, LatticeKind::kBodyCentred}) {
    LatticeOptions options;
    options.kind = kind;
    options.spacing_m = 0.17;
    const Lattice lattice = build_lattice(body, options);
    const std::vector<double> masses = build_lattice_masses(lattice, 1000.0);
    const double sum = std::accumulate(masses.begin(), masses.end(), 0.0);
    EXPECT_NEAR(sum, 1000.0 * lattice.volume_ratio(), 1e-9);
    for (const double mass : masses) EXPECT_GT(mass, 0.0);
  }
}

TEST(CellGradients, AreThoseOfALinearField) {
  TetMesh body = build_kuhn_cube(2, 0.0, 1);
  LatticeOptions options;
  options.spacing_m = 0.25;
  options.turn_deg = 33.0;
  const Lattice lattice = build_lattice(body, options);
  const std::array<Vec3, 8> gradients = mean_cell_gradients(lattice);
  const Mat3 gradient = make_gradient(9);
  const std::vector<Vec3> u = make_affine_field(lattice.nodes, gradient, {1, 2, 3});
  Mat3 found;
  for (std::size_t c = 0; c < 8; ++c) dynamics::add_outer(found, u[lattice.corners[3][c]], gradients[c]);
  for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(found.m[k], gradient.m[k], 1e-13);
}

}  // namespace
}  // namespace palpate::springs

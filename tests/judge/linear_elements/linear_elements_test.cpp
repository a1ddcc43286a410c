#include "core/judge/linear_elements/linear_elements.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/linear_elements/elastic_blocks.h"
#include "core/judge/mesh/judge.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/subdivision/refinement.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kPoisson = 0.3;
constexpr double kMu = 0.5 / (1.0 + kPoisson);
constexpr double kLambda = kPoisson / ((1.0 + kPoisson) * (1.0 - 2.0 * kPoisson));
constexpr double kEigenvalue = 1e-3;  // what the header promises
constexpr double kError = 1e-4;

/// A block of n^3 cubes with its inner vertices moved at random by up to `by`.
TetMesh shaken(int n, double by, std::uint64_t seed = 31) {
  TetMesh mesh = make_kuhn_block(n, n, n);
  SplitMix64 random(seed);
  for (const Index v : interior_vertices_of_block(n, n, n)) {
    const Vec3 move{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    mesh.points[v] = mesh.points[v] + 2.0 * by * move;
  }
  return mesh;
}

Vector3d eigen_of(const Vec3& p) {
  return {p.x, p.y, p.z};
}

/// The textbook, dense: gradients from the inverse of the matrix of corners, strains as matrices, a rule of
/// four points.
struct Dense {
  explicit Dense(const TetMesh& mesh)
      : stiffness(MatrixXd::Zero(size(mesh), size(mesh))), mass(VectorXd::Zero(size(mesh))) {
    for (const Tet& tet : mesh.tets) add(mesh, tet);
  }

  static Eigen::Index size(const TetMesh& mesh) { return 3 * static_cast<Eigen::Index>(mesh.points.size()); }

  static Eigen::Matrix4d corners(const TetMesh& mesh, const Tet& tet) {
    Eigen::Matrix4d m;
    for (int i = 0; i < 4; ++i)
      m.row(i) << 1.0, eigen_of(mesh.points[tet[static_cast<std::size_t>(i)]]).transpose();
    return m;
  }

  void add(const TetMesh& mesh, const Tet& tet) {
    const Eigen::Matrix4d m = corners(mesh, tet);
    const double volume = m.determinant() / 6.0;
    const Eigen::Matrix<double, 3, 4> slopes = m.inverse().bottomRows<3>();
    std::array<Matrix3d, 12> strain;
    for (int i = 0; i < 12; ++i) {
      Matrix3d gradient = Matrix3d::Zero();
      gradient.row(i % 3) = slopes.col(i / 3).transpose();
      strain[static_cast<std::size_t>(i)] = 0.5 * (gradient + gradient.transpose());
    }
    const auto at = [&](int i) {
      return 3 * static_cast<Eigen::Index>(tet[static_cast<std::size_t>(i / 3)]) + i % 3;
    };
    for (int i = 0; i < 12; ++i) {
      mass[at(i)] += volume / 4.0;
      for (int j = 0; j < 12; ++j) {
        stiffness(at(i), at(j)) +=
            volume * inner(strain[static_cast<std::size_t>(i)], strain[static_cast<std::size_t>(j)]);
      }
    }
  }

  static double inner(const Matrix3d& a, const Matrix3d& b) {
    return kLambda * a.trace() * b.trace() + 2.0 * kMu * a.cwiseProduct(b).sum();
  }

  MatrixXd stiffness;
  VectorXd mass;
};

/// Quadratic displacements without body force, from a kernel: another basis than the judge's.
std::vector<std::array<Matrix3d, 3>> quadratic_fields() {
  // u_k = sum_ij c[k](i, j) x_i x_j, c[k] symmetric: the unknowns are c[k](i, j) with i <= j.
  MatrixXd force = MatrixXd::Zero(3, 18);
  std::vector<std::array<Matrix3d, 3>> unit;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        std::array<Matrix3d, 3> c{Matrix3d::Zero(), Matrix3d::Zero(), Matrix3d::Zero()};
        c[static_cast<std::size_t>(k)](i, j) += 0.5;
        c[static_cast<std::size_t>(k)](j, i) += 0.5;
        for (int d = 0; d < 3; ++d) {  // (lambda + mu) d/dx_d div u + mu lap u_d
          double divergence = 0.0;
          for (int e = 0; e < 3; ++e) divergence += 2.0 * c[static_cast<std::size_t>(e)](e, d);
          force(d, static_cast<Eigen::Index>(unit.size())) =
              (kLambda + kMu) * divergence + kMu * 2.0 * c[static_cast<std::size_t>(d)].trace();
        }
        unit.push_back(c);
      }
    }
  }
  const MatrixXd kernel = force.fullPivLu().kernel();
  std::vector<std::array<Matrix3d, 3>> fields;
  for (Eigen::Index f = 0; f < kernel.cols(); ++f) {
    std::array<Matrix3d, 3> c{Matrix3d::Zero(), Matrix3d::Zero(), Matrix3d::Zero()};
    for (std::size_t u = 0; u < unit.size(); ++u) {
      for (std::size_t k = 0; k < 3; ++k) c[k] += kernel(static_cast<Eigen::Index>(u), f) * unit[u][k];
    }
    fields.push_back(c);
  }
  return fields;
}

Matrix3d strain_at(const std::array<Matrix3d, 3>& c, const Vector3d& x) {
  Matrix3d gradient;
  for (int k = 0; k < 3; ++k) gradient.row(k) = 2.0 * (c[static_cast<std::size_t>(k)] * x).transpose();
  return 0.5 * (gradient + gradient.transpose());
}

/// Errors by Galerkin orthogonality, |u - u_h|^2 = |u|^2 - |u_h|^2, which the judge does not use.
VectorXd dense_errors(const TetMesh& mesh, const Dense& dense) {
  const auto fields = quadratic_fields();
  EXPECT_EQ(fields.size(), 15U);
  const auto count = static_cast<Eigen::Index>(fields.size());
  const double far = (5.0 + 3.0 * std::sqrt(5.0)) / 20.0;
  const double near = (5.0 - std::sqrt(5.0)) / 20.0;
  std::vector<std::vector<Matrix3d>> strains(fields.size());
  std::vector<double> weights;
  MatrixXd load = MatrixXd::Zero(Dense::size(mesh), count);
  for (const Tet& tet : mesh.tets) {
    const Eigen::Matrix4d m = Dense::corners(mesh, tet);
    const double share = m.determinant() / 24.0;
    const Eigen::Matrix<double, 3, 4> slopes = m.inverse().bottomRows<3>();
    for (int point = 0; point < 4; ++point) {
      Vector3d x = Vector3d::Zero();
      for (int i = 0; i < 4; ++i) x += (i == point ? far : near) * m.row(i).tail<3>().transpose();
      weights.push_back(share);
      for (Eigen::Index f = 0; f < count; ++f) {
        const Matrix3d strain = strain_at(fields[static_cast<std::size_t>(f)], x);
        strains[static_cast<std::size_t>(f)].push_back(strain);
        const Matrix3d stress = kLambda * strain.trace() * Matrix3d::Identity() + 2.0 * kMu * strain;
        for (int i = 0; i < 4; ++i) {
          load.block<3, 1>(3 * static_cast<Eigen::Index>(tet[static_cast<std::size_t>(i)]), f) +=
              share * stress * slopes.col(i);
        }
      }
    }
  }
  // Off the affine part: the mean strain, whose nodal forces are those of an affine field.
  double volume = 0.0;
  for (const double w : weights) volume += w;
  MatrixXd energy = MatrixXd::Zero(count, count);
  std::vector<Matrix3d> mean(fields.size(), Matrix3d::Zero());
  for (std::size_t f = 0; f < fields.size(); ++f) {
    for (std::size_t q = 0; q < weights.size(); ++q) mean[f] += weights[q] / volume * strains[f][q];
  }
  for (std::size_t f = 0; f < fields.size(); ++f) {
    for (std::size_t g = 0; g < fields.size(); ++g) {
      for (std::size_t q = 0; q < weights.size(); ++q) {
        energy(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(g)) +=
            weights[q] * Dense::inner(strains[f][q] - mean[f], strains[g][q] - mean[g]);
      }
    }
    VectorXd affine(Dense::size(mesh));
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      affine.segment<3>(3 * static_cast<Eigen::Index>(v)) = mean[f] * eigen_of(mesh.points[v]);
    }
    load.col(static_cast<Eigen::Index>(f)) -= dense.stiffness * affine;
  }
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver(dense.stiffness);
  const MatrixXd discrete = load.transpose() * solver.solve(load);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> shares(energy - discrete, energy);
  return shares.eigenvalues();
}

double greatest(const MatrixXd& matrix) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(matrix).eigenvalues().maxCoeff();
}

double condition(const MatrixXd& matrix) {
  const VectorXd values = Eigen::SelfAdjointEigenSolver<MatrixXd>(matrix).eigenvalues();
  EXPECT_LT(std::fabs(values[5]), 1e-9 * values.tail(1)[0]);  // six rigid motions
  return values.tail(1)[0] / values[6];
}

/// L^-1 K L^-T, L L^T the diagonal blocks of K.
MatrixXd scaled_by_diagonal_blocks(const MatrixXd& stiffness) {
  MatrixXd factor = MatrixXd::Zero(stiffness.rows(), stiffness.cols());
  for (Eigen::Index v = 0; v < stiffness.rows(); v += 3)
    factor.block<3, 3>(v, v) = stiffness.block<3, 3>(v, v).llt().matrixL();
  const MatrixXd half = factor.triangularView<Eigen::Lower>().solve(stiffness);
  return factor.triangularView<Eigen::Lower>().solve(half.transpose());
}

TEST(LinearElements, AgreeWithDenseTextbookAlgebra) {
  for (const TetMesh& mesh :
       {shaken(3, 0.2), make_kuhn_block(3, 1, 1), make_cube_ring(), make_regular_tet()}) {
    SCOPED_TRACE(mesh.tets.size());
    const LinearElementFigures found = measure_linear_elements(mesh);
    ASSERT_EQ(found.reason, "");
    const Dense dense(mesh);
    const VectorXd shares = dense_errors(mesh, dense);
    EXPECT_NEAR(found.p1_error / std::sqrt(shares.mean()), 1.0, kError);
    EXPECT_NEAR(found.p1_error_worst / std::sqrt(shares.maxCoeff()), 1.0, kError);
    EXPECT_NEAR(found.stiffness_condition / condition(dense.stiffness), 1.0, kEigenvalue);
    const MatrixXd scaled = scaled_by_diagonal_blocks(dense.stiffness);
    EXPECT_NEAR(found.scaled_condition / condition(scaled), 1.0, kEigenvalue);
    EXPECT_NEAR(found.max_scaled_eigenvalue / greatest(scaled), 1.0, kEigenvalue);
    const VectorXd root = dense.mass.cwiseSqrt().cwiseInverse();
    const MatrixXd waves = root.asDiagonal() * dense.stiffness * root.asDiagonal();
    const double omega = std::sqrt(greatest(waves));
    const double size = std::cbrt(dense.mass.sum() / 3.0 / static_cast<double>(mesh.tets.size()));
    EXPECT_NEAR(found.explicit_step / (2.0 / omega / size), 1.0, kEigenvalue);
    EXPECT_NEAR(found.max_stiffness_eigenvalue / (greatest(dense.stiffness) / size), 1.0, kEigenvalue);
  }
}

/// A cube pushed out to a ball: its slowest bends come in groups.
TetMesh make_round(int n, double jitter, std::uint64_t seed) {
  TetMesh mesh = build_kuhn_cube(n, jitter, seed);
  Vec3 middle;
  for (const Vec3& p : mesh.points) middle = middle + (1.0 / static_cast<double>(mesh.points.size())) * p;
  for (Vec3& p : mesh.points) {
    const Vec3 from = p - middle;
    const double far = std::max({std::fabs(from.x), std::fabs(from.y), std::fabs(from.z)});
    if (far > 0.0) p = middle + (far / length(from)) * from;
  }
  return mesh;
}

TEST(LinearElements, RoundBodiesHaveFiguresToo) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    SCOPED_TRACE(seed);
    const TetMesh ball = make_round(3, 0.2, seed);
    const LinearElementFigures found = measure_linear_elements(ball);
    ASSERT_EQ(found.reason, "");
    const Dense dense(ball);
    EXPECT_NEAR(found.stiffness_condition / condition(dense.stiffness), 1.0, kEigenvalue);
    EXPECT_NEAR(found.scaled_condition / condition(scaled_by_diagonal_blocks(dense.stiffness)), 1.0,
                kEigenvalue);
  }
}

TEST(LinearElements, TheErrorFallsWithTheSizeOfTheElements) {
  // Order 1, reached from below: theta is a c h^2 that saturates at 1 where there are few elements.
  double before = measure_linear_elements(make_kuhn_block(2, 2, 2)).p1_error;
  double order_before = 0.0;
  for (const int n : {4, 8}) {
    const double now = measure_linear_elements(make_kuhn_block(n, n, n)).p1_error;
    const double order = std::log2(before / now);
    EXPECT_GT(order, order_before);
    EXPECT_LT(order, 1.0);
    before = now;
    order_before = order;
  }
  EXPECT_GT(order_before, 0.8);
}

/// The search for the least eigenvalue is left with rigid motions alone there: a reason, no figure.
TEST(LinearElements, OneTetHasAReason) {
  const LinearElementFigures figures = measure_linear_elements(make_kuhn_block(1, 1, 1));
  EXPECT_EQ(figures.reason, "");
  EXPECT_NE(measure_linear_elements(make_corner_tet()).reason, "");
}

TEST(LinearElements, RigidMotionsAndAffineFieldsAreExact) {
  const TetMesh mesh = shaken(3, 0.2);
  const BlockRows stiffness = build_stiffness(mesh, kLambda, kMu);
  const Matrix3d slope{{0.3, -0.1, 0.2}, {0.5, 0.7, -0.4}, {0.1, 0.6, -0.2}};
  FieldBlock field(mesh.points.size(), 2);  // a rotation and an affine field
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Vector3d p = eigen_of(mesh.points[v]);
    const Vector3d affine = slope * p;
    const Vector3d turned = Vector3d(1.0, -2.0, 0.5).cross(p) + Vector3d(3.0, 1.0, 2.0);
    for (int a = 0; a < 3; ++a) {
      field.row(3 * v + static_cast<std::size_t>(a))[0] = turned[a];
      field.row(3 * v + static_cast<std::size_t>(a))[1] = affine[a];
    }
  }
  FieldBlock force(mesh.points.size(), 2);
  multiply(stiffness, field, force);
  const Matrix3d strain = 0.5 * (slope + slope.transpose());
  const std::vector<double> energy = dots(field, force);
  constexpr double kRounding = 1e-11;  // sums of thousands of terms of size 1 to 10
  EXPECT_NEAR(energy[0], 0.0, kRounding);
  EXPECT_NEAR(energy[1], 27.0 * Dense::inner(strain, strain), kRounding);
  for (const Index v : interior_vertices_of_block(3, 3, 3)) {
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(force.row(3 * std::size_t{v} + a)[1], 0.0, kRounding);
  }
}

TEST(LinearElements, NeitherPlaceNorTurnNorScaleNorNumbersMatter) {
  const TetMesh mesh = shaken(3, 0.2);
  const LinearElementFigures expected = measure_linear_elements(mesh);
  const auto expect_same = [&](const TetMesh& other) {
    const LinearElementFigures found = measure_linear_elements(other);
    ASSERT_EQ(found.reason, "");
    EXPECT_NEAR(found.p1_error / expected.p1_error, 1.0, kError);
    EXPECT_NEAR(found.p1_error_worst / expected.p1_error_worst, 1.0, kError);
    EXPECT_NEAR(found.stiffness_condition / expected.stiffness_condition, 1.0, kEigenvalue);
    EXPECT_NEAR(found.scaled_condition / expected.scaled_condition, 1.0, kEigenvalue);
    EXPECT_NEAR(found.max_stiffness_eigenvalue / expected.max_stiffness_eigenvalue, 1.0, kEigenvalue);
    EXPECT_NEAR(found.max_scaled_eigenvalue / expected.max_scaled_eigenvalue, 1.0, kEigenvalue);
    EXPECT_NEAR(found.explicit_step / expected.explicit_step, 1.0, kEigenvalue);
  };
  expect_same(translated(mesh, {40.0, -7.0, 3.0}));
  TetMesh other = mesh;
  const Matrix3d turn = Eigen::AngleAxisd(0.9, Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  for (Vec3& p : other.points) {
    const Vector3d q = turn * eigen_of(p);
    p = {q[0], q[1], q[2]};
  }
  expect_same(other);
  for (const double scale : {1e-200, 1e-3, 1e200}) {
    other = mesh;
    for (Vec3& p : other.points) p = scale * p;
    expect_same(other);
  }
  other = mesh;
  std::reverse(other.points.begin(), other.points.end());
  for (Tet& tet : other.tets) {
    for (Index& v : tet) v = static_cast<Index>(mesh.points.size() - 1 - v);
  }
  std::reverse(other.tets.begin(), other.tets.end());
  other.points.push_back({1000.0, 0.0, 0.0});  // a vertex that no tet uses
  expect_same(other);
}

TEST(LinearElements, ASliverShortensTheStepAndWorsensTheConditions) {
  TetMesh mesh = make_kuhn_block(3, 3, 3);
  const LinearElementFigures before = measure_linear_elements(mesh);
  mesh.points[block_vertex(3, 3, 1, 1, 1)].z += 0.98;  // nearly onto its neighbour's plane: still positive
  ASSERT_EQ(check_validity(mesh).inverted_tets, 0U);
  const LinearElementFigures after = measure_linear_elements(mesh);
  ASSERT_EQ(after.reason, "");
  EXPECT_LT(after.explicit_step, 0.5 * before.explicit_step);
  EXPECT_GT(after.stiffness_condition, 2.0 * before.stiffness_condition);
  EXPECT_GT(after.p1_error, before.p1_error);
}

TEST(LinearElements, SayWhyThereAreNone) {
  EXPECT_EQ(measure_linear_elements({}).reason, "no tetrahedra");
  TetMesh mesh = make_kuhn_block(2, 2, 2);
  std::swap(mesh.tets[5][0], mesh.tets[5][1]);
  EXPECT_EQ(measure_linear_elements(mesh).reason, "1 tet is not positive");
  mesh = make_kuhn_block(2, 2, 2);
  mesh.points[0].x = std::nan("");
  EXPECT_NE(measure_linear_elements(mesh).reason.find("not positive"), std::string::npos);
  EXPECT_EQ(measure_linear_elements(join_meshes(make_corner_tet(), translated(make_corner_tet(), {5, 5, 5})))
                .reason,
            "the body is in 2 parts");
  TetMesh hinge = make_corner_tet();  // two tets that share a vertex alone: a hinge, which no face holds
  hinge.points.insert(hinge.points.end(), {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
  hinge.tets.push_back({0, 4, 6, 5});
  EXPECT_EQ(measure_linear_elements(hinge).reason, "the body is in 2 parts");
  mesh = make_two_tets();
  mesh.points.back() = 1e-150 * mesh.points.back();
  EXPECT_NE(measure_linear_elements(mesh).reason, "");
  EXPECT_THROW(measure_linear_elements(make_corner_tet(), 0.5), ContractError);
  mesh = make_corner_tet();
  mesh.tets[0][3] = 9;
  EXPECT_THROW(measure_linear_elements(mesh), ContractError);
}

TEST(LinearElements, TheSameMeshGivesTheSameBits) {
  const TetMesh mesh = shaken(4, 0.2);
  const LinearElementFigures a = measure_linear_elements(mesh);
  const LinearElementFigures b = measure_linear_elements(mesh);
  EXPECT_EQ(a.p1_error, b.p1_error);
  EXPECT_EQ(a.stiffness_condition, b.stiffness_condition);
  EXPECT_EQ(a.scaled_condition, b.scaled_condition);
  EXPECT_EQ(a.explicit_step, b.explicit_step);
}

TEST(ElasticBlocks, TheSolverSaysWhenItHasNotConverged) {
  const TetMesh mesh = shaken(3, 0.2);
  const BlockRows stiffness = build_stiffness(mesh, kLambda, kMu);
  const std::vector<Block> inverse = invert_blocks(diagonal_blocks(stiffness));
  FieldBlock truth(mesh.points.size(), 2);
  SplitMix64 random(5);
  for (double& value : truth.values) value = random.uniform();
  FieldBlock force(mesh.points.size(), 2);
  multiply(stiffness, truth, force);
  FieldBlock answer(mesh.points.size(), 2);
  EXPECT_FALSE(solve_fields(stiffness, inverse, force, answer, 1e-10, 3));
  EXPECT_TRUE(solve_fields(stiffness, inverse, force, answer, 1e-10, 500));
  FieldBlock again(mesh.points.size(), 2);
  multiply(stiffness, answer, again);
  for (std::size_t i = 0; i < again.values.size(); ++i) EXPECT_NEAR(again.values[i], force.values[i], 1e-7);
  EXPECT_TRUE(invert_blocks(std::vector<Block>{Block{1, 2, 0, 2, 1, 0, 0, 0, 1}}).empty());
}

}  // namespace
}  // namespace palpate::judge

// Does averaging strains over nodes leave motions of the free body that hardly anything resists? Each model's
// stiffness beside that of linear elements on the same mesh, motion by motion.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

#include "core/base/error.h"
#include "core/dynamics/elasticity/tangent.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/mesh/shapes/shapes.h"

namespace palpate::dynamics {
namespace {

const Material kSoft{1000.0, 0.25, 1.0};  // lambda = mu

/// The tangent of the free body at rest.
Eigen::MatrixXd stiffness(const ElasticModel& model) {
  const auto vertices = model.rest.size();
  BlockMatrix matrix = build_tangent_pattern(model, {});
  const std::vector<Vec3> still(vertices);
  add_tangent(model, still, TangentKind::kExact, matrix);
  const auto size = static_cast<Eigen::Index>(3 * vertices);
  Eigen::MatrixXd dense(size, size);
  std::vector<Vec3> unit(vertices);
  std::vector<Vec3> column(vertices);
  for (std::size_t k = 0; k < 3 * vertices; ++k) {
    unit[k / 3] = {k % 3 == 0 ? 1.0 : 0.0, k % 3 == 1 ? 1.0 : 0.0, k % 3 == 2 ? 1.0 : 0.0};
    multiply(matrix, unit, column);
    unit[k / 3] = {};
    for (std::size_t v = 0; v < vertices; ++v)
      dense.col(static_cast<Eigen::Index>(k)).segment<3>(static_cast<Eigen::Index>(3 * v)) << column[v].x,
          column[v].y, column[v].z;
  }
  return 0.5 * (dense + dense.transpose());
}

/// Motions without any resistance, and the least and greatest of x^T K x over that of linear elements, among
/// the others.
struct Modes {
  Eigen::Index free = 0;
  double least = 0.0;
  double greatest = 0.0;
};

/// Models on one mesh, a cube of that many Kuhn cells along each side.
class Compared {
 public:
  explicit Compared(int cells) : mesh_(build_kuhn_cube(cells, 0.3, 7)), whitening_(whiten()) {}

  Modes modes_of(const BlendOptions& options) const {
    const Eigen::MatrixXd own = stiffness(build_blend_model(mesh_, kSoft, options).model);
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(own).eigenvalues();
    const Eigen::MatrixXd whitened = whitening_.transpose() * own * whitening_;
    const Eigen::VectorXd ratios = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(whitened).eigenvalues();
    return {(values.array() < 1e-10 * values.maxCoeff()).count(), ratios.minCoeff(), ratios.maxCoeff()};
  }

 private:
  /// Columns that linear elements resist with 1 each, none of them rigid.
  Eigen::MatrixXd whiten() const {
    BlendOptions linear;
    linear.theta = 0.0;
    linear.domain = StrainDomain::kTet;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> found(
        stiffness(build_blend_model(mesh_, kSoft, linear).model));
    const Eigen::Index strained = found.eigenvalues().size() - 6;
    return found.eigenvectors().rightCols(strained) *
           found.eigenvalues().tail(strained).cwiseSqrt().cwiseInverse().asDiagonal();
  }

  TetMesh mesh_;
  Eigen::MatrixXd whitening_;
};

BlendOptions blend(double theta, double stabilise, StrainDomain rest = StrainDomain::kTet) {
  BlendOptions options;
  options.theta = theta;
  options.stabilise = stabilise;
  options.rest = rest;
  return options;
}

// The measure finds what it is for: strains averaged over nodes alone have motions that cost next to nothing.
TEST(SmoothedModes, NodesAloneHaveSpuriousOnes) {
  const Modes nodes = Compared(4).modes_of(blend(1.0, 0.0));
  EXPECT_EQ(nodes.free, 6);
  EXPECT_LT(nodes.least, 0.02);
}

// Averaging never stiffens (Jensen). From below: 2 mu eps : eps is at least 2 mu / (3 lambda + 2 mu) of the
// whole energy, since (tr eps)^2 <= 3 eps : eps.
TEST(SmoothedModes, ABlendKeepsItsShareOfEachMotion) {
  const Compared cube(3);
  for (const double theta : {0.0, 0.5, 0.7}) {
    const Modes found = cube.modes_of(blend(theta, 0.0));
    EXPECT_EQ(found.free, 6);
    EXPECT_LE(found.greatest, 1.0 + 1e-9);
    EXPECT_GE(found.least, (1.0 - theta) * 2.0 / 5.0) << theta;
  }
}

// What a tet keeps of its change of shape lifts the lowest motions, the more the more it keeps.
TEST(SmoothedModes, StabilisingLiftsThem) {
  const Compared cube(3);
  for (const StrainDomain rest : {StrainDomain::kNode, StrainDomain::kEdge}) {
    double before = cube.modes_of(blend(0.0, 0.0, rest)).least;
    for (const double alpha : {0.1, 0.3}) {
      const Modes found = cube.modes_of(blend(0.0, alpha, rest));
      EXPECT_EQ(found.free, 6);
      EXPECT_LE(found.greatest, 1.0 + 1e-9);
      EXPECT_GT(found.least, before) << strain_domain_name(rest) << ' ' << alpha;
      before = found.least;
    }
  }
}

TEST(StabilisedBlend, HasTheExactEnergyOfAnAffineDisplacement) {
  const TetMesh mesh = build_kuhn_cube(2, 0.3, 3);
  std::vector<Vec3> u;
  for (const Vec3& p : mesh.points)
    u.push_back({0.01 * p.x + 0.02 * p.y, -0.03 * p.z, 0.01 * p.y + 0.04 * p.z});
  const double xy = 0.01;
  const double yz = 0.5 * (-0.03 + 0.01);
  const double squares = 0.01 * 0.01 + 0.04 * 0.04 + 2.0 * (xy * xy + yz * yz);
  const double trace = 0.05;
  const double exact = 0.5 * kSoft.lambda_pa() * trace * trace + kSoft.mu_pa() * squares;
  for (const double alpha : {0.0, 0.2, 1.0}) {
    for (const StrainDomain rest : {StrainDomain::kTet, StrainDomain::kEdge}) {
      const BuiltModel built = build_blend_model(mesh, kSoft, blend(0.4, alpha, rest));
      EXPECT_NEAR(elastic_energy(built.model, u), exact, 1e-12 * exact) << alpha;
    }
  }
}

TEST(StabilisedBlend, IsForSmallStrainAndSharesAlone) {
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 1);
  EXPECT_THROW(build_blend_model(mesh, kSoft, blend(0.5, -0.1)), InputError);
  EXPECT_THROW(build_blend_model(mesh, kSoft, blend(0.5, 1.1)), InputError);
  BlendOptions large = blend(0.5, 0.1);
  large.strain = StrainSize::kLarge;
  EXPECT_THROW(build_blend_model(mesh, kSoft, large), InputError);
}

}  // namespace
}  // namespace palpate::dynamics

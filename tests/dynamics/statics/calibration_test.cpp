#include "core/dynamics/statics/calibration.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"

namespace palpate::dynamics {
namespace {

using testing_support::make_edge_springs;

TEST(Calibration, SmoothedElementsHaveTheModuliOfTheirMaterial) {
  // An affine displacement is in equilibrium there, so relaxing changes nothing.
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 4);
  for (const double nu : {0.1, 0.45}) {
    const Material material{1000.0, nu, 1.0};
    const BuiltModel built = build_blend_model(mesh, material, {});
    const MeasuredModuli moduli = measure_moduli(mesh, built.model, {});
    ASSERT_TRUE(moduli.converged);
    for (const EffectiveModuli& each : {moduli.affine, moduli.relaxed}) {
      EXPECT_NEAR(each.lambda_pa, material.lambda_pa(), 1e-9 * material.lambda_pa());
      EXPECT_NEAR(each.mu_pa, material.mu_pa(), 1e-9 * material.mu_pa());
    }
  }
}

TEST(Calibration, SpringsKeepTheMasterIdentityUntilTheyRelax) {
  // sum k l^2 = 6 E V is lambda = mu = 0.4 E under affine displacements; inner vertices then make it softer.
  const TetMesh mesh = build_kuhn_cube(4, 0.3, 4);
  ElasticModel model{mesh.points, make_edge_springs(mesh, 1000.0), true, {}, {}};
  const MeasuredModuli moduli = measure_moduli(mesh, model, {});
  EXPECT_NEAR(moduli.affine.lambda_pa, 400.0, 1e-9);
  EXPECT_NEAR(moduli.affine.mu_pa, 400.0, 1e-9);
  EXPECT_LT(moduli.relaxed.mu_pa, moduli.affine.mu_pa);
  EXPECT_GT(moduli.relaxed.mu_pa, 0.5 * moduli.affine.mu_pa);
  const double factor = calibration_factor(moduli, 400.0);
  EXPECT_GT(factor, 1.0);
  for (double& stiffness : model.springs.stiffness_n_per_m) stiffness *= factor;
  EXPECT_NEAR(calibration_factor(measure_moduli(mesh, model, {}), 400.0), 1.0, 1e-9);
}

TEST(Calibration, ALatticeNeedsNone) {
  // Inside a body-centred cubic lattice an affine displacement is in equilibrium, and the moduli are exact;
  // the layer of cut octahedra at the skin counts here, so the spacing decides how near 1 the factor is.
  const auto factor_of = [](int cells) {
    const TetMesh mesh = build_bcc_bar(cells);
    const ElasticModel model{mesh.points, make_edge_springs(mesh, 1000.0), true, {}, {}};
    const MeasuredModuli moduli = measure_moduli(mesh, model, {});
    EXPECT_NEAR(moduli.affine.mu_pa, 400.0, 1e-9);
    return calibration_factor(moduli, 400.0);
  };
  const double coarse = factor_of(2) - 1.0;
  const double fine = factor_of(4) - 1.0;
  EXPECT_GT(coarse, 0.0);
  EXPECT_LT(fine, coarse);
}

TEST(Calibration, SpringsThatResistNothingAreRefused) {
  const TetMesh mesh = build_kuhn_cube(2, 0.1, 4);
  ElasticModel model{mesh.points, make_edge_springs(mesh, 1000.0), true, {}, {}};
  model.springs.stiffness_n_per_m.assign(model.springs.springs.size(), 0.0);
  EXPECT_THROW(calibration_factor(measure_moduli(mesh, model, {}), 400.0), InputError);
}

}  // namespace
}  // namespace palpate::dynamics

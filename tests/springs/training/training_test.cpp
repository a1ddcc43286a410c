#include "core/springs/training/training.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/springs/network/network.h"

namespace {

using namespace palpate;
using namespace palpate::springs;

/// A network of a jittered cube with known constants, held in two ways, and the fields that these give.
struct Fixture {
  TetMesh mesh = build_kuhn_cube(2, 0.3, 4);
  RankOneTerms terms;
  TrainingSet set;
  std::vector<double> truth;

  explicit Fixture(bool with_dilatation) {
    SpringNetwork network = build_spring_network(mesh);
    std::fill(network.stiffness_n_per_m.begin(), network.stiffness_n_per_m.end(), 100.0);
    add_spring_terms(mesh, network, 1e-3, terms);
    if (with_dilatation) add_vertex_dilatation_terms(mesh, 200.0, terms);
    const std::size_t components = 3 * mesh.points.size();
    for (const double volume : build_influence_volumes(mesh)) set.weight.insert(set.weight.end(), 3, volume);
    set.boundaries.resize(2);
    set.boundaries[0].held.assign(components, 0);
    set.boundaries[1].held.assign(components, 0);
    for (Index v = 0; v < mesh.points.size(); ++v) {
      if (mesh.points[v].z == 0.0)
        for (Index axis = 0; axis < 3; ++axis) set.boundaries[0].held[3 * v + axis] = 1;
      if (mesh.points[v].x == 0.0)
        for (Index axis = 0; axis < 3; ++axis)
          set.boundaries[1].stiffness.push_back({3 * v + axis, 3 * v + axis, 50.0});
    }
    SplitMix64 random(9);
    for (const double constant : terms.constant)
      truth.push_back(constant * std::exp(0.6 * (random.uniform() - 0.5)));
    for (int i = 0; i < 6; ++i) add_case(i, random);
    const std::vector<CaseResult> fields = solve_cases(terms, truth, set);
    for (std::size_t i = 0; i < fields.size(); ++i) set.cases[i].target_m = fields[i].displacement_m;
  }

  void add_case(int number, SplitMix64& random) {
    const std::size_t components = set.weight.size();
    TrainingCase one;
    one.name = "load " + std::to_string(number);
    one.boundary = static_cast<std::size_t>(number % 2);
    for (std::size_t i = 0; i < components; ++i) one.force_n.push_back(random.uniform() - 0.5);
    one.held_m.assign(components, 0.01 * number);
    one.target_m.assign(components, 1.0);
    set.cases.push_back(one);
  }
};

double energy(const RankOneTerms& terms, std::span<const double> u) {
  double sum = 0.0;
  for (std::size_t q = 0; q < terms.constant.size(); ++q) {
    double along = 0.0;
    for (std::size_t i = terms.offsets[q]; i < terms.offsets[q + 1]; ++i)
      along += terms.coefficient[i] * u[terms.component[i]];
    sum += 0.5 * terms.constant[q] * along * along;
  }
  return sum;
}

TEST(Training, DilatationTermsHoldTheEnergyOfAnAffineField) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 2);
  std::vector<double> u;
  for (const Vec3& p : mesh.points)
    u.insert(u.end(), {0.1 * p.x + 0.3 * p.y, 0.2 * p.y - 0.5 * p.z, 0.4 * p.x - 0.05 * p.z});
  const double trace = 0.1 + 0.2 - 0.05;
  RankOneTerms tets;
  add_tet_dilatation_terms(mesh, 7.0, tets);
  EXPECT_EQ(tets.constant.size(), mesh.tets.size());
  EXPECT_NEAR(energy(tets, u), 0.5 * 7.0 * trace * trace, 1e-13);
  RankOneTerms vertices;
  add_vertex_dilatation_terms(mesh, 7.0, vertices);
  EXPECT_EQ(vertices.constant.size(), mesh.points.size());
  EXPECT_NEAR(energy(vertices, u), 0.5 * 7.0 * trace * trace, 1e-13);
  for (std::size_t q = 0; q < vertices.constant.size(); ++q)  // each component once
    for (std::size_t i = vertices.offsets[q] + 1; i < vertices.offsets[q + 1]; ++i)
      EXPECT_LT(vertices.component[i - 1], vertices.component[i]);
}

TEST(Training, SpringTermsHoldTheEnergyOfSprings) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 2);
  SpringNetwork network = build_spring_network(mesh);
  SplitMix64 random(3);
  for (double& k : network.stiffness_n_per_m) k = 1.0 + random.uniform();
  network.stiffness_n_per_m[0] = 0.0;
  RankOneTerms terms;
  add_spring_terms(mesh, network, 1e-3, terms);
  std::vector<double> u(3 * mesh.points.size());
  for (double& value : u) value = random.uniform();
  double expected = 0.0;
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    const auto [a, b] = network.springs[s];
    const Vec3 d = mesh.points[b] - mesh.points[a];
    const auto displacement_at = [&](std::size_t vertex) {
      return Vec3{u[3 * vertex], u[3 * vertex + 1], u[3 * vertex + 2]};
    };
    const Vec3 du = displacement_at(b) - displacement_at(a);
    const double along = dot(d, du) / length(d);
    expected += 0.5 * terms.constant[s] * along * along;
    if (s > 0) {
      EXPECT_EQ(terms.constant[s], network.stiffness_n_per_m[s]);
    }
  }
  EXPECT_GT(terms.constant[0], 0.0);
  EXPECT_LT(terms.constant[0], 0.01);
  EXPECT_NEAR(energy(terms, u), expected, 1e-12 * expected);
}

TEST(Training, EquilibriaMinimiseTheEnergy) {
  // The derivative of W along any free component is zero; held ones are where they are told.
  const Fixture fixture(true);
  const std::vector<CaseResult> results = solve_cases(fixture.terms, fixture.truth, fixture.set);
  RankOneTerms terms = fixture.terms;
  terms.constant = fixture.truth;
  for (std::size_t c = 0; c < results.size(); ++c) {
    const TrainingCase& one = fixture.set.cases[c];
    const TrainingBoundary& boundary = fixture.set.boundaries[one.boundary];
    EXPECT_LT(results[c].relative_error, 1e-12);
    const auto potential = [&](const std::vector<double>& u) {
      double sum = energy(terms, u);
      for (const StiffnessEntry& entry : boundary.stiffness)
        sum += 0.5 * entry.value_n_per_m * u[entry.row] * u[entry.column];
      for (std::size_t i = 0; i < u.size(); ++i) sum -= one.force_n[i] * u[i];
      return sum;
    };
    for (std::size_t i = 0; i < fixture.set.weight.size(); ++i) {
      std::vector<double> u = results[c].displacement_m;
      if (boundary.held[i] != 0) {
        EXPECT_EQ(u[i], one.held_m[i]);
        continue;
      }
      u[i] += 1e-3;
      const double up = potential(u);
      u[i] -= 2e-3;
      EXPECT_NEAR((up - potential(u)) / 2e-3, 0.0, 1e-9);  // exact for a quadratic, up to rounding
    }
  }
}

TEST(Training, AdjointGradientIsThatOfFiniteDifferences) {
  for (const bool with_dilatation : {false, true}) {
    const Fixture fixture(with_dilatation);
    SplitMix64 random(17);
    std::vector<double> theta;
    for (const double constant : fixture.terms.constant)
      theta.push_back(std::log(constant) + 0.3 * (random.uniform() - 0.5));
    std::vector<double> gradient(theta.size());
    std::vector<double> unused(theta.size());
    training_objective(fixture.terms, fixture.set, 0.3, theta, gradient);
    double largest = 0.0;
    for (const double value : gradient) largest = std::max(largest, std::abs(value));
    for (std::size_t q = 0; q < theta.size(); q += 7) {
      std::vector<double> moved = theta;
      // Central differences: error h^2 = 1e-8 of the third derivative, and rounding 1e-16 / h.
      const double h = 1e-4;
      moved[q] = theta[q] + h;
      const double up = training_objective(fixture.terms, fixture.set, 0.3, moved, unused);
      moved[q] = theta[q] - h;
      const double down = training_objective(fixture.terms, fixture.set, 0.3, moved, unused);
      EXPECT_NEAR((up - down) / (2.0 * h), gradient[q], 1e-6 * largest) << "term " << q;
    }
  }
}

TEST(Training, FindsAgainTheFieldsOfConstantsItDoesNotKnow) {
  const Fixture fixture(true);
  TrainingOptions options;
  options.lbfgs.max_iterations = 400;
  const TrainingReport report = fit_constants(fixture.terms, fixture.set, options);
  EXPECT_GT(report.error_before, 0.01);
  EXPECT_LT(report.error_after, 1e-2 * report.error_before);
  for (const double constant : report.constant) EXPECT_GT(constant, 0.0);
}

TEST(Training, ARidgeKeepsNearTheStart) {
  const Fixture fixture(false);
  double last_error = 0.0;
  double last_moved = 1e9;
  for (const double ridge : {1e-6, 1e-3, 1.0}) {
    TrainingOptions options;
    options.ridge = ridge;
    const TrainingReport report = fit_constants(fixture.terms, fixture.set, options);
    double moved = 0.0;
    for (std::size_t q = 0; q < report.constant.size(); ++q)
      moved += std::pow(std::log(report.constant[q] / fixture.terms.constant[q]), 2.0);
    EXPECT_GT(report.error_after, last_error);
    EXPECT_LT(moved, last_moved);
    last_error = report.error_after;
    last_moved = moved;
  }
}

TEST(Training, TheSameInputGivesTheSameBytes) {
  const Fixture fixture(true);
  TrainingOptions options;
  options.lbfgs.max_iterations = 10;
  EXPECT_EQ(fit_constants(fixture.terms, fixture.set, options).constant,
            fit_constants(fixture.terms, fixture.set, options).constant);
}

TEST(Training, NamesACaseThatCanMoveFreelyOrHasNothingToLearn) {
  Fixture free_body(false);
  free_body.set.boundaries[1].stiffness.clear();
  try {
    solve_cases(free_body.terms, free_body.terms.constant, free_body.set);
    FAIL() << "a body without supports was solved";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("load 1"), std::string::npos) << error.what();
  }
  Fixture no_target(false);
  std::fill(no_target.set.cases[2].target_m.begin(), no_target.set.cases[2].target_m.end(), 0.0);
  try {
    fit_constants(no_target.terms, no_target.set, {});
    FAIL() << "a target of zero was learnt";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("load 2"), std::string::npos) << error.what();
  }
  Fixture wrong_shape(false);
  wrong_shape.set.cases[0].force_n.pop_back();
  EXPECT_THROW(fit_constants(wrong_shape.terms, wrong_shape.set, {}), ContractError);
}

}  // namespace

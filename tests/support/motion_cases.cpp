#include "tests/support/motion_cases.h"

#include <cmath>

#include "tests/support/dynamics_cases.h"

namespace palpate::testing_support {

using namespace dynamics;

namespace {

Loads no_loads(std::size_t vertices) {
  return {std::vector<Vec3>(vertices), {}, std::vector<std::uint8_t>(vertices), std::vector<Vec3>(vertices)};
}

}  // namespace

MotionModel make_oscillator(double omega_per_s, double damping_per_s) {
  constexpr double kMass = 2.0;
  MotionModel model;
  model.elastic.rest = {{0, 0, 0}, {1, 0, 0}};
  model.elastic.springs = {{{0, 1}}, {1.0}, {kMass * omega_per_s * omega_per_s}};
  model.mass_kg = {kMass, kMass};
  model.spring_damping_n_s_per_m = {kMass * damping_per_s};
  Loads loads = no_loads(2);
  loads.held[0] = 7;
  model.loads.push_back({loads, {}});
  return model;
}

double oscillator_at(double omega_per_s, double damping_per_s, double start_m, double time_s) {
  const double decay = 0.5 * damping_per_s;
  const double turn = std::sqrt(omega_per_s * omega_per_s - decay * decay);
  return start_m * std::exp(-decay * time_s) *
         (std::cos(turn * time_s) + decay / turn * std::sin(turn * time_s));
}

MotionModel make_free_body(const TetMesh& mesh, double damping_s, VolumeModel volume) {
  const Material material{1000.0, volume == VolumeModel::kNone ? 0.25 : 0.4, 1000.0};
  const Material fitted = spring_material(material, volume);
  MotionModel model;
  model.tets = mesh.tets;
  model.elastic = build_spring_model(mesh, make_edge_springs(mesh, fitted.young_modulus_pa), material,
                                     {volume, StrainSize::kLarge})
                      .model;
  model.mass_kg = build_lumped_masses(mesh, material.density_kg_m3);
  for (const double stiffness : model.elastic.springs.stiffness_n_per_m)
    model.spring_damping_n_s_per_m.push_back(damping_s * stiffness);
  model.strain_damping_s = damping_s;
  return model;
}

MotionModel make_pressed_body(const TetMesh& mesh, double duration_s, VolumeModel volume) {
  MotionModel model = make_free_body(mesh, 0.01, volume);
  model.environment_damping_n_s_per_m = model.mass_kg;
  BoundaryProblem still;
  still.material.density_kg_m3 = 1000.0;
  still.gravity_m_s2 = {0.0, 0.0, -0.5};
  still.held.push_back({find_faces_at(mesh, 2, 0.0), {true, true, true}, {}});
  BoundaryProblem tool;
  tool.held.push_back({find_faces_at(mesh, 2, 1.0), {true, false, true}, {0.1, 0.0, -0.1}});
  model.loads.push_back({build_loads(mesh, still), {}});
  model.loads.push_back({build_loads(mesh, tool), {{-0.1 * duration_s, 1.1 * duration_s}, {0.0, 1.0}, true}});
  return model;
}

MotionModel make_continuum(MotionModel model, const TetMesh& mesh, Continuum kind, StrainLaw law) {
  const bool is_tets = kind == Continuum::kTets;
  BlendOptions options;
  options.strain = law == StrainLaw::kLinear ? StrainSize::kSmall : StrainSize::kLarge;
  options.large_law = law;
  options.theta = is_tets ? 1.0 : 0.0;
  options.domain = is_tets ? StrainDomain::kTet : StrainDomain::kNode;
  options.rest = StrainDomain::kEdge;
  model.elastic = build_blend_model(mesh, {1000.0, 0.4, 1000.0}, options).model;
  model.spring_damping_n_s_per_m.clear();
  return model;
}

MotionState march(const MotionModel& model, const IntegratorOptions& options, MotionState state,
                  double duration_s, std::uint64_t steps) {
  Integrator integrator(model, options);
  for (std::uint64_t k = 0; k < steps; ++k) integrator.step(state, duration_s / static_cast<double>(steps));
  return state;
}

}  // namespace palpate::testing_support

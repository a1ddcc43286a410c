#include "reference/mixed_order/error_modes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/mesh/subdivision/refinement.h"
#include "core/mesh/topology.h"

namespace palpate::reference {
namespace {

/// Evenly over the sphere.
Vec3 draw_direction(SplitMix64& random) {
  const double z = 2.0 * random.uniform() - 1.0;
  const double turn = 2.0 * std::numbers::pi * random.uniform();
  const double flat = std::sqrt(std::max(0.0, 1.0 - z * z));
  return {flat * std::cos(turn), flat * std::sin(turn), z};
}

double area_of(const TetMesh& mesh, const Triangle& face) {
  return 0.5 * length(cross(mesh.points[face[1]] - mesh.points[face[0]],
                            mesh.points[face[2]] - mesh.points[face[0]]));
}

double mean_edge(const TetMesh& mesh, const std::vector<Triangle>& skin) {
  double sum = 0.0;
  for (const Triangle& face : skin) {
    for (std::size_t i = 0; i < 3; ++i) sum += length(mesh.points[face[(i + 1) % 3]] - mesh.points[face[i]]);
  }
  return sum / (3.0 * static_cast<double>(skin.size()));
}

BoundaryProblem on_fine(const TrainingBody& training, const BoundaryProblem& problem) {
  return training.refine == 0 ? problem : refine_problem(problem, training.organ, training.fine.mesh);
}

/// What is left of quadratic answers once linear ones on the same holding are taken off.
void add_samples(const TrainingBody& training, const TrainingSystem& system, std::size_t count, LoadDraw draw,
                 const dynamics::FactorMaker& make_factor, std::vector<std::vector<Vec3>>& samples) {
  const dynamics::HeldElements fine(system.body, system.whole, system.held, make_factor);
  const dynamics::HeldElements coarse(system.coarse, system.coarse.stiffness, system.coarse_held,
                                      make_factor);
  const std::vector<Triangle> skin = build_boundary(training.organ);
  const std::vector<Vec3> nothing(system.held.size());
  const std::vector<Vec3> coarse_nothing(system.coarse_held.size());
  for (std::size_t n = 0; n < count; ++n, ++draw.seed) {
    const BoundaryProblem load = on_fine(training, draw_load(training.organ, skin, draw));
    const std::vector<Vec3> force =
        build_node_loads(training.fine.mesh, training.fine.space, load, dynamics::BodyForces::kLeaveOut)
            .force_n;
    std::vector<Vec3> lack = fine.rest_under(force, nothing);
    const std::vector<Vec3> linear =
        coarse.rest_under(apply_transposed(training.fine.map, force), coarse_nothing);
    dynamics::add_scaled(lack, -1.0, apply_map(training.fine.map, linear));
    samples.push_back(std::move(lack));
  }
}

}  // namespace

TrainingBody build_training_body(const TetMesh& mesh, const BoundaryProblem& problem, int refine) {
  TrainingBody training{mesh, problem, refine, {}, problem};
  std::vector<Edge> halved;
  training.fine.mesh = mesh;
  if (refine > 0) {
    halved = build_edges(mesh);
    training.fine.mesh = refine_uniformly(mesh);
    training.fine_problem = refine_problem(problem, mesh, training.fine.mesh);
  }
  training.fine.space = dynamics::build_element_space(training.fine.mesh, 2);
  training.fine.map = embed_linear(training.fine.space, mesh.points.size(), halved);
  return training;
}

TrainingSystem build_training_system(const TrainingBody& training, dynamics::ElementMatrices body,
                                     const BoundaryProblem& organ_problem) {
  TrainingSystem system;
  system.body = std::move(body);
  system.loads = build_node_loads(training.fine.mesh, training.fine.space, on_fine(training, organ_problem),
                                  dynamics::BodyForces::kInclude);
  system.whole = system.body.stiffness;
  add_support_stiffness(system.loads, 2, system.whole);
  system.coarse.stiffness = restrict_matrix(training.fine.map, training.fine.space, system.whole);
  system.held = system.loads.held;
  for (const Index node : training.fine.map.nodes) system.coarse_held.push_back(system.held[node]);
  return system;
}

BoundaryProblem draw_load(const TetMesh& mesh, const std::vector<Triangle>& skin, const LoadDraw& draw) {
  SplitMix64 random(draw.seed);
  const Triangle& start = skin[random.below(skin.size())];
  const Vec3 center = mesh.points[start[random.below(3)]];
  const double radius =
      (draw.least_radius + (4.0 - draw.least_radius) * random.uniform()) * mean_edge(mesh, skin);
  const Vec3 direction = draw_direction(random);
  BoundaryProblem load;
  load.material = {1.0, 0.0, 1.0};
  Traction traction;
  double area = 0.0;
  for (const Triangle& face : skin) {
    const bool is_near = std::all_of(face.begin(), face.end(), [&](Index v) {
      return length_sq(mesh.points[v] - center) <= radius * radius;
    });
    if (!is_near && face != start) continue;
    traction.patch.faces.push_back(face);
    traction.patch.weight.push_back(1.0);
    area += area_of(mesh, face);
  }
  traction.traction_pa = (1.0 / area) * direction;
  load.tractions.push_back(std::move(traction));
  return load;
}

BoundaryProblem draw_holding(const TetMesh& mesh, const std::vector<Triangle>& skin,
                             const BoundaryProblem& problem, std::uint64_t seed) {
  if (!problem.held.empty() || problem.supports.empty())
    throw InputError("holdings", 0, "0 where faces are held hard or nothing is elastic", "more");
  SplitMix64 random(seed);
  const Vec3 direction = draw_direction(random);
  const double share = 0.1 + 0.2 * random.uniform();
  double low = INFINITY;
  double high = -INFINITY;
  for (const Triangle& face : skin) {
    for (const Index v : face) {
      low = std::min(low, dot(direction, mesh.points[v]));
      high = std::max(high, dot(direction, mesh.points[v]));
    }
  }
  BoundaryProblem holding;
  holding.material = problem.material;
  ElasticSupport support;
  support.stiffness_pa_per_m = problem.supports.front().stiffness_pa_per_m;
  for (const Triangle& face : skin) {
    const Vec3 middle = (1.0 / 3.0) * (mesh.points[face[0]] + mesh.points[face[1]] + mesh.points[face[2]]);
    if (dot(direction, middle) > low + share * (high - low)) continue;
    support.patch.faces.push_back(face);
    support.patch.weight.push_back(1.0);
  }
  holding.supports.push_back(std::move(support));
  return holding;
}

dynamics::PrincipalFields learn_error_modes(const TrainingBody& training, const TrainingOptions& options,
                                            const dynamics::FactorMaker& make_factor) {
  Material light = training.problem.material;
  light.density_kg_m3 = 1.0;
  dynamics::ElementMatrices body = build_element_matrices(training.fine.mesh, training.fine.space, light);
  const dynamics::ElementMatrices unit = body;  // its mass is the product of the mean square
  const std::vector<Triangle> skin = build_boundary(training.organ);
  std::vector<std::vector<Vec3>> samples;
  const std::size_t rounds = std::max<std::size_t>(options.holdings, 1);
  for (std::size_t h = 0; h < rounds; ++h) {
    const std::size_t count = options.samples * (h + 1) / rounds - options.samples * h / rounds;
    const std::uint64_t seed = options.seed * 1'000'003 + h * 100'003;
    const BoundaryProblem holding = options.holdings == 0
                                        ? holding_of(training.problem)
                                        : draw_holding(training.organ, skin, training.problem, seed);
    TrainingSystem system = build_training_system(training, std::move(body), holding);
    add_samples(training, system, count, {seed + 1, options.least_radius}, make_factor, samples);
    body = std::move(system.body);
  }
  const auto product = [&](std::span<const Vec3> x, std::span<Vec3> y) { multiply_mass(unit, x, y); };
  return dynamics::find_principal_fields(samples, product, options.modes);
}

}  // namespace palpate::reference

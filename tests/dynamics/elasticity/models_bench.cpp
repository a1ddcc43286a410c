// What a force evaluation (most of a time step) of each elastic model costs beside that of plain springs on
// the same mesh, taken in turns: counter "over_springs". And static solves.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "core/base/stopwatch.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/dynamics/statics/static_equilibrium.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"

namespace palpate::dynamics {
namespace {

constexpr Material kMaterial{10000.0, 0.45, 1000.0};

BuiltModel with_springs(const TetMesh& mesh, VolumeModel volume, StrainSize strain) {
  const Material fitted = spring_material(kMaterial, volume);
  return build_spring_model(mesh, testing_support::make_edge_springs(mesh, fitted.young_modulus_pa),
                            kMaterial, {volume, strain});
}

BuiltModel build(const std::string& name, const TetMesh& mesh, StrainSize strain) {
  BlendOptions blend;
  blend.strain = strain;
  if (name == "blend") return build_blend_model(mesh, kMaterial, blend);
  if (name == "linear_elements") {
    blend.theta = 0.0;
    blend.domain = StrainDomain::kTet;
    return build_blend_model(mesh, kMaterial, blend);
  }
  if (name == "edge_node") {
    blend.theta = 0.0;
    blend.rest = StrainDomain::kEdge;
    return build_blend_model(mesh, kMaterial, blend);
  }
  return with_springs(mesh, parse_volume_model(name), strain);
}

/// Range 0: cells a side; 1: large strain or small.
void bench_forces(benchmark::State& state, const std::string& name) {
  const TetMesh mesh = build_kuhn_cube(static_cast<int>(state.range(0)), 0.25, 1);
  const StrainSize strain = state.range(1) != 0 ? StrainSize::kLarge : StrainSize::kSmall;
  const ElasticModel plain = with_springs(mesh, VolumeModel::kNone, strain).model;
  const ElasticModel model = build(name, mesh, strain).model;
  const std::vector<Vec3> u = testing_support::make_random_field(mesh.points.size(), 1e-3, 1);
  std::vector<Vec3> force(u.size());
  const auto seconds = [&](const ElasticModel& each) {
    const Stopwatch watch;
    benchmark::DoNotOptimize(add_elastic_forces(each, u, force));
    return watch.seconds();
  };
  double of_plain = 0.0;
  double of_model = 0.0;
  for (auto _ : state) {
    of_plain += seconds(plain);
    const double here = seconds(model);
    of_model += here;
    state.SetIterationTime(here);
  }
  state.counters["over_springs"] = of_model / of_plain;
  state.counters["vertices"] = static_cast<double>(u.size());
}

/// One linearised solve of a cube on an elastic bed under its weight.
void bench_solve(benchmark::State& state, const std::string& name) {
  const TetMesh mesh = build_kuhn_cube(static_cast<int>(state.range(0)), 0.25, 1);
  BoundaryProblem problem;
  problem.material = kMaterial;
  problem.gravity_m_s2 = {0.0, 0.0, -1.0};
  ElasticSupport bed;
  bed.patch.faces = testing_support::find_faces_at(mesh, 2, 0.0);
  bed.patch.weight.assign(bed.patch.faces.size(), 1.0);
  bed.stiffness_pa_per_m = 1e5;
  problem.supports.push_back(bed);
  const Loads loads = build_loads(mesh, problem);
  const ElasticModel model = build(name, mesh, StrainSize::kSmall).model;
  StaticOptions options;
  options.linearised = true;
  StaticReport report;
  for (auto _ : state) report = solve_static(mesh, model, loads, options).report;
  state.counters["iterations"] = static_cast<double>(report.linear_iterations);
  state.counters["vertices"] = static_cast<double>(mesh.points.size());
}

const std::vector<std::string> kModels{"none",          "thesis",          "tet",   "node_average",
                                       "node_smoothed", "linear_elements", "blend", "edge_node"};

const int kRegistered = [] {
  for (const std::string& name : kModels) {
    auto* forces = benchmark::RegisterBenchmark(
        ("ModelForces/" + name).c_str(), [name](benchmark::State& state) { bench_forces(state, name); });
    for (const int large : {0, 1}) forces->Args({20, large});
    forces->Unit(benchmark::kMillisecond)->UseManualTime();
    if (name == "thesis") continue;
    benchmark::RegisterBenchmark(("ModelSolve/" + name).c_str(),
                                 [name](benchmark::State& state) { bench_solve(state, name); })
        ->Arg(10)
        ->Arg(20)
        ->Unit(benchmark::kMillisecond)
        ->MeasureProcessCPUTime();
  }
  return 0;
}();

}  // namespace
}  // namespace palpate::dynamics

#include "reference/springs/training_cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/dynamics/elasticity/loads.h"
#include "core/mesh/topology.h"
#include "core/springs/network/network.h"
#include "reference/door/deform_problem.h"
#include "reference/door/json_file.h"

namespace palpate::reference {
namespace {

std::vector<double> components_of(const std::vector<Vec3>& field) {
  std::vector<double> out;
  out.reserve(3 * field.size());
  for (const Vec3& v : field) out.insert(out.end(), {v.x, v.y, v.z});
  return out;
}

/// The elastic supports of a problem as stiffness, and their pull towards where they are.
void add_supports(const dynamics::Loads& loads, springs::TrainingBoundary& boundary,
                  std::vector<double>& force) {
  for (const dynamics::SupportFace& support : loads.supports) {
    const std::array<double, 3> by{support.by_m.x, support.by_m.y, support.by_m.z};
    for (const Index a : support.face)
      for (Index axis = 0; axis < 3; ++axis) {
        for (const Index b : support.face) {
          const double value = support.coefficient_n_per_m * (a == b ? 2.0 : 1.0);
          boundary.stiffness.push_back({3 * a + axis, 3 * b + axis, value});
        }
        force[3 * a + axis] += 4.0 * support.coefficient_n_per_m * by.at(axis);
      }
  }
}

bool is_same(const springs::TrainingBoundary& a, const springs::TrainingBoundary& b) {
  return a.held == b.held &&
         std::equal(a.stiffness.begin(), a.stiffness.end(), b.stiffness.begin(), b.stiffness.end(),
                    [](const springs::StiffnessEntry& p, const springs::StiffnessEntry& q) {
                      return p.row == q.row && p.column == q.column && p.value_n_per_m == q.value_n_per_m;
                    });
}

/// Adds the case; cases that are held alike share one boundary, and so one factorisation.
void add_case(const TetMesh& mesh, const BoundaryProblem& problem, const std::string& name,
              const std::vector<Vec3>& target, springs::TrainingSet& set) {
  const dynamics::Loads loads = dynamics::build_loads(mesh, problem);
  springs::TrainingCase one;
  one.name = name;
  one.force_n = components_of(loads.force_n);
  one.held_m = components_of(loads.held_by_m);
  one.target_m = components_of(target);
  springs::TrainingBoundary boundary;
  for (const std::uint8_t bits : loads.held)
    for (unsigned axis = 0; axis < 3; ++axis)
      boundary.held.push_back(static_cast<std::uint8_t>(bits >> axis & 1U));
  add_supports(loads, boundary, one.force_n);
  while (one.boundary < set.boundaries.size() && !is_same(set.boundaries[one.boundary], boundary))
    ++one.boundary;
  if (one.boundary == set.boundaries.size()) set.boundaries.push_back(std::move(boundary));
  set.cases.push_back(std::move(one));
}

double relative_error(const std::vector<double>& weight, const std::vector<double>& u,
                      const std::vector<double>& target) {
  double difference = 0.0;
  double size = 0.0;
  for (std::size_t i = 0; i < weight.size(); ++i) {
    difference += weight[i] * (u[i] - target[i]) * (u[i] - target[i]);
    size += weight[i] * target[i] * target[i];
  }
  return std::sqrt(difference / size);
}

/// The field of finite elements at the vertices of the mesh.
std::vector<Vec3> read_field(const nlohmann::json& path, const TetMesh& mesh) {
  std::vector<Vec3> field =
      read_displacement(path.get<std::string>(), mesh.points.size(), build_edges(mesh).size());
  field.resize(mesh.points.size());
  return field;
}

}  // namespace

TrainingSplit read_training_split(const nlohmann::json& split, const TetMesh& mesh) {
  TrainingSplit out;
  out.name = split.at("name").get<std::string>();
  for (const double volume : springs::build_influence_volumes(mesh))
    out.set.weight.insert(out.set.weight.end(), 3, volume);
  for (const nlohmann::json& one : split.at("cases")) {
    const auto problem = one.at("problem").get<std::string>();
    add_case(mesh, problem_from_json(read_json_file(problem), mesh, problem),
             one.at("name").get<std::string>(), read_field(one.at("quadratic"), mesh), out.set);
    out.linear_elements.push_back(relative_error(
        out.set.weight, components_of(read_field(one.at("linear"), mesh)), out.set.cases.back().target_m));
  }
  return out;
}

}  // namespace palpate::reference

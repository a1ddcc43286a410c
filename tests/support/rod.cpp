#include "tests/support/rod.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/mesh/topology.h"
#include "reference/closed_form/structured_mesh.h"

namespace palpate::test {
namespace {

constexpr double kRounding = 1e-12;

std::vector<Triangle> faces_at(const TetMesh& mesh, double x) {
  return reference::select_boundary(mesh, [&](const Vec3& p) { return std::fabs(p.x - x) < kRounding; });
}

}  // namespace

Rod::Rod(int cells)
    : mesh(reference::build_mapped_block({cells, 2, 2}, [](const Vec3& p) {
        return Vec3{kLengthM * p.x, kWidthM * p.y, kWidthM * p.z};
      })) {
  BoundaryProblem& body = problem.body;
  body.material = {1e4, 0.25, 1000.0};
  for (const double at : {0.0, kWidthM}) {
    const auto y =
        reference::select_boundary(mesh, [&](const Vec3& p) { return std::fabs(p.y - at) < kRounding; });
    const auto z =
        reference::select_boundary(mesh, [&](const Vec3& p) { return std::fabs(p.z - at) < kRounding; });
    body.held.push_back({y, {false, true, true}, {}});
    body.held.push_back({z, {false, true, true}, {}});
  }
  problem.duration_s = 0.2;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (mesh.points[v] == Vec3{kLengthM, 0.0, 0.0}) problem.probes = {static_cast<Index>(v)};
  }
}

std::vector<Triangle> Rod::left() const {
  return faces_at(mesh, 0.0);
}

std::vector<Triangle> Rod::right() const {
  return faces_at(mesh, kLengthM);
}

void Rod::hold_left() {
  problem.body.held.push_back({left(), {true, false, false}, {}});
}

reference::MotionLoad Rod::empty_load() const {
  reference::MotionLoad load;
  load.part.material = problem.body.material;
  return load;
}

reference::MotionLoad Rod::pad(double stiffness, double by_m) const {
  reference::MotionLoad load = empty_load();
  const std::vector<Triangle> faces = right();
  load.part.supports.push_back({{faces, std::vector<double>(faces.size(), 1.0)}, stiffness, {by_m, 0, 0}});
  return load;
}

reference::MotionLoad Rod::sine_force(double force_n_m3) const {
  reference::MotionLoad load = empty_load();
  const auto force = [&](const Vec3& p) {
    return Vec3{force_n_m3 * std::sin(std::numbers::pi * p.x / (2.0 * kLengthM)), 0.0, 0.0};
  };
  for (const Vec3& p : mesh.points) load.part.body_force_n_m3.push_back(force(p));
  for (const Edge& edge : build_edges(mesh))
    load.part.body_force_n_m3.push_back(force(0.5 * (mesh.points[edge[0]] + mesh.points[edge[1]])));
  return load;
}

double Rod::modulus_pa() const {
  return problem.body.material.lambda_pa() + 2.0 * problem.body.material.mu_pa();
}

double Rod::wave_speed_m_s() const {
  return std::sqrt(modulus_pa() / problem.body.material.density_kg_m3);
}

PushedRod::PushedRod() : Rod(6) {
  hold_left();
  problem.damping_mass_per_s = 60.0;
  problem.duration_s = 1.0;
  reference::MotionLoad push = pad(3.0 * stiffness_n_m3(), kByM);
  push.profile = {{0.0, 0.3}, {0.0, 1.0}, true};
  problem.loads = {push};
}

double PushedRod::stiffness_n_m3() const {
  return modulus_pa() / kLengthM;
}

double PushedRod::pad_force_n() const {
  return pad_force_n(std::numeric_limits<double>::infinity());
}

double PushedRod::pad_force_n(double held_n_m3) const {
  const double rod = stiffness_n_m3();
  return kByM * kAreaM2 / (1.0 / (3.0 * rod) + 1.0 / rod + 1.0 / held_n_m3);
}

std::vector<double> column(const reference::MotionHistory& history, const std::string& name) {
  const auto at = std::find(history.columns.begin(), history.columns.end(), name);
  EXPECT_NE(at, history.columns.end()) << name;
  if (at == history.columns.end()) return {};
  std::vector<double> numbers;
  for (const auto& row : history.rows)
    numbers.push_back(row[static_cast<std::size_t>(at - history.columns.begin())]);
  return numbers;
}

}  // namespace palpate::test

// fem.p1 and fem.p2 as the runner starts them, and problems for them.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "core/mesh/topology.h"
#include "experiments/contestants/contestant_run.h"
#include "reference/door/deform_problem.h"
#include "tests/support/contestant_starter.h"

namespace palpate::test {

using Field = std::function<Vec3(const Vec3&)>;

/// Starts a method on a problem.
class FiniteElements : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(starter_.registry().find("fem.p2")->contestant->unavailable(), ""); }

  experiments::ContestantAnswer run(const std::string& method, const TetMesh& mesh,
                                    const BoundaryProblem& problem,
                                    const nlohmann::json& options = nlohmann::json::object()) {
    return starter_.run(method, mesh, reference::problem_to_json(problem), options);
  }

  /// The displacement that it answers: vertices, then edge midpoints.
  std::vector<Vec3> solve(const std::string& method, const TetMesh& mesh, const BoundaryProblem& problem,
                          const nlohmann::json& options = nlohmann::json::object()) {
    const experiments::ContestantAnswer answer = run(method, mesh, problem, options);
    EXPECT_EQ(answer.outcome, "ok") << answer.message;
    if (answer.outcome != "ok") return {};
    report_ = answer.report;
    EXPECT_EQ(report_.at("outcome"), "converged");
    const std::size_t edges = build_edges(mesh).size();
    return reference::read_displacement(answer.output, mesh.points.size(), edges);
  }

  ContestantStarter starter_;
  nlohmann::json report_;
};

/// A field at the vertices and edge midpoints of a mesh.
std::vector<Vec3> at_nodes(const TetMesh& mesh, const Field& field);

/// The largest difference over the largest length of `wanted`; infinite if the sizes differ.
double difference(const std::vector<Vec3>& found, const std::vector<Vec3>& wanted);

/// Boundary faces whose corners all have `is_in`.
std::vector<Triangle> faces_where(const TetMesh& mesh, const std::function<bool(const Vec3&)>& is_in);

FacePatch patch_where(const TetMesh& mesh, const std::function<bool(const Vec3&)>& is_in,
                      double weight = 1.0);

bool is_everywhere(const Vec3&);

bool is_at_x0(const Vec3& p);

/// The unit cube with its inner vertices moved at random.
TetMesh irregular_cube();

/// Each of the planes x = 0, y = 0, z = 0 keeps to itself: a body may stretch along the axes, and nothing
/// else.
void hold_planes(const TetMesh& mesh, BoundaryProblem& problem);

/// A force a unit of area on the faces where `is_in`.
void pull(const TetMesh& mesh, const std::function<bool(const Vec3&)>& is_in, const Vec3& traction_pa,
          BoundaryProblem& problem);

/// A cube on a spring bed, pulled aside and pressed at one face by a pad.
BoundaryProblem supported_cube(const TetMesh& mesh, double scale);

}  // namespace palpate::test

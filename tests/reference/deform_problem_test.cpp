// The door of the contest deform: what is written is read back to the bit, and what does not fit is refused.
#include "reference/door/deform_problem.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/scratch_folder.h"

namespace palpate::reference {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class DeformProblem : public ::testing::Test {
 protected:
  BoundaryProblem problem() const {
    const std::vector<Triangle> faces = build_boundary(mesh_);
    BoundaryProblem made;
    made.material = {10000.0, 0.45, 1050.0};
    made.strain = StrainSize::kLarge;
    made.gravity_m_s2 = {0.0, 0.1, -9.81};
    made.held.push_back({{faces[0], faces[1]}, {true, false, true}, {0.0, 0.0, 1e-3}});
    made.supports.push_back({{{faces[2]}, {1.0 / 3.0}}, 1e6, {0.0, 0.0, -5e-3}});
    made.tractions.push_back({{{faces[3], faces[4]}, {1.0, 0.25}}, {0.0, 0.0, -100.0}, 7.0});
    made.nodal_forces.push_back({7, {0.0, 0.1, 0.0}});
    for (std::size_t i = 0; i < mesh_.points.size() + build_edges(mesh_).size(); ++i) {
      made.body_force_n_m3.push_back({1.0 / (1.0 + static_cast<double>(i)), 0.5, -2.0});
      made.held_field_m.push_back({0.0, 1e-3 / (3.0 + static_cast<double>(i)), 0.0});
    }
    return made;
  }

  /// The message with which a changed problem is refused.
  std::string refusal(const json& changed) const {
    try {
      problem_from_json(changed, mesh_, "problem.json");
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  TetMesh mesh_ = build_kuhn_cube(2, 0.0, 1);
};

TEST_F(DeformProblem, ComesBackToTheBit) {
  const json written = problem_to_json(problem());
  const BoundaryProblem read = problem_from_json(json::parse(written.dump()), mesh_, "problem.json");
  EXPECT_EQ(problem_to_json(read), written);
  EXPECT_EQ(read.supports[0].patch.weight[0], 1.0 / 3.0);
  EXPECT_EQ(read.strain, StrainSize::kLarge);
  EXPECT_FALSE(read.held[0].axes[1]);
  EXPECT_EQ(read.body_force_n_m3, problem().body_force_n_m3);
  EXPECT_EQ(read.held_field_m, problem().held_field_m);
}

TEST_F(DeformProblem, LeavesEmptyFieldsOut) {
  BoundaryProblem plain = problem();
  plain.body_force_n_m3.clear();
  plain.held_field_m.clear();
  const json written = problem_to_json(plain);
  EXPECT_FALSE(written.contains("body_force_n_m3"));
  EXPECT_FALSE(written.contains("held_field_m"));
  EXPECT_TRUE(problem_from_json(written, mesh_, "problem.json").held_field_m.empty());
}

TEST_F(DeformProblem, RefusesWhatDoesNotFitWithItsPlace) {
  const json good = problem_to_json(problem());
  const auto changed = [&](const char* pointer, const json& value) {
    json copy = good;
    copy[json::json_pointer(pointer)] = value;
    return refusal(copy);
  };
  EXPECT_EQ(refusal(good), "accepted");
  EXPECT_THAT(changed("/material/poisson_ratio", 0.5), HasSubstr("material.poisson_ratio: expected"));
  EXPECT_THAT(changed("/material/poisson_ratio", -1.0), HasSubstr("above -1 and below 0.5"));
  EXPECT_THAT(changed("/material/young_modulus_pa", 0.0), HasSubstr("a modulus above 0"));
  EXPECT_THAT(changed("/material/density_kg_m3", -1.0), HasSubstr("a density above 0"));
  EXPECT_THAT(changed("/material/young_modulus_pa", nullptr), HasSubstr("a finite number"));
  EXPECT_THAT(changed("/strain", "medium"), HasSubstr("small or large"));
  EXPECT_THAT(changed("/supports/0/weight", json::array({1.5})), HasSubstr("at most 1"));
  EXPECT_THAT(changed("/supports/0/weight", json::array({0.5, 0.5})), HasSubstr("one weight a face"));
  EXPECT_THAT(changed("/supports/0/stiffness_pa_per_m", 0.0), HasSubstr("a stiffness above 0"));
  EXPECT_THAT(changed("/supports/0/faces/0/0", 999), HasSubstr("a vertex below 27"));
  EXPECT_THAT(changed("/tractions/0/faces/0", json({0, 1, 2})), HasSubstr("faces of the boundary"));
  EXPECT_THAT(changed("/tractions/0/faces/1", good["tractions"][0]["faces"][0]), HasSubstr("each face once"));
  EXPECT_THAT(changed("/nodal_forces/0/force_n", json({1, 2})), HasSubstr("three numbers"));
  EXPECT_THAT(changed("/held/0/axes", json({1, 0, 1})), HasSubstr("held[0].axes"));
  EXPECT_THAT(changed("/body_force_n_m3/3", json({1, 2})), HasSubstr("body_force_n_m3[3]"));
  EXPECT_THAT(changed("/held_field_m", json::array()), HasSubstr("a value a vertex and a value an edge"));
  EXPECT_THAT(changed("/speed", 1), HasSubstr("no key \"speed\""));
}

TEST_F(DeformProblem, RefusesDisplacementsThatContradictEachOther) {
  json contradicting = problem_to_json(problem());
  contradicting["held"].push_back(contradicting["held"][0]);
  EXPECT_EQ(refusal(contradicting), "accepted");
  contradicting["held"][1]["by_m"] = {0.0, 0.0, 2e-3};
  EXPECT_THAT(refusal(contradicting), HasSubstr("one displacement for vertex"));
  contradicting["held"][1]["axes"] = {true, true, false};
  EXPECT_EQ(refusal(contradicting), "accepted");
}

TEST_F(DeformProblem, DisplacementsAreReadBackToTheBitAndCounted) {
  const test::ScratchFolder folder;
  const std::vector<Vec3> field{{1.0 / 3.0, -0.0, 1e-300}, {0.1, 2.0, -3.0}, {4.0, 5.0, 6.0}};
  const std::filesystem::path path = folder.path() / "displacement.csv";
  write_displacement(path, field);
  EXPECT_EQ(read_displacement(path, 3, 5), field);
  EXPECT_EQ(read_displacement(path, 1, 2), field);
  EXPECT_THROW(read_displacement(path, 2, 5), InputError);
  EXPECT_THROW(read_displacement(folder.path() / "none.csv", 3, 0), InputError);
  for (const char* bad : {"0,nan,0,0", "0,1,2", "1,0,0,0", "0,0,0,0,0", "0,inf,0,0", ""}) {
    std::ofstream(path) << "vertex,ux_m,uy_m,uz_m\n" << bad << "\n";
    EXPECT_THROW(read_displacement(path, 1, 0), InputError) << bad;
  }
}

}  // namespace
}  // namespace palpate::reference

// The remeshers of CGAL, gmsh, TetGen, Netgen and MAdLib as the runner starts them: real processes, small
// meshes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include "core/base/error.h"
#include "core/judge/mesh/judge.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/registry/method_options.h"
#include "experiments/registry/registry.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_meshes.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// A method and what it promises.
struct Promise {
  const char* method;
  const char* size_name;  ///< what it searches for
  bool keeps_skin;
  bool reaches_one_tet;
  std::map<std::string, GivenOption> options;
};

void PrintTo(const Promise& promise, std::ostream* out) {
  *out << promise.method;
}

/// Starts a contestant on a mesh.
class RemesherRun : public testing::Test {
 protected:
  MethodEntry entry(const std::string& method) const { return *registry_.find(method); }

  ContestantAnswer run(const std::string& method, const TetMesh& mesh, const Stop& stop, const json& options,
                       const json& tuned = json::object()) {
    const auto folder = scratch_ / std::to_string(++asked_);
    std::filesystem::create_directory(folder);
    ContestantTask task;
    task.method = entry(method);
    task.mesh_in = folder / "in.mesh";
    write_medit(task.mesh_in, mesh);
    task.scratch = folder;
    task.stop = stop;
    task.options = options;
    task.tuned = tuned;
    task.timeout_s = 100.0;
    return run_contestant(task);
  }

  Registry registry_ = load_registry();
  test::ScratchFolder scratch_;
  int asked_ = 0;
};

class Remeshers : public RemesherRun, public testing::WithParamInterface<Promise> {
 protected:
  void SetUp() override { ASSERT_EQ(entry().contestant->unavailable(), ""); }

  MethodEntry entry() const { return RemesherRun::entry(GetParam().method); }

  ContestantAnswer ask(const TetMesh& mesh, const Stop& stop, const json& tuned = json::object(),
                       const json& more_options = json::object()) {
    json options = resolve_options(*entry().method, GetParam().options);
    options.update(more_options);
    return run(GetParam().method, mesh, stop, options, tuned);
  }
};

TetMesh good_mesh() {
  return build_kuhn_cube(8, 0.2, 5);
}

TEST_P(Remeshers, AnswerIsValidAndMeetsTheCount) {
  const TetMesh input = good_mesh();
  const ContestantAnswer answer = ask(input, {StopKind::kRatio, 0.4, ""});
  ASSERT_EQ(answer.outcome, "ok") << answer.message;
  const TetMesh output = read_medit(answer.output, ReadOrientation::kKeep).mesh;
  const judge::Validity validity = judge::check_validity(output);
  EXPECT_TRUE(validity.is_valid()) << testing::PrintToString(validity.findings);
  const judge::Comparison comparison = judge::compare_with_input(output, input);
  if (GetParam().keeps_skin) {
    EXPECT_EQ(comparison.boundary_changed_faces, 0U);
    EXPECT_LT(comparison.volume_drift_relative, 1e-12);  // rounding of some thousand volumes
  }
  EXPECT_TRUE(comparison.euler_unchanged);
  EXPECT_TRUE(comparison.components_unchanged);

  const json& report = answer.report;
  const auto target =
      static_cast<double>(input.tets.size()) - std::ceil(0.4 * static_cast<double>(input.tets.size()));
  EXPECT_EQ(report.at("target_tets"), target);
  EXPECT_EQ(report.at("tets_out"), output.tets.size());
  EXPECT_EQ(report.at("vertices_out"), output.points.size());
  const double mismatch = static_cast<double>(output.tets.size()) / target - 1.0;
  EXPECT_NEAR(report.at("count_mismatch_relative").get<double>(), mismatch, 1e-12);
  const bool said = testing::PrintToString(answer.notes).find("nearest found") != std::string::npos;
  EXPECT_EQ(said, std::fabs(mismatch) > 0.005) << testing::PrintToString(answer.notes);
  EXPECT_LT(std::fabs(mismatch), 0.1) << "of no use as a contestant";
  EXPECT_TRUE(answer.searched);
  EXPECT_GT(answer.tuned.at(GetParam().size_name).get<double>(), 0.0);
}

TEST_P(Remeshers, WhatWasFoundGivesTheSameMeshWithoutASearch) {
  const TetMesh input = good_mesh();
  const Stop stop{StopKind::kTets, 1500.0, ""};
  const ContestantAnswer first = ask(input, stop);
  ASSERT_EQ(first.outcome, "ok") << first.message;
  const ContestantAnswer later = ask(input, stop, first.tuned);
  ASSERT_EQ(later.outcome, "ok") << later.message;
  EXPECT_EQ(later.report.at("tries"), 1);
  EXPECT_FALSE(later.searched);
  EXPECT_EQ(later.tuned, first.tuned);
  EXPECT_THAT(testing::PrintToString(later.notes), HasSubstr("handed back"));
  EXPECT_EQ(test::bytes_of(first.output), test::bytes_of(later.output));
}

TEST_P(Remeshers, ACountOutOfReachGivesTheNearestAndSaysSo) {
  const ContestantAnswer answer = ask(build_kuhn_cube(4, 0.1, 1), {StopKind::kTets, 1.0, ""});
  ASSERT_EQ(answer.outcome, "ok") << answer.message;
  if (GetParam().reaches_one_tet) {
    EXPECT_EQ(answer.report.at("tets_out"), 1);
    return;
  }
  EXPECT_GT(answer.report.at("tets_out"), 1);
  EXPECT_THAT(testing::PrintToString(answer.notes),
              HasSubstr("more tetrahedra than asked for, the nearest found"));
  EXPECT_TRUE(judge::check_validity(read_medit(answer.output, ReadOrientation::kKeep).mesh).is_valid());
}

TEST_P(Remeshers, RefusesOptionsAndParametersThatItDoesNotKnow) {
  const TetMesh mesh = build_kuhn_cube(3, 0.0, 0);
  const Stop stop{StopKind::kRatio, 0.5, ""};
  const ContestantAnswer unknown = ask(mesh, stop, json::object(), {{"smoothness", 3}});
  EXPECT_EQ(unknown.outcome, "bad_input");
  EXPECT_THAT(unknown.message, HasSubstr("smoothness"));
  for (const json& tuned : {json{{"radius", 1.0}}, json{{GetParam().size_name, 0.0}}}) {
    const ContestantAnswer answer = ask(mesh, stop, tuned);
    EXPECT_EQ(answer.outcome, "bad_input") << tuned;
    EXPECT_THAT(answer.message, HasSubstr("tuned"));
  }
}

TEST_P(Remeshers, RefusesStopsThatItsDescriptionDoesNotOffer) {
  EXPECT_EQ(entry().method->stops, (std::vector<std::string>{"tets", "ratio"}));
  const TetMesh mesh = build_kuhn_cube(3, 0.0, 0);
  for (const Stop& stop : {Stop{StopKind::kFusions, 3.0, ""}, Stop{StopKind::kLimit, 0.0, ""},
                           Stop{StopKind::kTets, 0.0, ""}, Stop{StopKind::kRatio, 1.0, ""}}) {
    const ContestantAnswer answer = ask(mesh, stop);
    EXPECT_EQ(answer.outcome, "bad_input") << stop_name(stop.kind) << " " << stop.value;
    EXPECT_THAT(answer.message, HasSubstr("tets (a whole number, 1 or more) or ratio"));
  }
}

/// A face of three tets: no boundary surface, no triangulation.
TEST_P(Remeshers, AMeshThatIsNotManifoldIsAnErrorInOneLine) {
  TetMesh mesh = testing_support::make_two_tets();
  mesh.points.push_back({0.4, 0.3, 2.0});
  mesh.tets.push_back(mesh.tets.front());
  for (Index& v : mesh.tets.back()) {
    if (v != mesh.tets[1][0] && v != mesh.tets[1][1] && v != mesh.tets[1][2] && v != mesh.tets[1][3])
      v = static_cast<Index>(mesh.points.size() - 1);
  }
  const ContestantAnswer answer = ask(mesh, {StopKind::kRatio, 0.1, ""});
  EXPECT_TRUE(answer.outcome == "bad_input" || answer.outcome == "error") << answer.outcome;
  EXPECT_THAT(answer.message, testing::AnyOf(HasSubstr("manifold"), HasSubstr("tets")));
}

TEST_P(Remeshers, AMissingMeshIsBadInput) {
  ContestantTask task;
  task.method = entry();
  task.mesh_in = scratch_ / "none.mesh";
  task.scratch = scratch_.path();
  task.stop = {StopKind::kRatio, 0.5, ""};
  task.options = resolve_options(*task.method.method, {});
  const ContestantAnswer answer = run_contestant(task);
  EXPECT_EQ(answer.outcome, "bad_input");
  EXPECT_THAT(answer.message, HasSubstr("no such file"));
}

/// For tests in which the count does not matter.
const json kNoSearch{{"interior_size", 0.12}};

TEST_F(RemesherRun, CollapseKeepsTheShareOfTheSkinThatIsAskedFor) {
  const TetMesh input = good_mesh();
  const auto edges_in = static_cast<double>(judge::count_elements(input).boundary_edges);
  for (const double kept : {0.0, 0.5, 0.9}) {
    const ContestantAnswer answer =
        run("cgal.collapse", input, {StopKind::kRatio, 0.3, ""}, {{"skin_edges_kept", kept}}, kNoSearch);
    ASSERT_EQ(answer.outcome, "ok") << answer.message;
    const TetMesh output = read_medit(answer.output, ReadOrientation::kKeep).mesh;
    const double wanted = edges_in * (kept > 0.0 ? kept : std::pow(0.7, 2.0 / 3.0));
    // A collapse takes three edges of a closed surface at once.
    EXPECT_NEAR(static_cast<double>(judge::count_elements(output).boundary_edges), wanted, 3.5) << kept;
  }
}

/// gmsh optimises the tets below the threshold: at 0 none, so that what slivers it makes stay.
TEST_F(RemesherRun, ThresholdOfGmshIsHandedOn) {
  const TetMesh input = good_mesh();
  for (const char* method : {"gmsh.remesh", "cgal.collapse"}) {
    std::vector<double> least;
    for (const double threshold : {0.0, 0.9}) {
      const ContestantAnswer answer =
          run(method, input, {StopKind::kRatio, 0.3, ""}, {{"optimize_threshold", threshold}}, kNoSearch);
      ASSERT_EQ(answer.outcome, "ok") << answer.message;
      const TetMesh output = read_medit(answer.output, ReadOrientation::kKeep).mesh;
      EXPECT_TRUE(judge::check_validity(output).is_valid());
      least.push_back(judge::measure_quality(output).p1_dihedral_deg);
    }
    EXPECT_LT(least[0], least[1]) << method;
    const ContestantAnswer refused =
        run(method, input, {StopKind::kRatio, 0.3, ""}, {{"optimize_threshold", 1.5}}, kNoSearch);
    EXPECT_EQ(refused.outcome, "bad_input");
    EXPECT_THAT(refused.message, HasSubstr("optimize_threshold"));
  }
}

const Promise kPromises[] = {
    {"cgal.remesh", "edge_length", true, false, {{"iterations", {"2", "test"}}}},
    {"cgal.remesh_free", "edge_length", false, false, {}},
    {"cgal.mesh_3", "cell_size", false, false, {}},
    {"cgal.collapse", "interior_size", false, true, {{"cost", {"garland_heckbert", "test"}}}},
    {"gmsh.remesh", "interior_size", true, false, {}},
    {"tetgen.coarsen", "size", true, false, {}},
    {"netgen.remesh", "longest_edge", true, false, {}},
    {"madlib.adapt", "edge_length", true, false, {}},
};

std::string promise_name(const testing::TestParamInfo<Promise>& promise) {
  std::string name = promise.param.method;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(All, Remeshers, testing::ValuesIn(kPromises), promise_name);

}  // namespace
}  // namespace palpate::experiments

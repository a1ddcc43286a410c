// The contestants that take a mesh apart, VTK's decimation and random collapses, and our order by outcome, as
// the runner starts them: real processes, small meshes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "core/base/error.h"
#include "core/judge/mesh/judge.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/space_order.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/registry/method_options.h"
#include "experiments/registry/registry.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_meshes.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

struct Decimator {
  const char* method;
  bool is_ours;  ///< valid whatever happens, the boundary kept to the bit, knows a limit
  bool has_a_seed;
};

void PrintTo(const Decimator& decimator, std::ostream* out) {
  *out << decimator.method;
}

class Decimators : public testing::TestWithParam<Decimator> {
 protected:
  void SetUp() override { ASSERT_EQ(entry().contestant->unavailable(), ""); }

  MethodEntry entry() const { return *registry_.find(GetParam().method); }

  ContestantAnswer ask(const TetMesh& mesh, const Stop& stop, const json& more_options = json::object()) {
    const auto folder = scratch_ / std::to_string(++asked_);
    std::filesystem::create_directory(folder);
    ContestantTask task;
    task.method = entry();
    task.mesh_in = folder / "in.mesh";
    write_medit(task.mesh_in, mesh);
    task.scratch = folder;
    task.stop = stop;
    task.options = resolve_options(*task.method.method, {});
    task.options.update(more_options);
    task.timeout_s = 100.0;
    return run_contestant(task);
  }

  Registry registry_ = load_registry();
  test::ScratchFolder scratch_;
  int asked_ = 0;
};

TEST_P(Decimators, AnswerMeetsTheCountAndSaysWhatItIs) {
  const TetMesh input = build_kuhn_cube(8, 0.2, 5);
  const ContestantAnswer answer = ask(input, {StopKind::kRatio, 0.3, ""});
  ASSERT_EQ(answer.outcome, "ok") << answer.message;
  const TetMesh output = read_medit(answer.output, ReadOrientation::kKeep).mesh;
  const double target = std::floor(0.7 * static_cast<double>(input.tets.size()));
  EXPECT_LE(static_cast<double>(output.tets.size()), target);
  EXPECT_GT(static_cast<double>(output.tets.size()), target - 40.0);  // one step's removal
  EXPECT_EQ(answer.report.at("tets_in"), input.tets.size());
  EXPECT_EQ(answer.report.at("tets_out"), output.tets.size());
  EXPECT_EQ(answer.report.at("vertices_out"), output.points.size());
  EXPECT_EQ(answer.report.at("stop"), "ratio");
  if (!GetParam().is_ours) return;
  const judge::Validity validity = judge::check_validity(output);
  EXPECT_TRUE(validity.is_valid()) << testing::PrintToString(validity.findings);
  const judge::Comparison comparison = judge::compare_with_input(output, input);
  EXPECT_EQ(comparison.boundary_changed_faces, 0U);
  EXPECT_TRUE(comparison.euler_unchanged);
  EXPECT_LT(comparison.volume_drift_relative, 1e-12);  // rounding of some thousand volumes
}

TEST_P(Decimators, TheSameRequestGivesTheSameBytesAndAnotherSeedOthers) {
  const TetMesh input = build_kuhn_cube(6, 0.3, 5);
  const Stop stop{StopKind::kRatio, 0.3, ""};
  const ContestantAnswer first = ask(input, stop);
  const ContestantAnswer second = ask(input, stop);
  ASSERT_EQ(first.outcome, "ok") << first.message;
  ASSERT_EQ(second.outcome, "ok") << second.message;
  EXPECT_EQ(test::bytes_of(first.output), test::bytes_of(second.output));
  if (!GetParam().has_a_seed) return;
  const ContestantAnswer other = ask(input, stop, {{"seed", 2}});
  ASSERT_EQ(other.outcome, "ok") << other.message;
  EXPECT_NE(test::bytes_of(first.output), test::bytes_of(other.output));
}

TEST_P(Decimators, ACountThatIsMissedIsSaid) {
  const ContestantAnswer answer = ask(build_kuhn_cube(8, 0.2, 5), {StopKind::kTets, 9.0, ""});
  ASSERT_EQ(answer.outcome, "ok") << answer.message;
  const TetMesh output = read_medit(answer.output, ReadOrientation::kKeep).mesh;
  EXPECT_EQ(answer.report.at("tets_out"), output.tets.size());
  if (GetParam().is_ours) {
    EXPECT_GT(output.tets.size(), 9U);
    EXPECT_EQ(answer.report.at("stop"), "limit");
  } else {
    const bool said =
        testing::PrintToString(answer.notes).find("where 9 were asked for") != std::string::npos;
    EXPECT_EQ(said, output.tets.size() != 9U) << output.tets.size();
  }
}

TEST_P(Decimators, RefusesWhatItDoesNotKnow) {
  const TetMesh mesh = build_kuhn_cube(3, 0.0, 0);
  const Stop stop{StopKind::kRatio, 0.5, ""};
  const ContestantAnswer unknown = ask(mesh, stop, {{"smoothness", 3}});
  EXPECT_EQ(unknown.outcome, "bad_input");
  EXPECT_THAT(unknown.message, HasSubstr("smoothness"));
  for (const Stop& bad : {Stop{StopKind::kTets, 0.0, ""}, Stop{StopKind::kRatio, 1.0, ""}}) {
    const ContestantAnswer answer = ask(mesh, bad);
    EXPECT_EQ(answer.outcome, "bad_input") << stop_name(bad.kind) << " " << bad.value;
  }
  if (!GetParam().has_a_seed) return;
  const ContestantAnswer seed = ask(mesh, stop, {{"seed", -1}});
  EXPECT_EQ(seed.outcome, "bad_input");
  EXPECT_THAT(seed.message, HasSubstr("seed"));
  const ContestantAnswer fusions = ask(mesh, {StopKind::kFusions, 3.0, ""});
  EXPECT_EQ(fusions.outcome, "bad_input");
}

TEST_P(Decimators, AMeshThatCannotBeReadIsBadInput) {
  ContestantTask task;
  task.method = entry();
  task.mesh_in = scratch_ / "none.mesh";
  task.scratch = scratch_.path();
  task.stop = {StopKind::kRatio, 0.5, ""};
  task.options = resolve_options(*task.method.method, {});
  const ContestantAnswer missing = run_contestant(task);
  EXPECT_EQ(missing.outcome, "bad_input");
  EXPECT_THAT(missing.message, HasSubstr("no such file"));
  scratch_.add("none.mesh", "MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 0 nan 1\n");
  const ContestantAnswer broken = run_contestant(task);
  EXPECT_EQ(broken.outcome, "bad_input");
  EXPECT_THAT(broken.message, HasSubstr("none.mesh"));
}

class OurDecimators : public Decimators {};

/// A face of three tets.
TEST_P(OurDecimators, AMeshThatIsNotManifoldIsRefused) {
  TetMesh mesh = testing_support::make_two_tets();
  mesh.points.push_back({0.4, 0.3, 2.0});
  mesh.tets.push_back(mesh.tets.front());
  for (Index& v : mesh.tets.back()) {
    if (std::count(mesh.tets[1].begin(), mesh.tets[1].end(), v) == 0)
      v = static_cast<Index>(mesh.points.size() - 1);
  }
  const ContestantAnswer answer = ask(mesh, {StopKind::kRatio, 0.1, ""});
  EXPECT_EQ(answer.outcome, "bad_input");
  EXPECT_THAT(answer.message, HasSubstr("non-manifold"));
}

TEST_P(OurDecimators, AMeshWithoutAnythingToTakeAwayIsLeftAsItIs) {
  const TetMesh input = build_kuhn_cube(1, 0.0, 0);
  const ContestantAnswer answer = ask(input, {StopKind::kLimit, 0.0, ""});
  ASSERT_EQ(answer.outcome, "ok") << answer.message;
  EXPECT_EQ(answer.report.at("stop"), "limit");
  EXPECT_EQ(read_medit(answer.output).mesh, input);
}

class VtkQuadric : public Decimators {};

TEST_P(VtkQuadric, InTheOrderOfSpaceItIsGivenTheSortedMesh) {
  const TetMesh input = build_kuhn_cube(6, 0.2, 3);
  TetMesh sorted = input;
  sort_in_space(sorted);
  ASSERT_NE(sorted, input);
  const Stop stop{StopKind::kRatio, 0.3, ""};
  const ContestantAnswer given = ask(input, stop);
  const ContestantAnswer ordered = ask(input, stop, {{"order", "space"}});
  const ContestantAnswer as_sorted = ask(sorted, stop);
  for (const ContestantAnswer* answer : {&given, &ordered, &as_sorted})
    ASSERT_EQ(answer->outcome, "ok") << answer->message;
  EXPECT_EQ(test::bytes_of(ordered.output), test::bytes_of(as_sorted.output));
  EXPECT_NE(test::bytes_of(ordered.output), test::bytes_of(given.output));
  EXPECT_EQ(ask(input, stop, {{"order", "random"}}).outcome, "bad_input");
}

const Decimator kOurs[] = {{"palpate.outcome", true, false}, {"random.edge_collapse", true, true}};
const Decimator kVendors[] = {{"vtk.quadric", false, true}};

std::string decimator_name(const testing::TestParamInfo<Decimator>& tested) {
  std::string name = tested.param.method;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Ours, Decimators, testing::ValuesIn(kOurs), decimator_name);
INSTANTIATE_TEST_SUITE_P(Vendors, Decimators, testing::ValuesIn(kVendors), decimator_name);
INSTANTIATE_TEST_SUITE_P(Ours, OurDecimators, testing::ValuesIn(kOurs), decimator_name);
INSTANTIATE_TEST_SUITE_P(Vendors, VtkQuadric, testing::ValuesIn(kVendors), decimator_name);

}  // namespace
}  // namespace palpate::experiments

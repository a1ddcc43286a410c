// Meshes that are graded by a scene, and what becomes of them when time or user stop it.
#include "experiments/fit/fit_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "experiments/scene_reader/scene_problem.h"
#include "tests/support/scene_text.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A bar on a bed, and candidates with a mesh that is graded by where it is held, and one by a pilot that
/// never ends.
class FitGrading : public testing::Test {
 protected:
  FitGrading() {
    std::filesystem::create_directories(folder_ / "slow");
    folder_.add("slow/contestant.yaml",
                "schema: palpate/contestant/1\ncontest: deform\ncommand: [sh, wait.sh]\nfiles: [wait.sh]\n"
                "licence: MIT\nmethods: [{name: slow.wait, summary: never ends}]\n");
    folder_.add("slow/wait.sh", "touch \"$PALPATE_STARTED\"\nsleep 3600\n");
    ::setenv("PALPATE_STARTED", started().c_str(), 1);
    registry_ = load_registry({folder_ / "slow"});
    test::SceneText text;
    text.mesh = "{make: bar, vertices: 200, length_m: 0.1}";
    text.clamp = "[{half_space: {normal: [1, 0, 0], share: 0.1}, elastic_pa_per_m: 1.0e+6}]";
    scene_ = read_scene(folder_.add("scene.yaml", text.yaml()));
    mesh_ = build_scene_mesh(scene_.mesh).mesh;
  }
  ~FitGrading() override { ::unsetenv("PALPATE_STARTED"); }

  std::string started() const { return (folder_ / "started").string(); }

  FitCandidates candidates(const std::string& graded) const {
    return read_candidates(
        folder_.add("candidates.yaml",
                    "schema: palpate/candidates/1\nsimplifiers:\n"
                    "  - {label: plain, method: palpate.refined, ratios: [0.3]}\n" +
                        graded + "models: [{label: m, method: smoothed.edge_node, works: {first: []}}]\n"),
        registry_);
  }
  bool grade(FitCandidates& of, double seconds, const volatile std::sig_atomic_t* stop_flag = nullptr) {
    return grade_simplifiers(of, scene_, mesh_, {registry_, folder_ / "sizes", seconds, stop_flag}, dropped_);
  }

  static std::vector<std::string> labels(const FitCandidates& of) {
    std::vector<std::string> names;
    for (const FitSimplifier& simplifier : of.simplifiers) names.push_back(simplifier.label);
    return names;
  }

  const std::string held_ =
      "  - {label: held, method: palpate.refined, ratios: [0.3], grade: {near: [supports]}}\n";
  const std::string slow_ =
      "  - {label: slow, method: palpate.refined, ratios: [0.3], grade: {pilot: slow.wait}}\n";
  test::ScratchFolder folder_;
  Registry registry_{std::vector<Contestant>{}};
  Scene scene_;
  TetMesh mesh_;
  std::vector<std::string> dropped_;
};

TEST_F(FitGrading, SizesLieInTheFolderAndNothingIsLeftOut) {
  FitCandidates own = candidates(held_);
  EXPECT_TRUE(grade(own, 600.0));
  EXPECT_THAT(labels(own), ElementsAre("plain", "held"));
  EXPECT_TRUE(std::filesystem::exists(own.simplifiers.back().set.at("sizes").get<std::string>()));
  EXPECT_THAT(dropped_, testing::IsEmpty());
}

TEST_F(FitGrading, ATimeLimitEndsAPilotAndWhatComesAfterIt) {
  FitCandidates own = candidates(slow_ + held_);
  EXPECT_FALSE(grade(own, 2.0)) << "an hour less";
  EXPECT_TRUE(std::filesystem::exists(started())) << "the pilot was begun";
  EXPECT_THAT(labels(own), ElementsAre("plain"));
  EXPECT_THAT(dropped_,
              ElementsAre(AllOf(HasSubstr("slow (graded palpate.refined): its sizes were not found: the "),
                                HasSubstr("that there were for it are over")),
                          HasSubstr("held (graded palpate.refined): its sizes were not found")));
}

TEST_F(FitGrading, WithoutTimeNothingIsBegun) {
  FitCandidates own = candidates(slow_);
  EXPECT_FALSE(grade(own, 0.0));
  EXPECT_FALSE(std::filesystem::exists(started()));
  EXPECT_THAT(labels(own), ElementsAre("plain"));
}

TEST_F(FitGrading, AnInterruptIsSaidAsOne) {
  const volatile std::sig_atomic_t flag = 1;
  FitCandidates own = candidates(slow_);
  EXPECT_FALSE(grade(own, 600.0, &flag));
  EXPECT_THAT(dropped_, ElementsAre(HasSubstr("its sizes were not found: it was interrupted")));
}

}  // namespace
}  // namespace palpate::experiments

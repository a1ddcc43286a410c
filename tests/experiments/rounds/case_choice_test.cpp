#include "experiments/rounds/case_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "experiments/runner/contest_table.h"
#include "experiments/runner/read_plan.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Two meshes, three labels, a sweep; tags on a mesh and on labels; one label needs another one's cases.
class CaseChoiceTest : public testing::Test {
 protected:
  CaseChoiceTest() {
    const auto file = fixture_.folder().add(
        "chosen.yaml",
        "schema: palpate/plan/1\nquestion: q\ncontest: simplify\nmeshes:\n"
        "  - {name: cube, file: cube.mesh}\n  - {name: block, file: cube.mesh, tags: [large, box]}\n"
        "contestants:\n  - {method: test.copy, label: a, tags: [ours]}\n"
        "  - {method: test.copy, label: b, tags: [ours, fast]}\n"
        "  - {method: test.copy, label: c, stop: {tets_of: a}}\nsweep: {tets_removed_ratio: [0.1, 0.5]}\n");
    plan_ = read_plan(file, fixture_.registry());
    cases_ = build_cases(plan_, fixture_.registry());
  }

  std::vector<std::string> chosen(const CaseChoice& choice) const {
    std::vector<std::string> ids;
    for (const std::size_t i : choose_cases(plan_, cases_, choice)) ids.push_back(cases_[i].id);
    return ids;
  }

  std::string refusal(const CaseChoice& choice) const {
    try {
      choose_cases(plan_, cases_, choice);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  test::ExperimentFixture fixture_;
  Plan plan_;
  std::vector<Case> cases_;
};

TEST_F(CaseChoiceTest, WordsAreMeshesLabelsTagsAndIds) {
  ASSERT_EQ(cases_.size(), 12U);
  EXPECT_EQ(chosen({}).size(), 12U);
  EXPECT_EQ(chosen({"", {"cube"}}).size(), 6U);
  EXPECT_EQ(chosen({"", {"large"}}), chosen({"", {"block"}}));
  EXPECT_THAT(chosen({"", {"b"}}),
              ElementsAre("cube/b/tets_removed_ratio=0.1", "cube/b/tets_removed_ratio=0.5",
                          "block/b/tets_removed_ratio=0.1", "block/b/tets_removed_ratio=0.5"));
  EXPECT_EQ(chosen({"", {"fast"}}), chosen({"", {"b"}}));
  EXPECT_EQ(chosen({"", {"ours"}}).size(), 8U);
  EXPECT_THAT(chosen({"", {"cube/b/tets_removed_ratio=0.5"}}), ElementsAre("cube/b/tets_removed_ratio=0.5"));
}

TEST_F(CaseChoiceTest, PatternsAreForTheWholeIdAndStarsForSlashesToo) {
  EXPECT_THAT(chosen({"", {"*=0.5"}}),
              ElementsAre("cube/a/tets_removed_ratio=0.5", "cube/b/tets_removed_ratio=0.5",
                          "cube/c/tets_removed_ratio=0.5", "block/a/tets_removed_ratio=0.5",
                          "block/b/tets_removed_ratio=0.5", "block/c/tets_removed_ratio=0.5"));
  EXPECT_THAT(chosen({"", {"cube/[ab]/*0.1"}}),
              ElementsAre("cube/a/tets_removed_ratio=0.1", "cube/b/tets_removed_ratio=0.1"));
  EXPECT_THAT(chosen({"", {"?ube/b/*0.1"}}), ElementsAre("cube/b/tets_removed_ratio=0.1"));
}

TEST_F(CaseChoiceTest, AnyOfSeveralAndWithAStartOfTheId) {
  EXPECT_EQ(chosen({"", {"a", "b"}}), chosen({"", {"ours"}}));
  EXPECT_THAT(chosen({"cube", {"fast"}}),
              ElementsAre("cube/b/tets_removed_ratio=0.1", "cube/b/tets_removed_ratio=0.5"));
}

TEST_F(CaseChoiceTest, WhatACaseNeedsComesAlong) {
  EXPECT_THAT(chosen({"", {"cube/c/*0.1"}}),
              ElementsAre("cube/a/tets_removed_ratio=0.1", "cube/c/tets_removed_ratio=0.1"));
}

TEST_F(CaseChoiceTest, WhatFitsNothingIsRefusedWithTheNearest) {
  EXPECT_THAT(refusal({"", {"cubee"}}), HasSubstr("is called \"cubee\"; did you mean \"cube\"?"));
  EXPECT_THAT(refusal({"", {"cube", "lerge"}}), HasSubstr("did you mean \"large\"?"));
  EXPECT_THAT(refusal({"", {"cube/b/tets_removed_ratio=0.6"}}), HasSubstr("did you mean \"cube/b/tets_"));
  EXPECT_THAT(refusal({"", {"sphere/*"}}), HasSubstr("the pattern \"sphere/*\" fits no case"));
  EXPECT_THAT(refusal({"cube", {"block"}}), HasSubstr("no case of cube fits --only block"));
}

TEST_F(CaseChoiceTest, APartMayHaveTheLineEndsOfWindowsAndNamesACase) {
  const test::ScratchFolder folder;
  const auto part = [&](const std::string& text) {
    CaseChoice choice;
    choice.part = folder.add("part.txt", text).string();
    return choice;
  };
  EXPECT_EQ(chosen(part("cube/b/tets_removed_ratio=0.1\r\n\r\ncube/b/tets_removed_ratio=0.5\r\n")),
            chosen({"cube", {"fast"}}));
  for (const char* empty : {"", "\n", "\r\n\r\n"})
    EXPECT_THAT(refusal(part(empty)),
                testing::EndsWith("part.txt: expected cases of the plan, one a line, found none"))
        << empty;
  CaseChoice other = part("cube/b/tets_removed_ratio=0.1\n");
  other.only = {"block"};
  EXPECT_THAT(refusal(other), testing::EndsWith("part.txt fits --only block"));
  other.only = {};
  other.case_id = "block";
  EXPECT_THAT(refusal(other), testing::EndsWith("part.txt fits --case block"));
}

TEST_F(CaseChoiceTest, ItIsStated) {
  EXPECT_TRUE(describe_choice({}).is_null());
  EXPECT_EQ(describe_choice({"cube", {"a", "b"}}), nlohmann::json({{"case", "cube"}, {"only", {"a", "b"}}}));
}

}  // namespace
}  // namespace palpate::experiments

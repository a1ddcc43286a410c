#include "experiments/rounds/case_ledger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/runner/contest_table.h"
#include "experiments/runner/read_plan.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::Pair;

/// Two cases of two repeats and a warm-up.
class CaseLedgerTest : public testing::Test {
 protected:
  CaseLedgerTest() {
    const auto file = fixture_.folder().add(
        "kept.yaml",
        "schema: palpate/plan/1\nquestion: q\ncontest: simplify\nmeshes:\n"
        "  - {name: cube, file: cube.mesh}\ncontestants:\n  - {method: test.copy, label: a}\n"
        "  - {method: test.copy, label: b}\nsweep: {tets_removed_ratio: [0.1]}\nrun: {repeats: 2, warmup: "
        "1}\n");
    plan_ = read_plan(file, fixture_.registry());
    cases_ = build_cases(plan_, fixture_.registry());
  }

  json record_of(std::size_t index, int repeat, const std::string& outcome = "accepted") const {
    return {{"schema", "palpate/record/1"},
            {"case", cases_[index].id},
            {"contestant", cases_[index].id},
            {"repeat", repeat},
            {"warmup", repeat == 0},
            {"outcome", outcome},
            {"kernel_s", 1.0},
            {"wall_s", 2.0},
            {"violations", json::array()},
            {"message", ""}};
  }

  test::ExperimentFixture fixture_;
  Plan plan_;
  std::vector<Case> cases_;
};

TEST_F(CaseLedgerTest, WhatIsDueIsWhatNoRecordHas) {
  CaseLedger ledger(plan_, cases_);
  EXPECT_EQ(ledger.rounds(), 3);
  EXPECT_EQ(ledger.count_due(0), 3);
  for (int repeat = 0; repeat < 3; ++repeat) {
    EXPECT_TRUE(ledger.is_due(0, repeat));
    ledger.remember(0, record_of(0, repeat));
    EXPECT_FALSE(ledger.is_due(0, repeat));
  }
  EXPECT_FALSE(ledger.has_due(0));
  EXPECT_TRUE(ledger.has_due(1)) << "the other case has books of its own";
  EXPECT_EQ(ledger.state(0).wall_s, 2.0);
}

TEST_F(CaseLedgerTest, AFileIsTakenInAnew) {
  json input = record_of(0, 0, "bad_input");
  input.update({{"case", "cube"}, {"contestant", nullptr}, {"message", "no such file"}});
  const auto file = fixture_.folder().add(
      "records.jsonl", record_of(1, 0).dump() + "\n" + input.dump() + "\n" + record_of(1, 1).dump() + "\n");
  CaseLedger ledger(plan_, cases_);
  ledger.remember(0, record_of(0, 0));
  ledger.load(file);
  EXPECT_EQ(ledger.count_due(0), 3) << "what was known before is not in the file";
  EXPECT_EQ(ledger.count_due(1), 1);
  EXPECT_THAT(ledger.recorded_inputs(), ElementsAre("cube"));
  EXPECT_THAT(ledger.failed_inputs(), ElementsAre(Pair("cube", "bad_input: no such file")));
}

TEST_F(CaseLedgerTest, ACaseThatTimedOutIsNotRepeated) {
  CaseLedger ledger(plan_, cases_);
  ledger.remember(0, record_of(0, 0, "timed_out"));
  EXPECT_FALSE(ledger.has_due(0));
}

TEST_F(CaseLedgerTest, WithoutHalvingNoneIsLeftOut) {
  CaseLedger ledger(plan_, cases_);
  for (const std::size_t index : {0U, 1U}) {
    for (int repeat = 0; repeat < 2; ++repeat) ledger.remember(index, record_of(index, repeat));
  }
  EXPECT_TRUE(ledger.halve(1, {0, 1}).empty());
  json provenance;
  ledger.state_repeats(provenance);
  EXPECT_FALSE(provenance.contains("repeats_ended"));
}

}  // namespace
}  // namespace palpate::experiments

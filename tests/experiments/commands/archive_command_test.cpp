// palpate archive, and report of what it leaves, as a user starts them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/files/plain_file.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/quiet_run.h"

namespace palpate::experiments {
namespace {

using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;

/// One small run, and places beside it.
class ArchiveCommand : public testing::Test {
 protected:
  ArchiveCommand() {
    const auto plan = fixture_.add_plan("[{method: test.copy, label: a}]", "run: {repeats: 2}\n");
    test::run_quietly(fixture_, plan, fixture_.folder() / "run");
  }

  std::string at(const std::string& name) const { return (fixture_.folder() / name).string(); }

  test::ExperimentFixture fixture_;
};

TEST_F(ArchiveCommand, ARunIsAReportAgain) {
  ASSERT_EQ(run_program({"report", at("run")}).exit_code, 0);
  const ProgramResult packed = run_program({"archive", at("run"), "-o", at("packed")});
  ASSERT_EQ(packed.exit_code, 0) << packed.error;
  EXPECT_THAT(packed.out, HasSubstr("3 records of plan"));
  const ProgramResult again = run_program({"report", at("packed"), "-o", at("again")});
  EXPECT_EQ(again.exit_code, 0) << again.error;
  EXPECT_THAT(again.out, HasSubstr("Page: " + at("again") + "/report.html"));
  for (const char* name : {"records.jsonl", "tables/quality.csv", "tables/timing.csv"}) {
    ASSERT_TRUE(read_bytes(at("again") + "/" + name)) << name;
    EXPECT_EQ(read_bytes(at("again") + "/" + name), read_bytes(at("run") + "/" + name)) << name;
  }
  EXPECT_FALSE(read_bytes(at("packed") + "/report.html")) << "an archive is left as it is";
}

TEST_F(ArchiveCommand, WhatCannotBeIsRefused) {
  ASSERT_EQ(run_program({"archive", at("run"), "-o", at("packed")}).exit_code, 0);
  const auto refused = [&](const std::vector<std::string>& words, const std::string& reason) {
    const ProgramResult result = run_program(words);
    EXPECT_EQ(result.exit_code, 2) << result.out;
    EXPECT_THAT(result.error, HasSubstr(reason));
  };
  refused({"archive", at("run"), "-o", at("packed")}, "empty folder");
  refused({"archive", at("none"), "-o", at("other")}, "the folder of a run");
  refused({"report", at("packed")}, "-o FOLDER");
  refused({"report", at("run"), at("packed"), "-o", at("page.html")}, "unpack it first");
  refused({"report", at("packed"), "-o", at("run")}, "empty folder");
  fixture_.folder().add("packed/archive.json", "{\"schema\": \"palpate/archive/2\"}");
  refused({"report", at("packed"), "-o", at("again")}, "palpate/archive/1");
}

}  // namespace
}  // namespace palpate::experiments

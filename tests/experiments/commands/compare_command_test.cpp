// palpate compare and report, and plans by their bare names, as a user starts them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/files/places.h"
#include "experiments/files/plain_file.h"
#include "experiments/records/record_file.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/quiet_run.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;

/// Two runs of one plan; in the second, kernel times of the label b are multiplied.
class CompareCommandTest : public testing::Test {
 protected:
  CompareCommandTest() {
    const auto plan =
        fixture_.add_plan("\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b}",
                          "run: {repeats: 9, warmup: 1}\n");
    for (const char* name : {"first", "second"}) test::run_quietly(fixture_, plan, fixture_.folder() / name);
    std::string records;
    double time = 1.0;
    for (const char* name : {"first", "second"}) {
      records.clear();
      for (json& record : read_records(folder(name) + "/records.jsonl")) {
        if (record.at("kernel_s").is_number()) record["kernel_s"] = time += 0.001;
        if (name == std::string("second") && record.at("label") == "b") record["kernel_s"] = 3.0 * time;
        records += record.dump() + "\n";
      }
      fixture_.folder().add(std::string(name) + "/records.jsonl", records);
    }
  }

  std::string folder(const std::string& name) const { return (fixture_.folder() / name).string(); }

  test::ExperimentFixture fixture_;
};

TEST_F(CompareCommandTest, APageOfOneRunAndOfTwo) {
  const ProgramResult one = run_program({"report", folder("first")});
  EXPECT_EQ(one.exit_code, 0) << one.error;
  EXPECT_THAT(one.out, HasSubstr("Page: " + folder("first") + "/report.html"));
  const auto first = read_bytes(folder("first") + "/report.html");
  ASSERT_TRUE(first);
  EXPECT_THAT(*first, HasSubstr("All 18 answers were accepted by the judge."));
  const std::string page = (fixture_.folder() / "both.html").string();
  const ProgramResult both = run_program({"report", folder("first"), folder("second"), "-o", page});
  EXPECT_EQ(both.exit_code, 0) << both.error;
  EXPECT_THAT(both.out, HasSubstr("kernel_s, B over A, 2 pairs"));
  ASSERT_TRUE(read_bytes(page));
  EXPECT_THAT(*read_bytes(page), HasSubstr("most of all kernel_s of cube/b"));
  EXPECT_EQ(read_bytes(folder("first") + "/report.html"), first);
}

TEST_F(CompareCommandTest, AReportWithoutARunOrAPlaceForItIsRefused) {
  const ProgramResult two = run_program({"report", folder("first"), folder("second")});
  EXPECT_EQ(two.exit_code, 2);
  EXPECT_THAT(two.error, HasSubstr("a page of several runs needs a file of its own: -o FILE"));
  const ProgramResult none = run_program({"report", (fixture_.folder() / "none").string()});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_EQ(std::count(none.error.begin(), none.error.end(), '\n'), 1) << none.error;
}

TEST_F(CompareCommandTest, TwoRunsAndTheExitCode) {
  const ProgramResult shown = run_program({"compare", folder("first"), folder("second")});
  EXPECT_EQ(shown.exit_code, 0) << shown.error;
  EXPECT_EQ(shown.error, "");
  EXPECT_THAT(shown.out, HasSubstr("A and B are of one make and one machine"));
  EXPECT_THAT(shown.out, HasSubstr("kernel_s, B over A, 2 pairs, most changed first"));
  const ProgramResult result = run_program(
      {"compare", folder("first"), folder("second"), "--json", "--measure", "kernel_s", "--measure", "tets"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  const json found = json::parse(result.out);
  EXPECT_EQ(found.at("schema"), "palpate/comparison/1");
  ASSERT_EQ(found.at("measures").size(), 2U);
  const json& kernel = found.at("measures")[0];
  EXPECT_EQ(kernel.at("pairs")[0].at("case"), "cube/b");
  EXPECT_EQ(kernel.at("pairs")[0].at("verdict"), "slower");
  EXPECT_EQ(found.at("measures")[1].at("unit"), "1");
  EXPECT_EQ(found.at("measures")[1].at("pairs")[0].at("ratio"), 1.0);
  EXPECT_EQ(run_program({"compare", folder("first"), folder("second"), "--measure", "kernel_s",
                         "--fail-above", "2.5"})
                .exit_code,
            1);
  EXPECT_EQ(run_program({"compare", folder("first"), folder("second"), "--measure", "kernel_s",
                         "--fail-above", "3.5"})
                .exit_code,
            0);
}

TEST_F(CompareCommandTest, WhatCannotBeCompared) {
  const auto refused = [&](const std::vector<std::string>& words, const std::string& part) {
    std::vector<std::string> all{"compare"};
    all.insert(all.end(), words.begin(), words.end());
    const ProgramResult result = run_program(all);
    EXPECT_EQ(result.exit_code, 2) << result.out;
    EXPECT_THAT(result.error, HasSubstr(part));
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
  };
  refused({folder("first"), folder("none")}, "expected the folder of a run");
  refused({folder("first"), folder("second"), "--measure", "kernel"}, "did you mean \"kernel_s\"?");
  refused({folder("first"), folder("second"), "--measure", "quality_histogram"}, "is a list");
  refused({folder("first"), folder("second"), "--fail-above", "0"}, "--fail-above");
  const auto bench = fixture_.folder().add(
      "bench.json",
      R"({"context": {}, "benchmarks": [{"name": "BM", "real_time": 2, "cpu_time": 1, "time_unit": "ns"}]})");
  refused({folder("first"), bench.string()}, "found one of each");
  EXPECT_EQ(run_program({"compare", bench.string(), bench.string()}).exit_code, 0);
  refused({bench.string(), bench.string(), "--fail-above", "2"}, "none of the pairs can be decided");
}

TEST(PlanName, ABareNameIsFoundHereOrAmongThePlans) {
  const ProgramResult result = run_program({"run", "thesis_histograms", "--list-cases"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, HasSubstr("kidney/"));
  const std::string path = source_folder() + "/experiments/plans/thesis_histograms.yaml";
  EXPECT_EQ(run_program({"run", path, "--list-cases"}).out, result.out);
  const ProgramResult near = run_program({"run", "thesis_histogram", "--list-cases"});
  EXPECT_EQ(near.exit_code, 2);
  EXPECT_THAT(near.error, HasSubstr("no plan is called \"thesis_histogram\""));
  EXPECT_THAT(near.error, HasSubstr("did you mean \"thesis_histograms\"?"));
  EXPECT_THAT(run_program({"check", "thesis_histograms.yaml"}).out,
              HasSubstr("thesis_histograms.yaml: good, "));
  const ProgramResult only = run_program({"run", "thesis_histograms", "--list-cases", "--only", "kidny"});
  EXPECT_EQ(only.exit_code, 2);
  EXPECT_THAT(only.error, HasSubstr("did you mean \"kidney\"?"));
  EXPECT_THAT(run_program({"run", "experiments/plans/none.yaml"}).error, HasSubstr("no such file"));
}

TEST(PlanName, AFileInTheCurrentFolderWins) {
  const test::ExperimentFixture fixture;
  fixture.add_plan("[test.copy]", "", "thesis_histograms");
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(fixture.folder().path());
  const ProgramResult result = run_program({"run", "thesis_histograms", "--list-cases"});
  std::filesystem::current_path(before);
  EXPECT_EQ(result.out, "cube/test.copy\n") << result.error;
}

}  // namespace
}  // namespace palpate::experiments

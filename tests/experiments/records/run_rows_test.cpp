// What is kept of a run's records for its gate: enough, in order, and no more.
#include "experiments/records/run_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "experiments/records/set_aside.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

json record_of(const std::string& run_case, int repeat, const std::string& outcome = "accepted") {
  return {{"schema", "palpate/record/1"},
          {"plan", "p"},
          {"case", run_case},
          {"contestant", "test.copy"},
          {"repeat", repeat},
          {"outcome", outcome},
          {"message", "it said so"},
          {"required", false},
          {"warmup", repeat == 0},
          {"searched", repeat == 1},
          {"kernel_s", repeat},
          {"output_hash", "xxh3:" + run_case},
          {"judge", {{"tets", 384}, {"min_quality", nullptr}, {"reference_too_coarse", repeat == 2}}}};
}

/// A run folder with these records, and what its provenance says of its cases.
class RunRowsTest : public testing::Test {
 protected:
  void write_lines(const std::vector<std::string>& lines) const {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    folder_.add("records.jsonl", text);
  }
  void write(const std::vector<json>& records) const {
    std::vector<std::string> lines;
    lines.reserve(records.size());
    for (const json& record : records) lines.push_back(record.dump());
    write_lines(lines);
  }
  RunRows read() const {
    return read_run_rows(folder_.path(), {find_measure("kernel_s"), find_measure("min_quality")});
  }
  std::vector<std::string> order() const {
    std::vector<std::string> names;
    const RunRows rows = read();
    for (const RunRow& row : rows.all()) names.push_back(*row.run_case + std::to_string(row.repeat));
    return names;
  }
  std::string refusal() const {
    try {
      read();
    } catch (const InputError& error) {
      return error.what();
    }
    return "read";
  }

  test::ScratchFolder folder_;
};

TEST_F(RunRowsTest, ARowKeepsWhatAGateAsksFor) {
  write({record_of("a", 1), record_of("a", 2, "crashed"),
         json{{"schema", "palpate/record/1"},
              {"case", "input"},
              {"contestant", nullptr},
              {"repeat", 0},
              {"outcome", "accepted"},
              {"output_hash", nullptr}}});
  const RunRows rows = read();
  ASSERT_EQ(rows.all().size(), 3U);
  const RunRow& first = rows.all()[0];
  EXPECT_EQ(*first.run_case, "a");
  EXPECT_EQ(*first.outcome, "accepted");
  EXPECT_EQ(first.message, nullptr) << "nobody asks why it was accepted";
  EXPECT_EQ(*first.output_hash, "xxh3:a");
  EXPECT_EQ(*first.plan, "p");
  EXPECT_EQ(first.repeat, 1);
  EXPECT_TRUE(first.is_answer && first.has_searched);
  EXPECT_FALSE(first.is_required || first.is_warmup || first.has_coarse_reference);
  EXPECT_EQ(rows.figure(first, *find_measure("kernel_s")), 1.0);
  EXPECT_EQ(rows.figure(first, *find_measure("min_quality")), std::nullopt) << "null is no figure";
  const RunRow& second = rows.all()[1];
  EXPECT_EQ(*second.message, "it said so");
  EXPECT_TRUE(second.has_coarse_reference);
  const RunRow& input = rows.all()[2];
  EXPECT_EQ(input.output_hash, nullptr);
  EXPECT_TRUE(input.plan->is_null() && input.is_required);
  EXPECT_FALSE(input.is_answer || input.is_warmup || input.has_searched);
  EXPECT_THAT(rows.of_case("a"), ElementsAre(&first, &second));
  EXPECT_THAT(rows.of_case("b"), ElementsAre());
}

TEST_F(RunRowsTest, ARowIsSmallWhateverItsRecordHolds) {
  std::vector<json> records;
  for (int repeat = 0; repeat < 10; ++repeat) {
    records.push_back(record_of("a", repeat));
    records.back()["report"] = std::string(100'000, 'x');
  }
  write(records);
  const RunRows rows = read();
  for (const RunRow& row : rows.all()) {
    EXPECT_EQ(row.figures.capacity(), 2U) << "those of the measures that were asked for";
    EXPECT_EQ(row.output_hash, rows.all().front().output_hash) << "equal words lie in one place";
    EXPECT_EQ(row.plan, rows.all().front().plan);
  }
  EXPECT_LE(sizeof(RunRow), 96U) << "10^6 of them have to be held";
  EXPECT_THROW(rows.figure(rows.all().front(), *find_measure("wall_s")), ContractError)
      << "what was not kept is not taken for a missing figure";
}

TEST_F(RunRowsTest, RowsComeRoundByRoundInThePlansOrder) {
  write({record_of("b", 0), record_of("input", 0), record_of("a", 1), record_of("b", 1), record_of("a", 0),
         record_of("stranger", 1), record_of("a", 1)});
  EXPECT_THAT(order(), ElementsAre("b0", "input0", "a1", "b1", "a0", "stranger1", "a1"))
      << "without a list of cases, as they are";
  folder_.add("provenance.json", R"({"cases": ["a", "b"]})");
  EXPECT_THAT(order(), ElementsAre("input0", "stranger1", "a0", "b0", "a1", "a1", "b1"));
  const RunRows rows = read();
  std::vector<std::int64_t> repeats;
  for (const RunRow* row : rows.of_case("a")) repeats.push_back(row->repeat);
  EXPECT_THAT(repeats, ElementsAre(0, 1, 1));
  folder_.add("provenance.json", "{");
  EXPECT_EQ(order().front(), "b0");
}

TEST_F(RunRowsTest, WhatIsNoRecordIsSaidWithItsPlace) {
  const std::string sound = record_of("a", 0).dump();
  const std::string file = (folder_ / "records.jsonl").string();
  EXPECT_EQ(refusal(), file + ": expected the records of a run, found no such file");
  write_lines({sound, "[]", sound});
  EXPECT_EQ(refusal(), file + ":2: expected a record (palpate/record/1), found something else");
  write_lines({sound, std::string(200'000, '[')});
  EXPECT_THAT(refusal(), HasSubstr(file + ":2: expected at most 64 levels"));
  json odd = record_of("a", 0);
  odd["warmup"] = 3;
  write({odd});
  EXPECT_EQ(refusal(), file + ": a: warmup: expected true or false, found number");
  folder_.add("records.jsonl", sound + "\n" + sound.substr(0, 30));
  EXPECT_EQ(read().all().size(), 1U) << "a torn last line is left out";
}

TEST_F(RunRowsTest, ABrokenLineSetsNothingAside) {
  const auto records = folder_ / "records.jsonl";
  const auto aside = folder_ / "retried.jsonl";
  const std::string kept = record_of("a", 0).dump() + "\n";
  const std::string failed = record_of("b", 0, "crashed").dump() + "\n";
  folder_.add("records.jsonl", failed + kept + "broken\n");
  EXPECT_THROW(set_aside(records, aside, is_failure), InputError);
  EXPECT_EQ(test::bytes_of(records), failed + kept + "broken\n");
  EXPECT_EQ(test::bytes_of(aside), "") << "it would be there twice once the line is mended";
  folder_.add("records.jsonl", kept + failed + kept + failed.substr(0, 20));
  EXPECT_EQ(set_aside(records, aside, is_failure), 1U);
  EXPECT_EQ(test::bytes_of(records), kept + kept);
  EXPECT_EQ(test::bytes_of(aside), failed);
  EXPECT_EQ(set_aside(records, aside, is_failure), 0U);
  EXPECT_EQ(folder_.count(), 2U) << "nothing half-written is left";
}

}  // namespace
}  // namespace palpate::experiments

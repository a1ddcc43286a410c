// What is kept of a run's records for its gate: enough, in order, and no more.
#include "experiments/records/run_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "experiments/records/key_forms.h"
#include "experiments/records/provenance.h"
#include "experiments/records/record_file.h"
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
         record_of("stranger", 1), record_of("a", 2)});
  EXPECT_THAT(order(), ElementsAre("b0", "input0", "a1", "b1", "a0", "stranger1", "a2"))
      << "without a list of cases, as they are";
  folder_.add("provenance.json", R"({"cases": ["a", "b"]})");
  EXPECT_THAT(order(), ElementsAre("input0", "stranger1", "a0", "b0", "a1", "b1", "a2"));
  const RunRows rows = read();
  std::vector<std::int64_t> repeats;
  for (const RunRow* row : rows.of_case("a")) repeats.push_back(row->repeat);
  EXPECT_THAT(repeats, ElementsAre(0, 1, 2));
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

TEST_F(RunRowsTest, OddKeysAreSaidWithFileAndLine) {
  const std::string place = (folder_ / "records.jsonl").string() + ":2: ";
  const std::string count = "a whole number from 0 to 1000000000";
  struct Odd {
    const char* key;
    json value;
    std::string said;
  };
  for (const Odd& odd :
       std::vector<Odd>{{"repeat", -1, "repeat: expected " + count + ", found -1"},
                        {"repeat", 1LL << 40, "repeat: expected " + count},
                        {"sitting", "x", "sitting: expected " + count + ", found another string"},
                        {"contestant", 3, "contestant: expected a text or null, found 3"},
                        {"mesh_file", json::array(), "mesh_file: expected a text or null"},
                        {"output_hash", 1, "output_hash: expected a text or null"},
                        {"message", json::object(), "message: expected a text or null"},
                        {"violations", {1, 2}, "violations: expected a list of texts"}}) {
    json record = record_of("a", 1);
    record[odd.key] = odd.value;
    write({record_of("a", 0), record});
    EXPECT_THAT(refusal(), testing::StartsWith(place + odd.said)) << odd.key;
  }
  write({record_of("a", 0), record_of("a", 1)});
  const auto use = [](const json& record) {
    static_cast<void>(record.at("judge").at("tets").get<std::string>());
  };
  try {
    for_each_record(folder_ / "records.jsonl", use);
    FAIL() << "a number was taken for a text";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("records.jsonl:1: expected a record (palpate/record/1), found an odd one"));
  }
}

TEST_F(RunRowsTest, ARepeatThatStandsTwiceIsSaid) {
  write({record_of("a", 0), record_of("b", 0), record_of("a", 1), record_of("b", 0)});
  EXPECT_EQ(refusal(), (folder_ / "records.jsonl").string() +
                           ":4: expected each repeat of a case once, found repeat 0 of b a second time");
}

TEST_F(RunRowsTest, LinesHaveABound) {
  const std::string sound = record_of("a", 0).dump();
  json large = record_of("a", 1);
  large["report"] = std::string(300'000, 'x');
  write({record_of("a", 0), large, record_of("a", 2)});
  EXPECT_EQ(read().all().size(), 3U) << "lines are longer than what is read at once";
  write_lines({sound, std::string(kLongestRecord + 1, ' ')});
  EXPECT_THAT(refusal(),
              HasSubstr("records.jsonl:2: expected a record of at most 67108864 bytes, found more"));
}

TEST_F(RunRowsTest, RecordsThatAreAPipeOrAFolderAreNotWaitedFor) {
  const std::string file = (folder_ / "records.jsonl").string();
  ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
  EXPECT_EQ(refusal(), file + ": expected the records of a run, found a pipe");
  std::filesystem::remove(file);
  std::filesystem::create_directory(file);
  EXPECT_EQ(refusal(), file + ": expected the records of a run, found a folder");
}

TEST_F(RunRowsTest, AnOddProvenanceIsSaidWithItsKey) {
  const auto said = [&](const std::string& text) -> std::string {
    folder_.add("provenance.json", text);
    try {
      read_provenance(folder_ / "provenance.json");
    } catch (const InputError& error) {
      return error.what();
    }
    return "read";
  };
  const std::string file = (folder_ / "provenance.json").string();
  EXPECT_EQ(said("{}"), "read");
  EXPECT_EQ(said("[]"), file + ": expected the provenance of a run, found something else");
  EXPECT_EQ(said(R"({"sittings": {}})"),
            file + ": sittings: expected a list of objects, found another object");
  EXPECT_EQ(said(R"({"sittings": [3]})"),
            file + ": sittings: expected a list of objects, found another array");
  EXPECT_EQ(said(R"({"meshes": [{"name": 3}]})"),
            file + ": meshes: expected a list of objects with names, found another array");
  EXPECT_EQ(said(R"({"cases": 7})"), file + ": cases: expected a list of texts, found 7");
  EXPECT_EQ(said(R"({"repeats": 1e30})"),
            file + ": repeats: expected a whole number from 0 to 1000000000, found 1e+30");
  EXPECT_THAT(said(R"({"repeats_of": {"a": -1}})"), HasSubstr("repeats_of: expected whole numbers"));
  EXPECT_THAT(said(R"({"files": null})"), HasSubstr("files: expected an object, found null"));
  EXPECT_TRUE(known_provenance(folder_.path()).is_null());
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
  const std::string other = record_of("c", 0).dump() + "\n";
  folder_.add("records.jsonl", kept + failed + other + failed.substr(0, 20));
  EXPECT_EQ(set_aside(records, aside, is_failure), 1U);
  EXPECT_EQ(test::bytes_of(records), kept + other);
  EXPECT_EQ(test::bytes_of(aside), failed);
  EXPECT_EQ(set_aside(records, aside, is_failure), 0U);
  EXPECT_EQ(folder_.count(), 2U) << "nothing half-written is left";
}

}  // namespace
}  // namespace palpate::experiments

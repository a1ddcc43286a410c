#include "experiments/gates/gate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "experiments/gates/accept.h"
#include "experiments/records/record_file.h"
#include "tests/support/run_rows_of.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::run_rows_of;
using testing::HasSubstr;

json record(int repeat, const json& value, bool warmup = false, const std::string& outcome = "accepted") {
  return {{"case", "kidney/a"},
          {"repeat", repeat},
          {"warmup", warmup},
          {"outcome", outcome},
          {"kernel_s", value}};
}

const std::vector<json> kRecords{record(0, 100.0, true), record(1, 1.0), record(2, 2.0), record(3, 9.0)};

std::string accepted_text(const json& value, double lower, double upper,
                          const std::string& run_case = "kidney/a", const std::string& measure = "kernel_s",
                          const std::string& unit = "s") {
  return json({{"schema", "palpate/accepted/1"},
               {"plan", "p"},
               {"figures",
                {{{"case", run_case},
                  {"measure", measure},
                  {"value", value},
                  {"lower", lower},
                  {"upper", upper},
                  {"unit", unit}}}}})
      .dump();
}

GateLine gate_of(const std::string& accepted, const std::vector<json>& records) {
  const test::ScratchFolder folder;
  return hold_against(run_rows_of(records), "p", folder.add("p.json", accepted)).lines.at(0);
}

TEST(Gate, MedianAfterWarmUpIsHeld) {
  const GateLine line = gate_of(accepted_text(2.5, 0.5, 0.0), kRecords);
  EXPECT_EQ(line.problem, "");
  EXPECT_DOUBLE_EQ(*line.measured, 2.0);
}

TEST(Gate, EachWayToFail) {
  EXPECT_EQ(gate_of(accepted_text(2.5, 0.25, 9.0), kRecords).problem, "below the lower bound");
  EXPECT_EQ(gate_of(accepted_text(1.5, 9.0, 0.25), kRecords).problem, "above the upper bound");
  EXPECT_EQ(gate_of(accepted_text(nullptr, 1.0, 1.0), kRecords).problem, "no accepted value yet");
  EXPECT_EQ(gate_of(accepted_text(2.0, 1.0, 1.0, "kidney/b"), kRecords).problem, "the run has no such case");
  EXPECT_EQ(gate_of(accepted_text(2.0, 1.0, 1.0, "kidney/a", "wall_s"), kRecords).problem,
            "a repeat has no figure");
  EXPECT_EQ(gate_of(accepted_text(2.0, 1.0, 1.0), {record(0, nullptr)}).problem, "a repeat has no figure");
  EXPECT_EQ(
      gate_of(accepted_text(2.0, 1.0, 1.0), {record(0, 2.0), record(1, 2.0, false, "rejected")}).problem,
      "a repeat is rejected");
}

TEST(Gate, AMarkedErrorIsNeverHeld) {
  const auto judged = [](bool is_coarse) {
    json one = record(0, 2.0);
    one["judge"] = {
        {"displacement_l2", 0.02}, {"displacement_max", 0.03}, {"reference_too_coarse", is_coarse}};
    return std::vector<json>{one};
  };
  for (const char* measure : {"displacement_l2", "displacement_max"}) {
    const std::string accepted = accepted_text(0.025, 0.01, 0.01, "kidney/a", measure, "1");
    EXPECT_EQ(gate_of(accepted, judged(false)).problem, "");
    const GateLine marked = gate_of(accepted, judged(true));
    EXPECT_EQ(marked.problem, "marked: its reference is not five times better");
    EXPECT_FALSE(marked.measured) << "gate --update must not write it either";
  }
  EXPECT_EQ(gate_of(accepted_text(2.0, 1.0, 1.0), judged(true)).problem, "") << "times are no errors";
}

std::string gate_error(const std::string& accepted) {
  try {
    gate_of(accepted, kRecords);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Gate, FilesThatAreNoAcceptedFigures) {
  EXPECT_THAT(gate_error("[]"),
              HasSubstr("expected accepted figures (palpate/accepted/2 or 1), found something else"));
  EXPECT_THAT(gate_error("{"), HasSubstr("p.json: expected JSON"));
  EXPECT_THAT(gate_error(std::string(200'000, '[')), HasSubstr("p.json: expected at most 64 levels"));
  EXPECT_THAT(gate_error(R"({"schema":"palpate/accepted/1","plan":"p","figures":{}})"),
              HasSubstr("a list \"figures\""));
  EXPECT_THAT(gate_error(R"({"schema":"palpate/accepted/1","plan":"p","figures":[],"figurs":[]})"),
              HasSubstr("unknown key \"figurs\"; did you mean \"figures\"?"));
  EXPECT_THAT(gate_error(accepted_text(1.0, -1.0, 1.0)), HasSubstr("figure 1: lower: expected a tolerance"));
  EXPECT_THAT(gate_error(accepted_text("1", 1.0, 1.0)), HasSubstr("figure 1: value"));
  EXPECT_THAT(gate_error(accepted_text(1.0, 1.0, 1.0, "a", "kernel")),
              HasSubstr("did you mean \"kernel_s\"?"));
  EXPECT_THAT(gate_error(accepted_text(1.0, 1.0, 1.0, "a", "tets")),
              HasSubstr("figure 1: unit of tets: expected \"1\", found \"s\""));
  std::string text = accepted_text(1.0, 1.0, 1.0);
  text.replace(text.find("upper"), 5, "uper");
  EXPECT_THAT(gate_error(text), HasSubstr("unknown key \"uper\"; did you mean \"upper\"?"));
  const test::ScratchFolder folder;
  EXPECT_THROW(hold_against(run_rows_of(kRecords), "p", folder / "none.json"), InputError);
  EXPECT_THROW(hold_against(run_rows_of(kRecords), "q", folder.add("p.json", accepted_text(1, 1, 1))),
               InputError);
}

TEST(Gate, UpdateTakesValuesAndKeepsTolerances) {
  const test::ScratchFolder folder;
  const auto file = folder.add("p.json", accepted_text(nullptr, 0.5, 0.25));
  const auto changes = update_accepted(hold_against(run_rows_of(kRecords), "p", file), file);
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].text(), "kidney/a kernel_s: none -> 2 s");
  const GateResult after = hold_against(run_rows_of(kRecords), "p", file);
  EXPECT_TRUE(after.holds());
  EXPECT_DOUBLE_EQ(*after.lines[0].figure.value, 2.0);
  EXPECT_DOUBLE_EQ(after.lines[0].figure.lower, 0.5);
  EXPECT_DOUBLE_EQ(after.lines[0].figure.upper, 0.25);
  EXPECT_TRUE(update_accepted(after, file).empty());
  EXPECT_EQ(json::parse(test::bytes_of(file)).at("schema"), "palpate/accepted/1") << "it stays what it was";
}

TEST(Gate, UpdateShowsTheChangeInPercent) {
  const test::ScratchFolder folder;
  const auto file = folder.add("p.json", accepted_text(1.6, 0.5, 0.25));
  const auto changes = update_accepted(hold_against(run_rows_of(kRecords), "p", file), file);
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].text(), "kidney/a kernel_s: 1.6 -> 2 s (+25%)");
}

TEST(Gate, NothingToCompareFails) {
  const test::ScratchFolder folder;
  const auto empty = folder.add("p.json", R"({"schema":"palpate/accepted/1","plan":"p","figures":[]})");
  const GateResult none = hold_against(run_rows_of(kRecords), "p", empty);
  EXPECT_FALSE(none.holds());
  EXPECT_THAT(none.problems, testing::ElementsAre(HasSubstr("nothing to compare")));
  const auto strange = folder.add("p.json", accepted_text(1.0, 1.0, 1.0, "liver/a"));
  EXPECT_THAT(hold_against(run_rows_of(kRecords), "p", strange).problems,
              testing::ElementsAre("nothing to compare: the run has none of the 1 accepted figures"));
  const auto known = folder.add("p.json", accepted_text(1.0, 1.0, 1.0));
  EXPECT_TRUE(hold_against(run_rows_of(kRecords), "p", known).problems.empty());
}

TEST(Gate, UpdateLeavesFiguresWithoutAMeasuredValue) {
  const test::ScratchFolder folder;
  const auto file = folder.add("p.json", accepted_text(7.0, 0.5, 0.25, "kidney/gone"));
  EXPECT_TRUE(update_accepted(hold_against(run_rows_of(kRecords), "p", file), file).empty());
  EXPECT_DOUBLE_EQ(*hold_against(run_rows_of(kRecords), "p", file).lines[0].figure.value, 7.0);
}

TEST(Gate, MedianOfAnEvenNumber) {
  EXPECT_DOUBLE_EQ(median({4.0, 1.0, 3.0, 2.0}), 2.5);
  EXPECT_THROW(median({}), ContractError);
}

}  // namespace
}  // namespace palpate::experiments

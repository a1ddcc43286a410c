// The kinds of accepted figures beside accuracy: what holds, what fails, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "experiments/gates/accept.h"
#include "experiments/gates/gate.h"
#include "tests/support/run_rows_of.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::run_rows_of;
using testing::HasSubstr;

/// A repeat of a case with a time, a count, a margin and an output.
json repeat_of(const std::string& run_case, double kernel_s, int inverted = 0,
               const std::string& hash = "xxh3:a") {
  return {{"case", run_case},
          {"repeat", 0},
          {"warmup", false},
          {"outcome", "accepted"},
          {"kernel_s", kernel_s},
          {"wall_s", kernel_s},
          {"output_hash", hash},
          {"judge", {{"inverted_tets", inverted}, {"mean_quality", 0.5}, {"measured_over_predicted", 1.02}}}};
}

std::vector<json> repeats(const std::string& run_case, const std::vector<double>& times) {
  std::vector<json> all;
  all.reserve(times.size());
  for (const double time : times) all.push_back(repeat_of(run_case, time));
  return all;
}

std::vector<json> both(std::vector<json> a, const std::vector<json>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

GateResult hold(const json& figure, const std::vector<json>& records) {
  const test::ScratchFolder folder;
  const json file = {{"schema", "palpate/accepted/2"}, {"plan", "p"}, {"figures", {figure}}};
  return hold_against(run_rows_of(records), "p", folder.add("p.json", file.dump()));
}

std::string problem_of(const json& figure, const std::vector<json>& records) {
  return hold(figure, records).lines.at(0).problem;
}

std::string refusal_of(const json& figure) {
  try {
    hold(figure, {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

json with(json figure, const char* key, const json& value) {
  figure[key] = value;
  return figure;
}

const json kInverted{
    {"kind", "validity"}, {"case", "m/a"}, {"measure", "inverted_tets"}, {"value", 0}, {"unit", "1"}};
const json kOutcome{{"kind", "validity"}, {"case", "m/a"}, {"outcome", "accepted"}};
const json kHash{{"kind", "hash"}, {"case", "m/a"}, {"value", "xxh3:a"}};
const json kMargin{{"kind", "stability"}, {"case", "m/a"}, {"measure", "measured_over_predicted"},
                   {"value", 1.1},        {"lower", 0.1},  {"unit", "1"}};
const json kRatio{{"kind", "time_ratio"}, {"case", "m/a"}, {"over", "m/b"}, {"measure", "kernel_s"},
                  {"value", 2.0},         {"lower", 1.25}, {"upper", 1.5}};
const json kLess{{"kind", "comparison"}, {"less", "m/a"}, {"than", "m/b"}, {"measure", "mean_quality"}};

TEST(GateKinds, ValidityIsExactInEachRepeat) {
  EXPECT_EQ(problem_of(kInverted, repeats("m/a", {1, 1})), "");
  EXPECT_EQ(problem_of(kInverted, {repeat_of("m/a", 1, 2), repeat_of("m/a", 1, 2)}),
            "not the accepted value");
  EXPECT_EQ(problem_of(kInverted, {repeat_of("m/a", 1, 0), repeat_of("m/a", 1, 0), repeat_of("m/a", 1, 1)}),
            "its repeats differ")
      << "the median would hold";
  EXPECT_EQ(problem_of(kOutcome, repeats("m/a", {1, 1})), "");
  EXPECT_EQ(problem_of(kOutcome, {repeat_of("m/a", 1), with(repeat_of("m/a", 1), "outcome", "rejected")}),
            "its repeats ended in 2 different ways");
  const std::vector<json> rejected{with(repeat_of("m/a", 1), "outcome", "rejected")};
  EXPECT_EQ(problem_of(kOutcome, rejected), "another outcome");
  EXPECT_EQ(problem_of(with(kOutcome, "outcome", "rejected"), rejected), "")
      << "what is known to fail may be held, too";
}

TEST(GateKinds, AStabilityMarginMayGrowButNotShrink) {
  EXPECT_EQ(problem_of(kMargin, repeats("m/a", {1})), "");
  EXPECT_EQ(problem_of(with(kMargin, "value", 0.5), repeats("m/a", {1})), "") << "more is never worse";
  EXPECT_EQ(problem_of(with(kMargin, "value", 1.2), repeats("m/a", {1})), "below the lower bound");
  EXPECT_EQ(problem_of(with(kMargin, "at_least", 1.0), repeats("m/a", {1})), "");
  EXPECT_EQ(problem_of(with(kMargin, "at_least", 1.05), repeats("m/a", {1})),
            "below the least margin of 1.05");
  EXPECT_THAT(refusal_of(with(kMargin, "measure", "mean_quality")), HasSubstr("no measure of stability"));
}

TEST(GateKinds, AHashIsThatOfAllRepeats) {
  EXPECT_EQ(problem_of(kHash, repeats("m/a", {1, 1})), "");
  EXPECT_EQ(problem_of(with(kHash, "value", "xxh3:b"), repeats("m/a", {1})), "another output");
  const std::vector<json> wavering{with(repeat_of("m/a", 1, 0, "xxh3:b"), "warmup", true),
                                   repeat_of("m/a", 1)};
  EXPECT_EQ(problem_of(kHash, wavering), "its repeats gave 2 different outputs: not deterministic")
      << "warm-ups are repeats of the same request";
  EXPECT_EQ(problem_of(kHash, {with(repeat_of("m/a", 1), "output_hash", nullptr)}),
            "a repeat left no output");
  EXPECT_EQ(problem_of(kHash, repeats("m/b", {1})), "the run has no such case");
}

TEST(GateKinds, AComparisonHoldsWithinTheRun) {
  auto records = both(repeats("m/a", {1}), repeats("m/b", {1}));
  EXPECT_EQ(problem_of(kLess, records), "0.5 is not less than 0.5") << "equal is not less";
  records[1]["judge"]["mean_quality"] = 1.0;
  EXPECT_EQ(problem_of(kLess, records), "");
  EXPECT_DOUBLE_EQ(*hold(kLess, records).lines[0].measured, 2.0);
  EXPECT_EQ(problem_of(with(kLess, "by_factor", 1.9), records), "");
  EXPECT_EQ(problem_of(with(kLess, "by_factor", 2.5), records), "0.5 is not less than 1 / 2.5");
  EXPECT_EQ(problem_of(kLess, {records[0]}), "m/b: the run has no such case");
  EXPECT_THAT(refusal_of(with(kLess, "than", "m/a")), HasSubstr("another case than less"));
  EXPECT_THAT(refusal_of(with(kLess, "measure", "kernel_s")), HasSubstr("accept the kind time_ratio"));
}

TEST(GateKinds, TimesAreHeldAsARatioInsideTheRun) {
  const auto b = repeats("m/b", {1, 1, 1, 1, 1});
  EXPECT_EQ(problem_of(kRatio, both(repeats("m/a", {2, 2, 2, 9, 2}), b)), "");
  EXPECT_EQ(problem_of(kRatio, both(repeats("m/a", {200, 200, 200, 200, 200}),
                                    repeats("m/b", {100, 100, 100, 100, 100}))),
            "")
      << "a machine of a hundredth of the speed";
  EXPECT_EQ(problem_of(kRatio, both(repeats("m/a", {1.59, 1.59, 1.59, 1.59, 1.59}), b)),
            "below the lower bound");
  EXPECT_EQ(problem_of(kRatio, both(repeats("m/a", {1.61, 1.61, 1.61, 1.61, 1.61}), b)), "");
  EXPECT_EQ(problem_of(kRatio, both(repeats("m/a", {3.01, 3.01, 3.01, 3.01, 3.01}), b)),
            "above the upper bound");
  EXPECT_EQ(problem_of(kRatio, both(repeats("m/a", {2, 2, 2, 2}), b)),
            "m/a: 4 repeats, a ratio of times needs at least 5");
  auto searched = both(repeats("m/a", {50, 2, 2, 2, 2}), b);
  searched[0]["searched"] = true;
  EXPECT_EQ(problem_of(kRatio, searched), "") << "a search is outside the kernel";
  EXPECT_EQ(problem_of(with(kRatio, "measure", "wall_s"), searched),
            "m/a: 4 repeats, a ratio of times needs at least 5");
}

TEST(GateKinds, TimesByThemselvesAreRefused) {
  const json time{{"kind", "time"}, {"case", "m/a"}, {"measure", "kernel_s"}, {"value", 1}};
  EXPECT_THAT(refusal_of(time), HasSubstr("no kind \"time\": a time by itself says as much of the machine"));
  const json accuracy{{"kind", "accuracy"}, {"case", "m/a"}, {"measure", "kernel_s"},
                      {"value", 1},         {"lower", 0},    {"upper", 0},
                      {"unit", "s"}};
  EXPECT_THAT(refusal_of(accuracy), HasSubstr("figure 1: kernel_s: a time by itself"));
  EXPECT_THAT(refusal_of(with(kRatio, "measure", "mean_quality")),
              HasSubstr("mean_quality is no time of a clock"));
  EXPECT_THAT(refusal_of(with(kRatio, "lower", 0.8)), HasSubstr("lower: expected a factor of at least 1"));
}

TEST(GateKinds, KindsHaveTheirKeys) {
  EXPECT_THAT(refusal_of(with(kHash, "kind", "hsh")),
              HasSubstr("kind: expected accuracy, validity, stability"));
  EXPECT_THAT(refusal_of(with(kHash, "unit", "1")), HasSubstr("unknown key \"unit\""));
  EXPECT_THAT(refusal_of(with(kMargin, "upper", 1)), HasSubstr("unknown key \"upper\""));
  json nameless = kHash;
  nameless.erase("kind");
  EXPECT_THAT(refusal_of(nameless), HasSubstr("the key \"kind\" is missing"));
  const test::ScratchFolder folder;
  const json old = {{"schema", "palpate/accepted/1"}, {"plan", "p"}, {"figures", {kHash}}};
  EXPECT_THROW(hold_against(run_rows_of({}), "p", folder.add("p.json", old.dump())), InputError);
}

TEST(GateKinds, UpdateTakesValuesOfAllKindsAndKeepsTolerances) {
  auto records = both(repeats("m/a", {3, 3, 3, 3, 3}), repeats("m/b", {1, 1, 1, 1, 1}));
  for (std::size_t i = 5; i < 10; ++i) records[i]["judge"]["mean_quality"] = 0.75;
  const json figures{with(kInverted, "value", 4),      with(kOutcome, "outcome", nullptr),
                     with(kHash, "value", "xxh3:old"), with(kMargin, "at_least", 0.9),
                     with(kRatio, "value", 1.5),       with(kLess, "by_factor", 1.2)};
  const test::ScratchFolder folder;
  const auto file = folder.add(
      "p.json", json{{"schema", "palpate/accepted/2"}, {"plan", "p"}, {"figures", figures}}.dump());
  std::vector<std::string> texts;
  for (const AcceptedChange& change : update_accepted(hold_against(run_rows_of(records), "p", file), file))
    texts.push_back(change.text());
  EXPECT_THAT(texts, testing::ElementsAre(
                         "m/a inverted_tets: 4 -> 0 (-100%)", "m/a outcome: none -> accepted",
                         "m/a hash: xxh3:old -> xxh3:a", "m/a measured_over_predicted: 1.1 -> 1.02 (-7.27%)",
                         "m/a / m/b kernel_s: 1.5 -> 3 (+100%)", "m/a < m/b mean_quality: none -> 1.5"));
  EXPECT_TRUE(hold_against(run_rows_of(records), "p", file).holds());
  const json after = json::parse(test::bytes_of(file)).at("figures");
  EXPECT_EQ(after[3], with(with(kMargin, "at_least", 0.9), "value", 1.02));
  EXPECT_EQ(after[4], with(kRatio, "value", 3.0));
}

TEST(GateKinds, WhatFellShortFarthestComesFirst) {
  const auto accuracy = [](const char* measure, double value, double tolerance) {
    return json{{"kind", "accuracy"}, {"case", "m/a"},      {"measure", measure}, {"value", value},
                {"lower", tolerance}, {"upper", tolerance}, {"unit", "1"}};
  };
  const json figures{accuracy("mean_quality", 0.51, 0.005), accuracy("measured_over_predicted", 2.0, 0.0),
                     accuracy("min_quality", 0.1, 0.0), kInverted};
  const test::ScratchFolder folder;
  const json file = {{"schema", "palpate/accepted/2"}, {"plan", "p"}, {"figures", figures}};
  const GateResult result =
      hold_against(run_rows_of(repeats("m/a", {1})), "p", folder.add("p.json", file.dump()));
  std::vector<std::string> order;
  for (const GateLine* line : result.failures()) order.push_back(line->figure.measure);
  EXPECT_THAT(order, testing::ElementsAre("min_quality", "measured_over_predicted", "mean_quality"));
  EXPECT_EQ(result.failures()[2]->by, "0.005 (0.98%), 1 times the tolerance");
  EXPECT_EQ(result.failures()[1]->by, "0.98 (49%)");
}

}  // namespace
}  // namespace palpate::experiments

// What a gate says, read by others: JUnit by Python's own XML reader, Markdown by its rows.
#include "experiments/gates/gate_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <sstream>

#include "experiments/processes/process.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// All that XML and Markdown are hard on, in names and messages.
const std::string kHard = "a<b>&\"c' ]]> | `x` \x01\x1b \xff\xc3 \xef\xbf\xbf \xc3\xa4\nnext\ttab";

GateResult hard_result() {
  GateResult result;
  result.plan = "plan " + kHard;
  GateLine good;
  good.figure.run_case = "m/good";
  good.figure.measure = "tets";
  good.figure.value = 3.0;
  good.measured = 3.0;
  GateLine bad = good;
  bad.figure.run_case = "m/" + kHard;
  bad.problem = "above " + kHard;
  bad.by = "2 (50%)";
  bad.shortfall = 0.5;
  GateLine missing = bad;
  missing.figure.run_case = "m/missing";
  missing.measured.reset();
  missing.shortfall = std::numeric_limits<double>::infinity();
  result.lines = {good, bad, missing};
  result.problems = {"problem " + kHard};
  return result;
}

/// What Python's reader makes of JUnit XML, as JSON.
json read_junit(const std::string& xml) {
  const test::ScratchFolder folder;
  const auto script =
      folder.add("read.py",
                 "import json, sys, xml.etree.ElementTree as tree\nroot = tree.parse(sys.argv[1]).getroot()\n"
                 "suite, = root\njson.dump({'root': root.attrib, 'suite': suite.attrib, 'cases': "
                 "[{**case.attrib, 'failure': "
                 "[f.attrib['message'] for f in case], 'text': [f.text for f in case]} for case in suite]}, "
                 "sys.stdout)\n");
  ProcessSpec spec;
  spec.arguments = {"/usr/bin/python3", "-B", script.string(), folder.add("junit.xml", xml).string()};
  spec.standard_output = folder / "out";
  spec.standard_error = folder / "error";
  const ProcessResult result = run_process(spec);
  if (result.exit_code != 0) return "refused: " + test::bytes_of(folder / "error");
  return json::parse(test::bytes_of(folder / "out"));
}

TEST(GateReport, JUnitIsWellFormedWhateverItHolds) {
  const json read = read_junit(gate_junit(hard_result()));
  ASSERT_TRUE(read.is_object()) << read;
  EXPECT_EQ(read.at("root").at("tests"), "4");
  EXPECT_EQ(read.at("suite").at("failures"), "3");
  ASSERT_EQ(read.at("cases").size(), 4U);
  const std::string clean = "a<b>&\"c' ]]> | `x` ?? \xef\xbf\xbd\xef\xbf\xbd ? \xc3\xa4\nnext\ttab";
  EXPECT_EQ(read.at("cases")[0].at("failure")[0], "problem " + clean);
  EXPECT_EQ(read.at("cases")[1].at("failure"), json::array());
  EXPECT_EQ(read.at("cases")[2].at("name"), "m/" + clean + " tets");
  EXPECT_EQ(read.at("cases")[2].at("failure")[0], "above " + clean + " by 2 (50%)");
  EXPECT_EQ(read.at("cases")[2].at("text")[0], "accepted 3, measured 3, tolerance -0 +0");
  EXPECT_THAT(read_junit("<a>" + kHard + "</a>").dump(), HasSubstr("refused"))
      << "the reader refuses what is not escaped";
}

TEST(GateReport, MarkdownKeepsItsTables) {
  const std::string text = gate_markdown(hard_result(), {{"m/a tets", "3", "4", "+33.3%"}});
  std::size_t rows = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| m/", 0) != 0) continue;
    ++rows;
    std::size_t cells = 0;
    for (std::size_t i = 1; i < line.size(); ++i) cells += line[i] == '|' && line[i - 1] != '\\' ? 1 : 0;
    EXPECT_EQ(cells, line.rfind("| m/a tets", 0) == 0 ? 4U : 7U) << line;
  }
  EXPECT_EQ(rows, 3U);
  EXPECT_THAT(text, HasSubstr("1 of 3 figures hold: 1 of 3 of accuracy."));
  EXPECT_LT(text.find("m/missing"), text.find("m/a\\<b")) << "what cannot be told comes first";
}

TEST(GateReport, JsonHoldsEachFigureAndNoInfinity) {
  const json described = describe_gate(hard_result(), {});
  EXPECT_EQ(described.at("holds"), false);
  EXPECT_EQ(described.at("figures").size(), 3U);
  EXPECT_EQ(described.at("figures")[1].at("shortfall"), 0.5);
  EXPECT_TRUE(described.at("figures")[2].at("shortfall").is_null());
  EXPECT_TRUE(described.at("figures")[2].at("measured").is_null());
}

TEST(GateReport, TextNamesFailuresAloneUnlessAllIsAsked) {
  GateResult result = hard_result();
  EXPECT_EQ(gate_text(result, false).find("m/good"), std::string::npos);
  EXPECT_THAT(gate_text(result, true), HasSubstr("m/good tets"));
  result.lines.resize(1);
  result.problems.clear();
  EXPECT_EQ(gate_text(result, false), "holds: 1 of 1 figures hold: 1 of accuracy\n");
}

}  // namespace
}  // namespace palpate::experiments

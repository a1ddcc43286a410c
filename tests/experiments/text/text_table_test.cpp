#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>

#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

using testing::HasSubstr;

/// The environment's COLUMNS as it was, put back at the end.
class Columns {
 public:
  explicit Columns(const char* value) {
    const char* old = std::getenv("COLUMNS");
    was_ = old == nullptr ? "" : old;
    had_ = old != nullptr;
    ::setenv("COLUMNS", value, 1);
  }
  ~Columns() {
    if (had_) ::setenv("COLUMNS", was_.c_str(), 1);
    if (!had_) ::unsetenv("COLUMNS");
  }
  Columns(const Columns&) = delete;
  Columns& operator=(const Columns&) = delete;

 private:
  std::string was_;
  bool had_ = false;
};

std::size_t columns_with(const char* value) {
  const Columns set(value);
  return output_columns();
}

std::size_t widest(const std::string& text) {
  std::size_t most = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) most = std::max(most, display_width(line));
  return most;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size()))
    ++found;
  return found;
}

TextTable table_of_figures(const std::string& name) {
  TextTable table({"kind", "figure", "accepted", "measured", "tolerance", "unit", ""}, "llrrrll");
  table.add(
      {"accuracy", name, "850", "902", "-0 +0", "%", "FAILS: above the upper bound by 52 (6.12%) of it"});
  table.add({"validity", name + "s", "1", "2", "-1 +1", "", "holds"});
  return table;
}

TEST(TextTable, OneThatFitsIsAligned) {
  TextTable table({"name", "value"}, "lr");
  table.add({"a", "1"});
  table.add({"long", "10000"});
  EXPECT_EQ(table.text(80), "name  value\na         1\nlong  10000\n");
}

TEST(TextTable, ALastColumnOfWordsIsWrapped) {
  TextTable table({"measure", "summary"}, "ll");
  table.add({"mean_quality", "mean over the tetrahedra of the quality that the thesis gives them"});
  EXPECT_EQ(table.text(44),
            "measure       summary\n"
            "mean_quality  mean over the tetrahedra of\n"
            "              the quality that the thesis\n"
            "              gives them\n");
}

TEST(TextTable, BlocksRepeatTheNames) {
  TextTable table({"model", "rms %", "worst %", "iterations"}, "lrrr");
  table.add({"springs", "3.21", "10.5", "120"});
  table.add({"smoothed", "1.5", "2.25", "7"});
  EXPECT_EQ(table.text(28),
            "model     rms %  worst %\n"
            "springs    3.21     10.5\n"
            "smoothed    1.5     2.25\n"
            "\n"
            "model     iterations\n"
            "springs          120\n"
            "smoothed           7\n");
}

TEST(TextTable, LongNamesMakeRecords) {
  const std::string name = "a_mesh_of_a_long_name/hierarchical/tets_removed_ratio=0.22 percent_above_0_5";
  const std::string text = table_of_figures(name).text(80);
  EXPECT_THAT(text,
              HasSubstr("accuracy  " + name + "\n    accepted 850  measured 902  tolerance -0 +0  unit %\n"));
  EXPECT_THAT(text, HasSubstr("\n    FAILS: above the upper bound by 52 (6.12%) of it\n"));
  EXPECT_EQ(count(text, name), 2U);
}

TEST(TextTable, NothingIsLostAtAnyWidth) {
  for (std::size_t most = 40; most <= 160; most += 3) {
    const std::string text = table_of_figures("cube/mine tets_out").text(most);
    for (const char* part : {"accuracy", "850", "902", "-0 +0", "FAILS:", "above", "bound", "52", "(6.12%)",
                             "of", "it", "validity", "-1 +1", "holds"})
      EXPECT_GE(count(text, part), 1U) << part << " at " << most;
    EXPECT_LE(widest(text), most);
  }
}

TEST(TextTable, WidthsCountWhatATerminalShows) {
  EXPECT_EQ(display_width("\033[32mholds\033[0m"), 5U);
  EXPECT_EQ(display_width("m\xc3\xa4n"), 3U);
  EXPECT_THAT(wrapped("one two  three", 7), testing::ElementsAre("one two", "three"));
  EXPECT_THAT(wrapped("a_word_that_is_longer", 7), testing::ElementsAre("a_word_that_is_longer"));
  EXPECT_THAT(wrapped("", 7), testing::ElementsAre(""));
}

TEST(TextTable, ColumnsOfTheEnvironmentAreHonoured) {
  EXPECT_EQ(columns_with("132"), 132U);
  EXPECT_EQ(columns_with("3"), 40U);
  for (const char* none : {"", "wide", "0", "-5"}) EXPECT_GE(columns_with(none), 40U) << none;
}

}  // namespace
}  // namespace palpate::experiments

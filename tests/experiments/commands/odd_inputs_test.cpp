// Pipes, folders and devices in the place of files, and names that are no text: one message at once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "core/mesh/io/off.h"
#include "core/mesh/shapes/shapes.h"
#include "core/simplify/sizing/size_file.h"
#include "core/springs/network/moduli_csv.h"
#include "core/springs/network/springs_csv.h"
#include "experiments/files/file_hash.h"
#include "experiments/gates/accepted_figures.h"
#include "experiments/text/yaml_value.h"
#include "reference/door/deform_problem.h"
#include "reference/door/json_file.h"
#include "reference/door/motion_problem.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;

std::string message_of(const std::function<void()>& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

TEST(OddInputs, NoReaderWaitsForAPipeOrTakesADevice) {
  const test::ScratchFolder folder;
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 0);
  for (const auto& each :
       {std::pair{pipe, "found a pipe"}, std::pair{fs::path("/dev/zero"), "found a device"},
        std::pair{folder.path(), "found a folder"}}) {
    const fs::path place = each.first;
    const std::vector<std::function<void()>> readers{[&] { read_yaml(place); },
                                                     [&] { read_off(place); },
                                                     [&] { simplify::read_sizes(place, 8); },
                                                     [&] { springs::read_springs_csv(place, mesh); },
                                                     [&] { springs::read_moduli_csv(place, mesh); },
                                                     [&] { read_accepted(place, "ci"); },
                                                     [&] { hash_file(place); },
                                                     [&] { reference::read_json_file(place); },
                                                     [&] { reference::read_displacement(place, 8, 0); },
                                                     [&] { reference::read_history(place, {}); }};
    for (std::size_t k = 0; k < readers.size(); ++k) {
      const std::string said = message_of(readers[k]);
      EXPECT_THAT(said, testing::StartsWith(place.string() + ": expected")) << k;
      EXPECT_THAT(said, HasSubstr(each.second)) << k;
    }
  }
}

TEST(OddInputs, CommandsSayItInOneLine) {
  const test::ExperimentFixture fixture;
  const std::string pipe = (fixture.folder() / "pipe.yaml").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const std::string plan = fixture.add_plan("[test.copy]").string();
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"check", pipe},
        {"run", pipe},
        {"simulate", pipe, "-o", (fixture.folder() / "out").string()},
        {"run", plan, "--part", pipe, "--out", (fixture.folder() / "run").string()}}) {
    const ProgramResult result = run_program(words);
    EXPECT_EQ(result.exit_code, 2) << words[0];
    EXPECT_THAT(result.error, HasSubstr("found a pipe")) << words[0];
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
  }
}

TEST(OddInputs, ANameThatIsNoTextIsSaid) {
  const test::ExperimentFixture fixture;
  const std::string plan = fixture.add_plan("[test.copy]").string();
  const std::string odd = (fixture.folder() / "\xff\xfe").string();
  for (const std::vector<std::string>& words : {std::vector<std::string>{"check", odd + ".yaml"},
                                                {"quality", odd + ".mesh"},
                                                {"run", plan, "--out", odd},
                                                {odd}}) {
    const ProgramResult result = run_program(words);
    EXPECT_EQ(result.exit_code, 2) << words[0];
    EXPECT_THAT(result.error, HasSubstr("of the command line: expected UTF-8, found \""));
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
  }
  EXPECT_FALSE(fs::exists(odd));
}

/// The report reads a word in quotes as text, so that it must not be a flag or a number here.
TEST(OddInputs, FlagsAndNumbersInQuotesAreText) {
  const YamlValue file = parse_yaml(
      "flag: \"true\"\nnumber: '0.5'\nwhole: \"3\"\nsigns: +-5\nreal: true\nplus: +5\n", "here.yaml");
  const auto value = [&](const std::string& key) {
    return file.fields({"flag", "number", "whole", "signs", "real", "plus"}).need(key);
  };
  EXPECT_THAT(message_of([&] { value("flag").boolean(); }),
              HasSubstr("here.yaml:1: flag: expected true or false, found \"true\", which is text"));
  EXPECT_THAT(message_of([&] { value("number").number(); }),
              HasSubstr("here.yaml:2: number: expected a number"));
  EXPECT_THAT(message_of([&] { value("whole").integer(); }), HasSubstr("expected a whole number"));
  EXPECT_THAT(message_of([&] { value("signs").number(); }), HasSubstr("found \"+-5\""));
  EXPECT_TRUE(value("signs").json().is_string());
  EXPECT_TRUE(value("real").boolean());
  EXPECT_EQ(value("plus").integer(), 5);
  EXPECT_EQ(value("flag").text(), "true");
}

}  // namespace
}  // namespace palpate::experiments

// Pipes, folders and devices in the place of files, and names that are no text: one message at once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/mesh/io/off.h"
#include "core/mesh/shapes/shapes.h"
#include "core/simplify/sizing/size_file.h"
#include "core/springs/network/moduli_csv.h"
#include "core/springs/network/springs_csv.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/places.h"
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
  std::vector<std::string> meshes;
  for (const char* ending : {"mesh", "msh", "vtk"}) {
    meshes.push_back((fixture.folder() / "pipe.").string() + ending);
    ASSERT_EQ(::mkfifo(meshes.back().c_str(), 0600), 0);
  }
  const std::string plan = fixture.add_plan("[test.copy]").string();
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"check", pipe},
        {"run", pipe},
        {"simulate", pipe, "-o", (fixture.folder() / "out").string()},
        {"quality", meshes[0]},
        {"quality", meshes[1]},
        {"quality", meshes[2]},
        {"springs", meshes[0], "-o", (fixture.folder() / "k.csv").string(), "--method", "uniform",
         "--young-pa", "1", "--poisson", "0.25"},
        {"run", plan, "--part", pipe, "--out", (fixture.folder() / "run").string()}}) {
    const ProgramResult result = run_program(words);
    EXPECT_EQ(result.exit_code, 2) << words[0];
    EXPECT_THAT(result.error, HasSubstr("found a pipe")) << words[0];
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
  }
}

/// An output by another name of the input: through a link, as a second name, round about.
TEST(OddInputs, AnOutputIsNeverTheInput) {
  const test::ExperimentFixture fixture;
  const auto path = [&](const std::string& name) { return (fixture.folder() / name).string(); };
  fixture.folder().add("ball.off",
                       "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
  fixture.folder().add(
      "train.yaml", test::bytes_of(fs::path(source_folder()) / "experiments/training/kidney_springs.yaml"));
  fs::create_directory(fixture.folder() / "x");
  const std::vector<std::string> springs{"--method", "uniform", "--young-pa", "1000", "--poisson", "0.25"};
  struct Command {
    std::vector<std::string> words;
    std::string input;
    std::string flag;
    std::string ending;
    std::vector<std::string> more;
  };
  const std::vector<Command> commands{
      {{"simplify"}, "cube.mesh", "-o", "vtu", {"--method", "test.copy"}},
      {{"springs"}, "cube.mesh", "-o", "csv", springs},
      {{"springs", "-o", path("k.csv"), "--density", "1"}, "cube.mesh", "--masses", "csv", springs},
      {{"export"},
       "cube.mesh",
       "-o",
       "json",
       {"--method", "springs.uniform", "--young-pa", "1000", "--poisson", "0.25", "--density", "1000"}},
      {{"export"}, "cube.mesh", "-o", "compliance", {"--method", "reduced.compliance", "--poisson", "0.3"}},
      {{"mesh"}, "ball.off", "-o", "mesh", {}},
      {{"scene", "--force"}, "ball.off", "-o", "yaml", {}},
      {{"train"}, "train.yaml", "-o", "csv", {}},
      {{"live"}, "cube.mesh", "-o", "html", {}}};
  for (const Command& command : commands) {
    SCOPED_TRACE(command.words.front() + " " + command.flag + " " + command.ending);
    const std::string input = path(command.input);
    const std::string kept = test::bytes_of(input);
    const auto refused = [&](const std::string& output) {
      std::vector<std::string> words = command.words;
      words.insert(words.end(), {input, command.flag, output});
      words.insert(words.end(), command.more.begin(), command.more.end());
      const ProgramResult result = run_program(words);
      EXPECT_EQ(result.exit_code, 2) << result.error;
      EXPECT_THAT(result.error,
                  HasSubstr(command.flag + ": expected a file that is not the input, found " + output));
      EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
      EXPECT_EQ(test::bytes_of(input), kept);
    };
    const fs::path alias = path("alias." + command.ending);
    fs::create_symlink(input, alias);
    refused(alias.string());
    fs::remove(alias);
    fs::create_hard_link(input, alias);
    refused(alias.string());
    fs::remove(alias);
  }
  const ProgramResult around =
      run_program({"simplify", path("cube.mesh"), "-o", path("x/../cube.mesh"), "--method", "test.copy"});
  EXPECT_EQ(around.exit_code, 2);
  EXPECT_THAT(around.error, HasSubstr("-o: expected a file that is not the input"));
  std::vector<std::string> words{"springs",  path("cube.mesh"), "-o", path("k.csv"), "--density", "1",
                                 "--masses", path("x/../k.csv")};
  words.insert(words.end(), springs.begin(), springs.end());
  EXPECT_THAT(run_program(words).error, HasSubstr("--masses: the same file as --output"));
  EXPECT_FALSE(fs::exists(path("k.csv")));
}

TEST(OddInputs, AReportIsNoneOfTheFilesItIsMadeFrom) {
  const test::ExperimentFixture fixture;
  fixture.run(fixture.add_plan("[test.copy]"));
  const fs::path records = fixture.folder() / "run/records.jsonl";
  const std::string kept = test::bytes_of(records);
  fs::create_symlink(records, fixture.folder() / "page.html");
  const ProgramResult result = run_program(
      {"report", (fixture.folder() / "run").string(), "-o", (fixture.folder() / "page.html").string()});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("-o: expected a file that is not the input"));
  EXPECT_EQ(test::bytes_of(records), kept);
}

TEST(OddInputs, WholeNumbersAreDecimal) {
  const test::ExperimentFixture fixture;
  const std::string out = (fixture.folder() / "out.mesh").string();
  // 0600 in octal would be 384, whose nearest cube has 343 vertices.
  const ProgramResult made =
      run_program({"make", "cube", "-o", out, "--vertices", "0600", "--seed", "010", "--json"});
  ASSERT_EQ(made.exit_code, 0) << made.error;
  EXPECT_EQ(nlohmann::json::parse(made.out).at("vertices"), 512);
  const std::string bytes = test::bytes_of(out);
  run_program({"make", "cube", "-o", out, "--vertices", "600", "--seed", "10"});
  EXPECT_EQ(test::bytes_of(out), bytes);
  const std::string in = (fixture.folder() / "cube.mesh").string();
  for (const std::vector<std::string>& more : {std::vector<std::string>{"--tets", "0350"},
                                               {"--fusions", "08"},
                                               {"--threads", "09", "--timeout", "010"}}) {
    std::vector<std::string> words{"simplify", in, "-o", out, "--method", "test.copy"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_THAT(run_program(words).error, testing::Not(HasSubstr("Could not convert"))) << more[0];
  }
  for (const char* odd : {"0x10", "1e3", "12.0", "--5", ""}) {
    const ProgramResult refused =
        run_program({"simplify", in, "-o", out, "--method", "test.copy", "--threads", odd});
    EXPECT_EQ(refused.exit_code, 2) << odd;
  }
  EXPECT_THAT(run_program({"simplify", in, "-o", out, "--method", "test.copy", "--threads", "0999999"}).error,
              HasSubstr("expected a whole number from 1 to 1024, found \"0999999\""));
}

/// A file of another version, or of another kind, whatever keys it has.
TEST(OddInputs, AnotherSchemaIsSaidBeforeAnotherKey) {
  const test::ExperimentFixture fixture;
  const std::string out = (fixture.folder() / "out").string();
  const auto error_of = [&](std::vector<std::string> words, const std::string& text) {
    words.insert(words.begin() + 1, fixture.folder().add("odd.yaml", text).string());
    const ProgramResult result = run_program(words);
    EXPECT_EQ(result.exit_code, 2) << result.out;
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
    return result.error;
  };
  for (const char* command : {"run", "check"})
    EXPECT_THAT(error_of({command}, "schema: palpate/plan/2\nqueston: q\ncontestant_folders: {a: b}\n"),
                HasSubstr("odd.yaml:1: schema: expected palpate/plan/1, found \"palpate/plan/2\"\n"));
  EXPECT_THAT(error_of({"simulate", "-o", out}, "bodies: []\nschema: palpate/scene/2\n"),
              HasSubstr("odd.yaml:2: schema: expected palpate/scene/1, found \"palpate/scene/2\"\n"));
  EXPECT_THAT(error_of({"train", "-o", out + ".csv"}, "schema: palpate/training/0\nx: 1\n"),
              HasSubstr("odd.yaml:1: schema: expected palpate/training/1, found"));
  EXPECT_THAT(error_of({"run"}, "schema: palpate/scene/1\nmesh: x\n"),
              HasSubstr("found \"palpate/scene/1\": a scene, which palpate simulate takes\n"));
  EXPECT_THAT(error_of({"train", "-o", out + ".csv"}, "schema: palpate/plan/1\nx: 1\n"),
              HasSubstr("found \"palpate/plan/1\": a plan, which palpate run takes\n"));
  EXPECT_THAT(error_of({"simulate", "-o", out}, "schema: palpate/training/1\n"),
              HasSubstr("which palpate train takes"));
  for (const char* text : {"question: q\n", "mesh: {make: cube}\n"}) {
    EXPECT_THAT(
        error_of({"check"}, text),
        HasSubstr("odd.yaml:1: the key \"schema\" is missing: expected palpate/plan/1 or palpate/scene/1\n"));
    EXPECT_THAT(error_of({"run"}, text),
                HasSubstr("the key \"schema\" is missing: expected schema: palpate/plan/1\n"));
    EXPECT_THAT(error_of({"simulate", "-o", out}, text),
                HasSubstr("the key \"schema\" is missing: expected schema: palpate/scene/1\n"));
  }
}

TEST(OddInputs, ResumeSaysWhereThereIsNothingAndNoOlderPage) {
  const test::ExperimentFixture fixture;
  const std::string plan = fixture.add_plan("[test.copy]").string();
  const std::string folder = (fixture.folder() / "run").string();
  const std::vector<std::string> words{"run", plan, "--out", folder, "--no-report", "--resume"};
  const ProgramResult first = run_program(words);
  EXPECT_EQ(first.exit_code, 0) << first.error;
  EXPECT_THAT(first.error, HasSubstr("run: there is no run yet to go on with: it starts anew"));
  fixture.folder().add("run/report.html", "of before");
  const ProgramResult second = run_program(words);
  EXPECT_EQ(second.exit_code, 0) << second.error;
  EXPECT_THAT(second.error, testing::Not(HasSubstr("no run yet")));
  EXPECT_THAT(second.out, testing::Not(HasSubstr("Page:")));
}

TEST(OddInputs, AFitThatLacksAKeyIsSaidInWords) {
  const test::ScratchFolder folder;
  folder.add("fit.json", "{\"schema\": \"palpate/fit/1\"}");
  const ProgramResult result = run_program({"envelope", folder.path().string()});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("not as palpate fit leaves it: key 'choice' not found"));
  EXPECT_THAT(result.error, testing::Not(HasSubstr("json.exception")));
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

// The real program: exit codes, one message, nothing half-written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/files/places.h"
#include "experiments/processes/process.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/test_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;

/// The program's code, and that it said one line that starts with its name and holds `part`.
void expect_refusal(const ProgramResult& result, int code, const std::string& part) {
  EXPECT_EQ(result.exit_code, code) << result.error;
  EXPECT_THAT(result.error, HasSubstr(part));
  EXPECT_EQ(result.error.rfind("palpate: ", 0), 0U) << result.error;
  EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
  EXPECT_EQ(result.out, "");
}

TEST(CommandLine, HelpAndVersion) {
  const ProgramResult help = run_program({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const char* command : {"run", "check", "fit", "envelope", "gate", "history", "compare", "report",
                              "list", "make", "mesh", "simplify", "quality", "springs", "simulate", "test"}) {
    EXPECT_THAT(help.out, HasSubstr(std::string("\n  ") + command + " "));
    const ProgramResult own = run_program({command, "--help"});
    EXPECT_EQ(own.exit_code, 0) << command;
    EXPECT_THAT(own.out, HasSubstr("Usage: palpate " + std::string(command)));
  }
  const ProgramResult version = run_program({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.out.rfind("palpate ", 0), 0U);
  EXPECT_EQ(help.out.find('\033'), std::string::npos);
}

/// ctest passes over what it does not know and runs everything.
TEST(CommandLine, AnOptionThatCtestDoesNotHaveIsRefused) {
  expect_refusal(run_program({"test", "--list"}), 2, "ctest has no option \"--list\"");
  expect_refusal(run_program({"test", "-N", "--tests-regex=x"}), 2,
                 "ctest has no option \"--tests-regex=x\"");
  const ProgramResult known =
      run_program({"test", "-N", "--no-tests=ignore", "--tests-regex", "^CommandLine.HelpAndVersion$"});
  EXPECT_EQ(known.exit_code, 0) << known.error;
  EXPECT_THAT(known.out, HasSubstr("Total Tests: 1"));
}

/// The launcher prints these files in the program's place, so that help needs no build.
TEST(CommandLine, HelpIsWhatTheLauncherKeeps) {
  const std::filesystem::path folder = std::filesystem::path(source_folder()) / "experiments/commands/help";
  const std::string all = run_program({"--help"}).out;
  std::istringstream lines(all.substr(all.find("Commands:\n")));
  std::vector<std::string> names{"palpate"};
  std::string line;
  std::getline(lines, line);
  for (std::string name; std::getline(lines, line) && std::istringstream(line) >> name;)
    names.push_back(name);
  ASSERT_GT(names.size(), 10U);
  for (const std::string& name : names) {
    std::vector<std::string> words{"--help"};
    if (name != "palpate") words.insert(words.begin(), name);
    std::ostringstream kept;
    kept << std::ifstream(folder / (name + ".txt")).rdbuf();
    EXPECT_EQ(run_program(words).out, kept.str())
        << "palpate " << name << " --help > experiments/commands/help/" << name << ".txt";
  }
}

TEST(CommandLine, UsageErrors) {
  expect_refusal(run_program({}), 2, "a command is missing; known are run, check");
  expect_refusal(run_program({"smiplify"}), 2, "unknown command \"smiplify\"; did you mean \"simplify\"?");
  expect_refusal(run_program({"quality"}), 2, "MESH");
  expect_refusal(run_program({"quality", "a.mesh", "--jsn"}), 2,
                 "quality: unknown option \"--jsn\"; did you mean \"--json\"?");
  expect_refusal(run_program({"quality", "a.mesh", "b.mesh"}), 2, "quality: unexpected argument \"b.mesh\"");
  expect_refusal(run_program({"list"}), 2,
                 "list: a command is missing; known are contestants, meshes, measures");
  expect_refusal(run_program({"list", "contestant"}), 2, "did you mean \"contestants\"?");
  expect_refusal(run_program({"make", "kidny", "-o", "a.mesh"}), 2, "did you mean \"kidney\"?");
  expect_refusal(run_program({"run", "a.yaml", "--threads", "0"}), 2, "--threads");
}

TEST(CommandLine, NumbersOutOfRangeAreRefused) {
  const test::ScratchFolder folder;
  const std::string out = (folder / "a.mesh").string();
  const auto refuse = [&](const std::vector<std::string>& words, const std::string& part) {
    expect_refusal(run_program(words), 2, part);
    EXPECT_EQ(folder.count(), 0U) << part;
  };
  for (const char* value : {"0", "-1", "1e12", "1000000000000", "nan", "3.5", ""}) {
    refuse({"make", "cube", "-o", out, "--vertices", value}, "--vertices: expected a whole number from 4 to");
  }
  for (const char* value : {"0", "-1", "1e12", "1e-12", "nan", "inf", "x"}) {
    refuse({"make", "cube", "-o", out, "--edge-length", value},
           "--edge-length: expected a number from 1e-09 to");
  }
  for (const char* value : {"nan", "-0.1", "0.6"}) {
    refuse({"make", "cube", "-o", out, "--jitter", value}, "--jitter: expected a number from 0 to 0.5");
  }
  refuse({"make", "cube", "-o", out, "--seed", "-1"}, "--seed");
  refuse({"make", "cube", "-o", out, "--vertices", "100", "--edge-length", "1"}, "excludes");
  refuse({"make", "cube", "-o", out, "--edge-length", "1e-9"}, "at least 1/560, found 1e-09");
  refuse({"make", "bar", "-o", out, "--jitter", "0.2"}, "found 0.2");
}

TEST(CommandLine, HelpHoldsNoTypesOfTheParser) {
  for (const char* command : {"run", "gate", "compare", "make", "mesh", "simplify", "quality", "list"}) {
    const std::string help = run_program({command, "--help"}).out;
    for (const char* word : {"TEXT", "UINT", "INT:", "FLOAT", "REQUIRED", "Excludes", "[Option Group",
                             "Subcommand", "SUBCOMMAND"}) {
      EXPECT_EQ(help.find(word), std::string::npos) << command << ": " << word;
    }
  }
}

TEST(CommandLine, AFullStandardOutputIsSaid) {
  const test::ScratchFolder folder;
  experiments::ProcessSpec spec;
  spec.arguments = {experiments::program_folder() + "/palpate", "list", "meshes"};
  spec.standard_output = "/dev/full";
  spec.standard_error = folder / "error";
  EXPECT_EQ(run_process(spec).exit_code, 2);
  EXPECT_THAT(test::bytes_of(folder / "error"), HasSubstr("standard output cannot be written"));
  // A reader that leaves early is no failure.
  spec.arguments = {
      "/bin/bash", "-c",
      "set -o pipefail; " + experiments::program_folder() + "/palpate list contestants | head -n 1"};
  spec.standard_output = folder / "out";
  EXPECT_EQ(run_process(spec).exit_code, 0);
  EXPECT_EQ(test::bytes_of(folder / "error"), "");
}

TEST(CommandLine, QualityOfGoodBrokenAndUnreadableMeshes) {
  const test::ScratchFolder folder;
  TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  write_medit(folder / "good.mesh", mesh);
  const ProgramResult good = run_program({"quality", (folder / "good.mesh").string(), "--json"});
  EXPECT_EQ(good.exit_code, 0) << good.error;
  const json figures = json::parse(good.out);
  EXPECT_EQ(figures.at("vertices"), 27);
  EXPECT_EQ(figures.at("tets"), 48);
  EXPECT_EQ(figures.at("euler"), 1);
  EXPECT_EQ(figures.at("histogram").size(), 10U);
  EXPECT_EQ(run_program({"quality", (folder / "good.mesh").string()}).exit_code, 0);

  for (Tet& tet : mesh.tets) std::swap(tet[0], tet[1]);
  write_medit(folder / "mirrored.mesh", mesh);
  const ProgramResult mirrored = run_program({"quality", (folder / "mirrored.mesh").string(), "--json"});
  EXPECT_EQ(mirrored.exit_code, 0);
  EXPECT_THAT(mirrored.error, HasSubstr("positive orientation restored"));
  std::swap(mesh.tets[0][0], mesh.tets[0][1]);
  std::string text = test::bytes_of(folder / "mirrored.mesh");
  const std::string tets = "Tetrahedra\n48\n";
  std::string first = text.substr(text.find(tets) + tets.size());
  first = first.substr(0, first.find('\n'));
  std::istringstream words(first);
  std::string a;
  std::string b;
  std::string rest;
  words >> a >> b;
  std::getline(words, rest);
  text.replace(text.find(tets) + tets.size(), first.size(), b + " " + a + rest);
  const ProgramResult broken = run_program({"quality", folder.add("broken.mesh", text).string(), "--json"});
  EXPECT_EQ(broken.exit_code, 1);
  EXPECT_EQ(json::parse(broken.out).at("inverted_tets"), 47);

  expect_refusal(run_program({"quality", (folder / "none.mesh").string()}), 2, "none.mesh");
  expect_refusal(run_program({"quality", folder.add("bad.mesh", "rubbish").string()}), 2, "bad.mesh:1");
}

TEST(CommandLine, SimplifyDoesAndRefuses) {
  const test::ExperimentFixture fixture;
  const std::string in = (fixture.folder() / "cube.mesh").string();
  const std::string out = (fixture.folder() / "out.mesh").string();
  const ProgramResult done = run_program({"simplify", in, "-o", out, "--method", "test.copy", "--json"});
  EXPECT_EQ(done.exit_code, 0) << done.error;
  EXPECT_THAT(done.error, HasSubstr("nothing was removed"));
  const json report = json::parse(done.out);
  EXPECT_EQ(report.at("tets_out"), 384);
  EXPECT_EQ(report.at("method"), "test.copy");
  EXPECT_EQ(test::bytes_of(out), test::bytes_of(in));
  std::filesystem::remove(out);

  const auto refused = [&](const std::vector<std::string>& extra, int code, const std::string& part) {
    std::vector<std::string> arguments{"simplify", in, "-o", out};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    expect_refusal(run_program(arguments), code, part);
    EXPECT_FALSE(std::filesystem::exists(out)) << part;
  };
  refused({"--method", "copy"}, 2, "did you mean \"test.copy\"?");
  refused({"--method", "test.copy", "--set", "facto=1"}, 2, "did you mean \"factor\"?");
  refused({"--method", "test.copy", "--set", "factor"}, 2, "key=value");
  refused({"--method", "test.copy", "--set", "factor=2"}, 2, "from 0 to 1");
  refused({"--method", "test.copy", "--ratio", "1"}, 2, "--ratio");
  refused({"--method", "test.copy", "--ratio", "0.1", "--tets", "5"}, 2, "expected one stop, found 2");
  refused({"--method", "test.copy", "--ratio", "nan"}, 2, "--ratio: expected a number from 0 to 0.999999");
  refused({"--method", "test.copy", "--tets", "0"}, 2, "--tets: expected a whole number from 1");
  refused({"--method", "test.copy", "--fusions", "99999999999999999999"}, 2,
          "--fusions: expected a whole number");
  refused({"--method", "test.copy", "--timeout", "nan"}, 2, "--timeout");
  refused({"--method", "test.limit_only", "--tets", "5"}, 2, "only at limit");
  refused({"--method", "test.copy", "--set", "behave=crash"}, 3, "crashed: killed by signal 11");
  refused({"--method", "test.copy", "--set", "behave=hang", "--timeout", "1"}, 3, "timed out after 1 s");
  refused({"--method", "test.copy", "--set", "behave=nan_mesh"}, 3, "cannot be read");
  refused({"--method", "test.copy", "--set", "behave=refuse"}, 2, "not this mesh");
  expect_refusal(run_program({"simplify", in, "-o", out + ".stl", "--method", "test.copy"}), 2,
                 ".mesh or .vtu");
  expect_refusal(run_program({"simplify", in, "-o", "/no/such/folder/a.mesh", "--method", "test.copy"}), 2,
                 "no folder");
  expect_refusal(run_program({"simplify", in + "x", "-o", out, "--method", "test.copy"}), 2, "cube.meshx");
}

TEST(CommandLine, SimplifyJudgesWhatItWrites) {
  const test::ExperimentFixture fixture;
  const std::string in = (fixture.folder() / "cube.mesh").string();
  const std::string out = (fixture.folder() / "out.mesh").string();
  const ProgramResult broken =
      run_program({"simplify", in, "-o", out, "--method", "test.copy", "--set", "behave=invert", "--json"});
  EXPECT_EQ(broken.exit_code, 1) << broken.error;
  EXPECT_THAT(broken.error, HasSubstr("the output is invalid: tetrahedron 1: inverted"));
  EXPECT_EQ(json::parse(broken.out).at("valid"), false);
  EXPECT_EQ(json::parse(broken.out).at("inverted_tets"), 1);
  EXPECT_TRUE(std::filesystem::exists(out)) << "it is written all the same, to be looked at";
  const ProgramResult sound = run_program({"simplify", in, "-o", out, "--method", "test.copy", "--json"});
  EXPECT_EQ(sound.exit_code, 0);
  EXPECT_EQ(json::parse(sound.out).at("valid"), true);
  // Fusions without their checks turn tetrahedra over, and had been handed out without a word.
  const auto larger = fixture.folder() / "larger.mesh";
  write_medit(larger, build_kuhn_cube(9, 0.2, 3));
  const ProgramResult unchecked =
      run_program({"simplify", larger.string(), "-o", out, "--method", "palpate.hierarchical", "--fusions",
                   "60", "--set", "checks=none", "--json"});
  EXPECT_EQ(unchecked.exit_code, 1) << unchecked.error;
  EXPECT_GT(json::parse(unchecked.out).at("inverted_tets"), 0);
}

TEST(CommandLine, SimplifyKeepsRegions) {
  const test::ExperimentFixture fixture;
  const std::string in = (fixture.folder() / "cube.mesh").string();
  const std::string out = (fixture.folder() / "out.mesh").string();
  const auto run = [&](const std::string& method, const std::vector<std::string>& extra) {
    std::vector<std::string> arguments{"simplify", in, "-o", out, "--method", method};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    return run_program(arguments);
  };
  const ProgramResult kept =
      run("palpate.hierarchical", {"--json", "--keep", "half_space 0 0 -1 -0.9", "--keep",
                                   "sphere 0.5 0.5 0.1 1e-3", "--set", "near_size=0.3"});
  EXPECT_EQ(kept.exit_code, 0) << kept.error;
  const json report = json::parse(kept.out);
  EXPECT_EQ(report.at("keep"), json({"half_space 0 0 -1 -0.9", "sphere 0.5 0.5 0.1 1e-3"}));
  EXPECT_GT(report.at("kept_tets"), 96);
  EXPECT_EQ(report.at("kept_tets_changed"), 0);
  EXPECT_THAT(
      run("palpate.hierarchical", {"--keep", "sphere 9 9 9 1"}).error,
      HasSubstr(
          "--keep: expected a region in the mesh's own coordinates that meets it, found \"sphere 9 9 9 1\""));
  const ProgramResult broken =
      run("test.keep", {"--set", "behave=drop_tet", "--keep", "half_space 0 0 -1 -0.9"});
  EXPECT_EQ(broken.exit_code, 1);
  EXPECT_THAT(broken.error, HasSubstr("1 tetrahedra that were to be kept are not in the output"));
  std::filesystem::remove(out);
  for (const auto& [method, region, part] : std::vector<std::array<std::string, 3>>{
           {"test.copy", "sphere 0 0 0 1", "--keep: method test.copy keeps no regions; those that do are"},
           {"tetfusion.sequential", "sphere 0 0 0 1", "keeps no regions"},
           {"test.keep", "spher 0 0 0 1", "unknown region \"spher\"; did you mean \"sphere\"?"},
           {"test.keep", "", "--keep: expected a value, found \"\""},
           {"test.keep", "sphere 0 0 0 1 2", "--keep: expected \"sphere x y z r\", found 5 numbers"},
           {"test.keep", "sphere 0 0 0 nan", "a finite number in \"sphere x y z r\", found \"nan\""},
           {"palpate.hierarchical", "patch 5 5 5 1 0.1", "meets it, found \"patch 5 5 5 1 0.1\""}}) {
    expect_refusal(run(method, {"--keep", region}), 2, part);
    EXPECT_FALSE(std::filesystem::exists(out)) << region;
  }
}

TEST(CommandLine, SimplifyRefusesAnInvalidMesh) {
  const test::ExperimentFixture fixture;
  TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  mesh.tets.push_back(mesh.tets[0]);
  std::string text =
      "MeshVersionFormatted 2\nDimension 3\nVertices\n" + std::to_string(mesh.points.size()) + "\n";
  for (const Vec3& p : mesh.points) {
    text += std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + " 0\n";
  }
  text += "Tetrahedra\n" + std::to_string(mesh.tets.size()) + "\n";
  for (const Tet& tet : mesh.tets) {
    for (const Index v : tet) text += std::to_string(v + 1) + " ";
    text += "0\n";
  }
  const auto in = fixture.folder().add("twice.mesh", text + "End\n");
  const auto out = fixture.folder() / "out.mesh";
  expect_refusal(run_program({"simplify", in.string(), "-o", out.string(), "--method", "test.copy"}), 2,
                 "expected a valid mesh");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(CommandLine, CheckListAndCases) {
  const test::ExperimentFixture fixture;
  const auto good = fixture.add_plan("[{method: test.copy, label: a, seeds: 2}]", "", "good");
  const auto bad = fixture.add_plan("[test.coyp]", "", "bad");
  EXPECT_EQ(run_program({"check", good.string()}).exit_code, 0);
  const ProgramResult both = run_program({"check", bad.string(), good.string()});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_THAT(both.error, HasSubstr("bad.yaml:5: unknown method"));
  EXPECT_THAT(both.out, HasSubstr("good.yaml: good, 2 cases"));
  EXPECT_EQ(run_program({"run", good.string(), "--list-cases"}).out, "cube/a/seed=1\ncube/a/seed=2\n");
  const json listed = json::parse(run_program({"list", "contestants", "--json"}).out);
  EXPECT_TRUE(
      std::any_of(listed.at("contestants").begin(), listed.at("contestants").end(), [](const json& c) {
        return c.at("methods")[0].at("name") == "test.copy" && c.at("available") == true;
      }));
  EXPECT_GT(json::parse(run_program({"list", "measures", "--json"}).out).at("measures").size(), 20U);
  EXPECT_GT(json::parse(run_program({"list", "meshes", "--json"}).out).at("meshes").size(), 0U);
}

TEST(CommandLine, ListContestantsTakesAPartOfAName) {
  const test::ExperimentFixture fixture;
  const auto methods_of = [](const std::string& part) {
    std::vector<std::string> names;
    const json listed = json::parse(run_program({"list", "contestants", part, "--json"}).out);
    for (const json& contestant : listed.at("contestants"))
      for (const json& method : contestant.at("methods")) names.push_back(method.at("name"));
    return names;
  };
  const std::vector<std::string> all = methods_of("");
  ASSERT_THAT(all, testing::IsSupersetOf({"test.copy", "palpate.refined", "springs.van_gelder"}));
  EXPECT_THAT(methods_of("Refined"), testing::Each(testing::HasSubstr("refined")));
  EXPECT_THAT(methods_of("Refined"), testing::Contains("palpate.refined"));
  EXPECT_THAT(methods_of("tetfusion"), testing::ElementsAre("tetfusion.sequential"));
  const std::vector<std::string> simplifiers = methods_of("simplify");  // a contest
  EXPECT_THAT(simplifiers, testing::IsSupersetOf({"test.copy", "palpate.refined"}));
  EXPECT_THAT(simplifiers, testing::Not(testing::Contains("springs.van_gelder")));
  const ProgramResult text = run_program({"list", "contestants", "van_gelder"});
  EXPECT_THAT(text.out, HasSubstr("springs.van_gelder"));
  EXPECT_EQ(text.out.find("palpate.refined"), std::string::npos);
  expect_refusal(
      run_program({"list", "contestants", "no_such_thing"}), 2,
      "expected a part of the name of a contestant, a contest or a method, found \"no_such_thing\"");
  expect_refusal(run_program({"list", "contestants", "palpate.refinde"}), 2,
                 "did you mean \"palpate.refined\"?");
}

TEST(CommandLine, RunAndGateExitCodes) {
  const test::ExperimentFixture fixture;
  const auto run = [&](const std::string& contestants, const std::string& folder) {
    const auto plan = fixture.add_plan(contestants, "run: {timeout_s: 60}\n");
    return run_program({"run", plan.string(), "--out", (fixture.folder() / folder).string(), "--no-report"});
  };
  const ProgramResult good = run("[test.copy]", "good");
  EXPECT_EQ(good.exit_code, 0) << good.error;
  EXPECT_THAT(good.out, HasSubstr("accepted"));
  EXPECT_EQ(run("[{method: test.copy, set: {behave: invert}}]", "rejected").exit_code, 1);
  EXPECT_EQ(run("[{method: test.copy, set: {behave: crash}}]", "crashed").exit_code, 3);
  expect_refusal(run_program({"run", fixture.add_plan("[test.copy]").string(), "--out", "/proc/none/run"}), 2,
                 "a folder that can be written");

  const auto accepted = [&](const char* value) {
    return fixture.folder().add("accepted.json",
                                std::string(R"({"schema":"palpate/accepted/1","plan":"plan","figures":[
      {"case":"cube/test.copy","measure":"tets","value":)") +
                                    value + R"(,"lower":0,"upper":0,"unit":"1"}]})");
  };
  const std::vector<std::string> gate{"gate", (fixture.folder() / "good").string(), "--accepted"};
  const auto run_gate = [&](const char* value, const std::vector<std::string>& extra) {
    std::vector<std::string> arguments = gate;
    arguments.push_back(accepted(value).string());
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    return run_program(arguments);
  };
  EXPECT_EQ(run_gate("384", {}).exit_code, 0);
  EXPECT_EQ(run_gate("383", {"--json"}).exit_code, 1);
  EXPECT_EQ(run_gate("null", {}).exit_code, 1);
  const ProgramResult updated = run_gate("383", {"--update"});
  EXPECT_EQ(updated.exit_code, 0);
  EXPECT_THAT(updated.error, HasSubstr("383 -> 384"));
  expect_refusal(run_program({"gate", (fixture.folder() / "none").string()}), 2, "the folder of a run");
}

TEST(CommandLine, UnavailableContestantStopsBeforeAnythingRuns) {
  const test::ExperimentFixture fixture;
  std::filesystem::create_directory(fixture.folder() / "ghost");
  fixture.folder().add("ghost/contestant.yaml",
                       "schema: palpate/contestant/1\ncontest: simplify\nprogram: ghost_program\n"
                       "packages: [libghost-dev]\nlicence: MIT\n"
                       "methods: [{name: ghost.walk, summary: none, stops: [limit]}]\n");
  const std::string folders = test::test_folder() + "/contestant:" + fixture.folder().path().string();
  ::setenv("PALPATE_CONTESTANTS", folders.c_str(), 1);
  const auto needed = fixture.add_plan("[ghost.walk, test.copy]");
  const auto out = fixture.folder() / "run";
  const ProgramResult stopped = run_program({"run", needed.string(), "--out", out.string(), "--no-report"});
  EXPECT_EQ(stopped.exit_code, 3);
  EXPECT_THAT(stopped.error, HasSubstr("needs libghost-dev"));
  EXPECT_EQ(std::count(stopped.error.begin(), stopped.error.end(), '\n'), 1) << stopped.error;
  EXPECT_FALSE(std::filesystem::exists(out));
  const auto optional = fixture.add_plan("[{method: ghost.walk, required: false}, test.copy]");
  const ProgramResult ran = run_program({"run", optional.string(), "--out", out.string(), "--no-report"});
  EXPECT_EQ(ran.exit_code, 0) << ran.error;
  EXPECT_THAT(test::bytes_of(out / "records.jsonl"), HasSubstr("\"outcome\":\"unavailable\""));
}

}  // namespace
}  // namespace palpate::experiments

// Runs in parts: side by side, taken from other folders, and prepared alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/base/error.h"
#include "experiments/files/places.h"
#include "experiments/gates/gate_run.h"
#include "experiments/plan_reader/case_list.h"
#include "experiments/processes/process.h"
#include "experiments/records/record_file.h"
#include "experiments/rounds/case_groups.h"
#include "experiments/runner/side_by_side.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/quiet_run.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::run_program;
using testing::ElementsAre;
using testing::HasSubstr;

/// Runs of a plan whose contestants are the real ones, since parts are run by the real program.
class PartsRunTest : public testing::Test {
 protected:
  std::string add_plan(const std::string& run, const std::string& measure = "percent_above_0_5") {
    const std::string text =
        "schema: palpate/plan/1\nquestion: Do parts leave what a run leaves?\ncontest: simplify\n"
        "meshes:\n  - {name: one, make: cube, vertices: 512}\n  - {name: two, make: cube, vertices: 343, "
        "seed: "
        "3}\n"
        "contestants:\n  - {method: palpate.hierarchical, label: hierarchical, stop: {ratio: 0.2}}\n"
        "  - {method: tetfusion.sequential, label: random, set: {order: random}, stop: {tets_of: "
        "hierarchical}, seeds: 4}\n"
        "run: {repeats: 2, " +
        run + "}\nmeasure: [" + measure + "]\n";
    return fixture_.folder().add("parts.yaml", text).string();
  }

  std::string folder(const std::string& name) const { return (fixture_.folder() / name).string(); }

  ProgramResult run(const std::string& plan, const std::string& name,
                    const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"run", plan, "--out", folder(name), "--no-report"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }

  /// Records by case and repeat, without what differs from one running of a repeat to the next.
  std::map<std::string, json> records_of(const std::string& name) const {
    std::map<std::string, json> records;
    for (json& record : read_records(folder(name) + "/records.jsonl")) {
      for (const char* key : {"finished_at", "peak_rss_bytes", "position", "sitting"}) record.erase(key);
      const std::string id = record.at("case").get<std::string>() + "#" + record.at("repeat").dump();
      EXPECT_EQ(records.count(id), 0U) << id << " is there twice";
      records[id] = std::move(record);
    }
    return records;
  }

  /// A plan of three scenes that no other test has: what lies in the cache from before would be found as
  /// well.
  std::string add_scenes_plan(const std::string& run) {
    const std::string scene =
        "schema: palpate/scene/1\nmesh: {make: cube, vertices: 64, length_m: 0.1}\n"
        "material: {young_modulus_pa: MODULUS, poisson_ratio: 0.3, density_kg_m3: 1000}\n"
        "clamp: [{half_space: {normal: [0, 0, 1], offset_m: 0}, elastic_pa_per_m: 1.0e+6}]\n"
        "load: [{gravity_m_s2: [0, 0, -9.81]}]\nanalysis: static\n";
    std::string scenes;
    for (const std::string name : {"soft", "firm", "other"}) {
      std::string text = scene;
      const std::string modulus =
          std::to_string(9000 + scenes.size() + run.size()) + "." + std::to_string(::getpid());
      text.replace(text.find("MODULUS"), 7, modulus);
      fixture_.folder().add(name + ".yaml", text);
      scenes += (scenes.empty() ? "{name: " : ", {name: ") + name + ", file: " + name + ".yaml}";
    }
    return fixture_.folder()
        .add("deform.yaml", "schema: palpate/plan/1\nquestion: q\ncontest: deform\nscenes: [" + scenes +
                                "]\nreference: {method: fem.p2, levels: 2}\n"
                                "contestants: [{method: fem.p1, label: p1}]\nrun: {repeats: 1, warmup: 0, " +
                                run + "}\nmeasure: [displacement_l2]\n")
        .string();
  }

  /// The scenes all levels of whose references were in the cache.
  std::set<std::string> scenes_from_cache(const std::string& name) const {
    std::set<std::string> found;
    for (const json& record : read_records(folder(name) + "/records.jsonl")) {
      if (!record.at("contestant").is_null()) continue;
      const json& levels = record.at("judge").at("level_reports");
      if (std::all_of(levels.begin(), levels.end(),
                      [](const json& level) { return level.at("from_cache").get<bool>(); }))
        found.insert(record.at("scene").at("name").get<std::string>());
    }
    return found;
  }

  json provenance_of(const std::string& name) const {
    return json::parse(test::bytes_of(fixture_.folder() / name / "provenance.json"));
  }

  /// Changes what a part's provenance says of where it ran.
  void move_to_node(const std::string& name, const std::string& processor) {
    json provenance = provenance_of(name);
    provenance["processor"] = processor;
    fixture_.folder().add(name + "/provenance.json", provenance.dump());
  }

  test::ExperimentFixture fixture_;
};

TEST_F(PartsRunTest, SideBySideLeavesTheRecordsAndOutputsOfOneAfterTheOther) {
  const std::string plan = add_plan("timed: false");
  ASSERT_EQ(run(plan, "plain").exit_code, 0);
  const ProgramResult beside = run(plan, "beside", {"--jobs", "2"});
  ASSERT_EQ(beside.exit_code, 0) << beside.error;
  EXPECT_EQ(records_of("plain"), records_of("beside"));
  for (const auto& [id, record] : records_of("plain")) {
    const std::string file = record.at("mesh_file").get<std::string>();
    EXPECT_EQ(test::bytes_of(fixture_.folder() / "plain" / file),
              test::bytes_of(fixture_.folder() / "beside" / file));
    EXPECT_TRUE(record.at("kernel_s").is_null());
  }
  EXPECT_EQ(provenance_of("plain").at("cases"), provenance_of("beside").at("cases"));
  EXPECT_FALSE(std::filesystem::exists(folder("beside") + "/.parts"));
  EXPECT_GT(provenance_of("beside").at("sittings").size(), 1U) << "its parts ran by themselves";
}

TEST_F(PartsRunTest, TimedCasesRunAloneAndThatIsSaid) {
  const std::string plan = add_plan("timed: true");
  const ProgramResult result = run(plan, "timed", {"--jobs", "2"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.error, HasSubstr("timed cases run alone"));
  EXPECT_EQ(provenance_of("timed").at("sittings").size(), 1U);
  for (const auto& [id, record] : records_of("timed")) {
    if (!record.at("contestant").is_null()) {
      EXPECT_TRUE(record.at("kernel_s").is_number()) << id;
    }
  }
}

TEST_F(PartsRunTest, PartsAreTakenOnceAndWhatNobodyRanIsRun) {
  const std::string plan = add_plan("timed: false");
  ASSERT_EQ(run(plan, "whole").exit_code, 0);
  const std::string one = fixture_.folder().add("one.txt", "one/hierarchical\none/random/seed=2\n").string();
  const ProgramResult part = run(plan, "parts/one", {"--part", one});
  ASSERT_EQ(part.exit_code, 0) << part.error;
  EXPECT_EQ(records_of("parts/one").size(), 2U * 2U + 2U) << "two cases, two repeats; the inputs";
  const ProgramResult first = run(plan, "gathered", {"--take", folder("parts")});
  ASSERT_EQ(first.exit_code, 0) << first.error;
  EXPECT_EQ(records_of("gathered"), records_of("whole"));
  const json sittings = provenance_of("gathered").at("sittings");
  ASSERT_EQ(sittings.size(), 2U);
  EXPECT_TRUE(sittings[1].contains("node"));
  const ProgramResult again = run(plan, "gathered", {"--resume", "--take", folder("parts/one")});
  EXPECT_EQ(again.exit_code, 0) << again.error;
  EXPECT_EQ(records_of("gathered"), records_of("whole"));
}

TEST_F(PartsRunTest, APartOfAnotherPlanInputOrOutputIsRefused) {
  const std::string plan = add_plan("timed: false");
  ASSERT_EQ(run(plan, "part").exit_code, 0);
  const std::string mesh = "part/meshes/one/random/seed=3.mesh";
  const std::string bytes = test::bytes_of(fixture_.folder() / mesh);
  fixture_.folder().add(mesh, bytes + "\n");
  EXPECT_THAT(run(plan, "a", {"--take", folder("part")}).error, HasSubstr("an output whose hash is"));
  std::filesystem::resize_file(fixture_.folder() / mesh, std::uint64_t{1} << 40U);
  EXPECT_THAT(run(plan, "h", {"--take", folder("part")}).error,
              HasSubstr("an output of at most 4294967296 bytes"));
  fixture_.folder().add(mesh, bytes);
  json provenance = provenance_of("part");
  provenance["meshes"][0]["hash"] = "xxh3:0";
  fixture_.folder().add("part/provenance.json", provenance.dump());
  EXPECT_THAT(run(plan, "b", {"--take", folder("part")}).error, HasSubstr("the mesh one is another"));
  add_plan("timed: false, order_seed: 2");
  const ProgramResult other = run(plan, "c", {"--take", folder("part")});
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.error, HasSubstr("this part cannot be taken; the plan changed"));
  EXPECT_THAT(run(plan, "d", {"--take", folder("nothing")}).error, HasSubstr("expected the folder of a run"));
  EXPECT_FALSE(std::filesystem::exists(folder("d"))) << "nothing was begun";
}

TEST_F(PartsRunTest, AnOutputIsHeldAgainstItsHashWhateverTheOrderOfTheRecords) {
  const std::string plan = add_plan("timed: false");
  ASSERT_EQ(run(plan, "part").exit_code, 0);
  std::string first;
  std::string later;  // repeat 1 before repeat 0, as a repeat that was run anew stands
  for (const json& record : read_records(folder("part") + "/records.jsonl"))
    (record.at("repeat") == 0 ? later : first) += record.dump() + "\n";
  fixture_.folder().add("part/records.jsonl", first + later);
  ASSERT_EQ(run(plan, "sound", {"--take", folder("part")}).exit_code, 0);
  const std::string mesh = "part/meshes/one/random/seed=3.mesh";
  fixture_.folder().add(mesh, test::bytes_of(fixture_.folder() / mesh) + "\n");
  const ProgramResult refused = run(plan, "taken", {"--take", folder("part")});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.error, HasSubstr("an output whose hash is"));
  fixture_.folder().add("part/records.jsonl", first);
  EXPECT_THAT(run(plan, "none", {"--take", folder("part")}).error, HasSubstr("in its repeat 0, found none"));
}

TEST_F(PartsRunTest, WhatWasInterruptedWhileItTookKnowsWhoseTimesAreThere) {
  const std::string plan = add_plan("timed: true");
  ASSERT_EQ(run(plan, "part").exit_code, 0);
  move_to_node("part", "A");
  const json last = read_records(folder("part") + "/records.jsonl").back();
  const std::string mesh = "part/" + last.at("mesh_file").get<std::string>();
  const std::string bytes = test::bytes_of(fixture_.folder() / mesh);
  fixture_.folder().add(mesh, bytes + "\n");  // found when others have been taken already
  EXPECT_EQ(run(plan, "all", {"--take", folder("part")}).exit_code, 2);
  const std::size_t taken = records_of("all").size();
  EXPECT_GT(taken, 2U);
  EXPECT_EQ(provenance_of("all").at("processor"), "A") << "saved before the first record";
  fixture_.folder().add(mesh, bytes);
  const ProgramResult again = run(plan, "all", {"--resume", "--take", folder("part")});
  ASSERT_EQ(again.exit_code, 0) << again.error;
  EXPECT_EQ(records_of("all"), records_of("part")) << "with all of their times";
  ASSERT_EQ(run(plan, "all", {"--resume", "--take", folder("part")}).exit_code, 0);
  const json provenance = provenance_of("all");
  std::size_t of_the_part = 0;
  for (const json& sitting : provenance.at("sittings")) of_the_part += sitting.contains("node") ? 1U : 0U;
  EXPECT_EQ(of_the_part, 1U) << "taken three times, there once";
  for (const json& record : read_records(folder("all") + "/records.jsonl"))
    EXPECT_TRUE(provenance.at("sittings").at(record.at("sitting").get<std::size_t>()).contains("node"));
}

TEST_F(PartsRunTest, WhatIsRunBesideTakenTimesOfAnotherNodeHasNone) {
  const std::string plan = add_plan("timed: true");
  const std::string one = fixture_.folder().add("one.txt", "one/hierarchical\n").string();
  ASSERT_EQ(run(plan, "part", {"--part", one}).exit_code, 0);
  move_to_node("part", "A");
  ASSERT_EQ(run(plan, "all", {"--part", one, "--take", folder("part")}).exit_code, 0);
  const ProgramResult rest = run(plan, "all", {"--resume"});
  ASSERT_EQ(rest.exit_code, 0) << rest.error;
  for (const auto& [id, record] : records_of("all")) {
    if (record.at("contestant").is_null()) continue;
    EXPECT_EQ(record.at("kernel_s").is_number(), record.at("case") == "one/hierarchical") << id;
  }
}

TEST_F(PartsRunTest, APartWhoseProvenanceOrSittingsAreOddIsRefused) {
  const std::string plan = add_plan("timed: false");
  ASSERT_EQ(run(plan, "part").exit_code, 0);
  const json sound = provenance_of("part");
  const auto refusal = [&](const char* key, const json& value) {
    json odd = sound;
    odd[key] = value;
    fixture_.folder().add("part/provenance.json", odd.dump());
    const ProgramResult result = run(plan, "taken", {"--resume", "--take", folder("part")});
    EXPECT_EQ(result.exit_code, 2) << result.error;
    return result.error;
  };
  EXPECT_THAT(refusal("schema", "palpate/provenance/2"), HasSubstr("a provenance (palpate/provenance/1)"));
  EXPECT_THAT(refusal("sittings", 3),
              HasSubstr("provenance.json: sittings: expected a list of objects, found 3"));
  EXPECT_THAT(refusal("meshes", {1}), HasSubstr("provenance.json: meshes: expected a list of objects"));
  EXPECT_THAT(refusal("problems", json::array()), HasSubstr("problems: expected an object"));
  fixture_.folder().add("part/provenance.json", sound.dump());
  std::vector<json> records = read_records(folder("part") + "/records.jsonl");
  records.back()["sitting"] = 7;
  std::string lines;
  for (const json& record : records) lines += record.dump() + "\n";
  fixture_.folder().add("part/records.jsonl", lines);
  const ProgramResult result = run(plan, "taken", {"--resume", "--take", folder("part")});
  EXPECT_THAT(result.error, HasSubstr("expected one of the run's 1 sittings, found 7"));
}

TEST_F(PartsRunTest, OfAPartWithABrokenLineNothingIsTaken) {
  const std::string plan = add_plan("timed: false");
  ASSERT_EQ(run(plan, "part").exit_code, 0);
  const std::string lines = test::bytes_of(fixture_.folder() / "part/records.jsonl");
  fixture_.folder().add("part/records.jsonl", lines + "broken\n");
  const ProgramResult refused = run(plan, "taken", {"--take", folder("part")});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.error, HasSubstr("part/records.jsonl:23: expected JSON"));
  for (const auto& [id, record] : records_of("taken")) EXPECT_TRUE(record.at("contestant").is_null()) << id;
  fixture_.folder().add("part/records.jsonl", lines);
  ASSERT_EQ(run(plan, "taken", {"--resume", "--take", folder("part")}).exit_code, 0);
  EXPECT_EQ(records_of("taken"), records_of("part"));
}

TEST_F(PartsRunTest, TimesOfUnlikeNodesAreNeverTogether) {
  const std::string plan = add_plan("timed: true");
  const std::string one = fixture_.folder().add("one.txt", "one/hierarchical\n").string();
  const std::string two = fixture_.folder().add("two.txt", "two/hierarchical\n").string();
  ASSERT_EQ(run(plan, "parts/1", {"--part", one}).exit_code, 0);
  ASSERT_EQ(run(plan, "parts/2", {"--part", two}).exit_code, 0);
  move_to_node("parts/1", "A");
  move_to_node("parts/2", "B");
  ASSERT_EQ(run(plan, "all", {"--take", folder("parts/1"), "--take", folder("parts/2")}).exit_code, 0);
  EXPECT_EQ(provenance_of("all").at("processor"), "A");
  for (const auto& [id, record] : records_of("all")) {
    if (record.at("contestant").is_null()) continue;
    const bool is_of_the_first = record.at("case") == "one/hierarchical";
    EXPECT_EQ(record.at("kernel_s").is_number(), is_of_the_first) << id;
    EXPECT_EQ(record.at("outcome"), "accepted") << id;
    if (!is_of_the_first) {
      EXPECT_THAT(record.at("null_reasons").at("kernel_s").get<std::string>(),
                  HasSubstr("another kind of node"));
    }
  }
}

TEST_F(PartsRunTest, PreparingMakesInputsAndRunsNothing) {
  const std::string plan = add_plan("timed: false");
  ASSERT_EQ(run(plan, "prepared", {"--prepare"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder("prepared") + "/meshes/two/input.mesh"));
  EXPECT_FALSE(std::filesystem::exists(folder("prepared") + "/records.jsonl"));
}

TEST_F(PartsRunTest, WhatWasPreparedSideBySideIsFoundByTheRun) {
  const std::string plan = add_scenes_plan("timed: true");
  SideBySide setting;
  setting.plan = plan;
  setting.folder = folder("ahead");
  setting.jobs = 2;
  EXPECT_TRUE(prepare_side_by_side({"soft", "firm"}, setting));
  EXPECT_FALSE(std::filesystem::exists(folder("ahead") + "/soft/records.jsonl"));
  ASSERT_EQ(run(plan, "all", {"--jobs", "2"}).exit_code, 0);
  EXPECT_EQ(scenes_from_cache("all"), (std::set<std::string>{"firm", "soft"})) << "a timed run makes its own";
}

TEST_F(PartsRunTest, AnUntimedRunPreparesItsScenesSideBySide) {
  const std::string plan = add_scenes_plan("timed: false");
  ASSERT_EQ(run(plan, "one", {"--jobs", "2", "--only", "soft"}).exit_code, 0);
  EXPECT_EQ(scenes_from_cache("one"), std::set<std::string>{}) << "a choice of cases makes its own";
  const ProgramResult result = run(plan, "all", {"--jobs", "2"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("inputs of 3 scenes, 2 at a time"));
  EXPECT_EQ(scenes_from_cache("all"), (std::set<std::string>{"firm", "other", "soft"}));
  EXPECT_THAT(run(plan, "all", {"--jobs", "2", "--resume"}).error, Not(HasSubstr("at a time")));
}

/// What a thread of ours throws is not the end of the program.
TEST_F(PartsRunTest, WithoutRoomForMoreFilesItEndsInOrder) {
  const std::string plan = add_plan("timed: false");
  for (const int files : {16, 20, 24, 28, 32}) {
    ProcessSpec spec;
    spec.arguments = {"/bin/bash",
                      "-c",
                      "ulimit -n " + std::to_string(files) + " && exec \"$0\" \"$@\"",
                      program_folder() + "/palpate",
                      "run",
                      plan,
                      "--out",
                      folder(std::to_string(files)),
                      "--no-report",
                      "--jobs",
                      "8"};
    spec.standard_output = spec.standard_error = folder("said");
    const ProcessResult result = run_process(spec);
    EXPECT_EQ(result.end, ProcessEnd::kExited) << files << ": " << test::bytes_of(folder("said"));
    EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 3) << files << ": " << result.exit_code;
  }
}

TEST_F(PartsRunTest, BadPartsAndPlansAreNamed) {
  const std::string plan = add_plan("timed: false");
  const std::string wrong = fixture_.folder().add("wrong.txt", "one/hierarchical\none/nobody\n").string();
  const ProgramResult unknown = run(plan, "a", {"--part", wrong});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.error, HasSubstr("wrong.txt:2: expected a case of the plan, found one/nobody"));
  EXPECT_THAT(run(plan, "a", {"--part", folder("none.txt")}).error, HasSubstr("a file of cases, one a line"));
  std::filesystem::resize_file(wrong, std::uint64_t{1} << 40U);  // a line without end
  EXPECT_THAT(run(plan, "a", {"--part", wrong}).error, HasSubstr("wrong.txt:2: expected a case of the plan"));
  std::filesystem::resize_file(fixture_.folder().add("wrong.txt", "one/hierarchical\n"),
                               std::uint64_t{1} << 40U);
  EXPECT_THAT(run(plan, "a", {"--part", wrong}).error,
              HasSubstr("wrong.txt:2: expected a case of the plan, found a longer line"));
  add_plan("timed: false", "kernel_s");
  EXPECT_THAT(run(plan, "a").error, HasSubstr("kernel_s is a time, and the plan says \"timed: false\""));
  add_plan("timed: false, until_width: 0.1, most_repeats: 9");
  EXPECT_THAT(run(plan, "a").error, HasSubstr("\"until_width\" is of times"));
}

Case case_of(const std::string& id, std::size_t subject, std::optional<std::size_t> needs = std::nullopt) {
  Case c;
  c.id = id;
  c.subject = subject;
  c.tets_of = needs;
  return c;
}

TEST(CaseGroups, WhatACaseNeedsAndTimedCasesOfOneSubjectAreTogether) {
  const std::vector<Case> cases{case_of("a", 0), case_of("b", 0, 0), case_of("c", 0),
                                case_of("d", 1), case_of("e", 1, 3), case_of("f", 1)};
  EXPECT_THAT(group_cases(cases, std::vector<bool>(6, false)), ElementsAre(0, 0, 2, 3, 3, 5));
  EXPECT_THAT(group_cases(cases, std::vector<bool>(6, true)), ElementsAre(0, 0, 0, 3, 3, 3));
  EXPECT_THAT(group_cases(cases, {false, true, true, false, false, false}), ElementsAre(0, 0, 0, 3, 3, 5));
}

TEST(SplitCases, EveryDueCaseIsInOnePartBehindWhatItNeeds) {
  std::vector<Case> cases;
  for (std::size_t i = 0; i < 20; ++i)
    cases.push_back(
        case_of(std::to_string(i), 0, i % 4 == 3 ? std::optional<std::size_t>(i - 1) : std::nullopt));
  std::vector<bool> due(20, true);
  due[5] = false;
  const auto parts = split_cases(cases, due, 3);
  ASSERT_EQ(parts.size(), 3U);
  std::multiset<std::string> all;
  for (const auto& part : parts) {
    EXPECT_GE(part.size(), 5U) << "about as many in each";
    all.insert(part.begin(), part.end());
  }
  EXPECT_EQ(all.size(), 19U);
  EXPECT_EQ(std::set<std::string>(all.begin(), all.end()).size(), 19U);
  EXPECT_EQ(all.count("5"), 0U);
  EXPECT_THAT(split_cases(cases, std::vector<bool>(20, false), 3), testing::IsEmpty());
  for (std::size_t i = 3; i < 20; i += 4) {
    for (const auto& part : parts) {
      EXPECT_EQ(std::count(part.begin(), part.end(), std::to_string(i)),
                std::count(part.begin(), part.end(), std::to_string(i - 1)));
    }
  }
}

}  // namespace
}  // namespace palpate::experiments

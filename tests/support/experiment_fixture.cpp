#include "tests/support/experiment_fixture.h"

#include <cstdlib>

#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/files/places.h"
#include "experiments/processes/process.h"
#include "experiments/records/record_file.h"
#include "experiments/runner/read_plan.h"
#include "experiments/text/terminal.h"
#include "tests/support/test_folder.h"

namespace palpate::test {
namespace {

experiments::Registry load_with_test_contestant() {
  ::setenv("PALPATE_CONTESTANTS", (test_folder() + "/contestant").c_str(), 1);
  return experiments::load_registry();
}

}  // namespace

ExperimentFixture::ExperimentFixture() : registry_(load_with_test_contestant()) {
  write_medit(folder_ / "cube.mesh", build_kuhn_cube(4, 0.2, 3));
}

ExperimentFixture::~ExperimentFixture() {
  ::unsetenv("PALPATE_CONTESTANTS");
}

std::filesystem::path ExperimentFixture::add_plan(const std::string& contestants, const std::string& rest,
                                                  const std::string& name) const {
  return folder_.add(
      name + ".yaml",
      "schema: palpate/plan/1\nquestion: Does it run?\nmeshes: [{name: cube, file: cube.mesh}]\n"
      "contest: simplify\ncontestants: " +
          contestants + "\n" + rest);
}

experiments::RunResult ExperimentFixture::run(const std::filesystem::path& plan, bool resume,
                                              const std::string& case_id) const {
  experiments::RunOptions options;
  options.folder = folder_ / "run";
  options.resume = resume;
  options.case_id = case_id;
  experiments::Progress progress(true);
  return experiments::run_plan(experiments::read_plan(plan, registry_), registry_, options, progress);
}

std::map<std::string, nlohmann::json> ExperimentFixture::records() const {
  std::map<std::string, nlohmann::json> all;
  for (const nlohmann::json& record : experiments::read_records(folder_ / "run" / "records.jsonl"))
    all[record.at("case").get<std::string>()] = record;
  return all;
}

std::string ExperimentFixture::error_of_plan(const std::filesystem::path& plan) const {
  try {
    experiments::read_plan(plan, registry_);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

ProgramResult run_program(const std::vector<std::string>& arguments) {
  const ScratchFolder folder;
  experiments::ProcessSpec spec;
  spec.arguments = {experiments::program_folder() + "/palpate"};
  spec.arguments.insert(spec.arguments.end(), arguments.begin(), arguments.end());
  spec.standard_output = folder / "out";
  spec.standard_error = folder / "error";
  const auto result = experiments::run_process(spec);
  return {result.exit_code, bytes_of(folder / "out"), bytes_of(folder / "error")};
}

}  // namespace palpate::test

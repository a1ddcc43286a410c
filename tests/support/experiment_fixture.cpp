#include "tests/support/experiment_fixture.h"

#include <cstdlib>

#include "core/mesh/medit.h"
#include "core/mesh/shapes.h"
#include "experiments/process.h"

namespace palpate::test {
namespace {

experiments::Registry load_with_test_contestant() {
  ::setenv("PALPATE_CONTESTANTS", PALPATE_TEST_DIR "/contestant", 1);
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

ProgramResult run_program(const std::vector<std::string>& arguments) {
  const ScratchFolder folder;
  experiments::ProcessSpec spec;
  spec.arguments = {PALPATE_BIN_DIR "/palpate"};
  spec.arguments.insert(spec.arguments.end(), arguments.begin(), arguments.end());
  spec.standard_output = folder / "out";
  spec.standard_error = folder / "error";
  const auto result = experiments::run_process(spec);
  return {result.exit_code, bytes_of(folder / "out"), bytes_of(folder / "error")};
}

}  // namespace palpate::test

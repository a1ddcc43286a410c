// What the tests of the runner and the command line share: a mesh, plans, the test contestant, the program.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/registry/registry.h"
#include "experiments/runner/runner.h"
#include "tests/support/scratch_folder.h"

namespace palpate::test {

/// A scratch folder with a small mesh "cube.mesh", and the test contestant in reach of load_registry() and of
/// the program as long as it lives.
class ExperimentFixture {
 public:
  ExperimentFixture();
  ~ExperimentFixture();
  ExperimentFixture(const ExperimentFixture&) = delete;
  ExperimentFixture& operator=(const ExperimentFixture&) = delete;

  const ScratchFolder& folder() const { return folder_; }
  const experiments::Registry& registry() const { return registry_; }

  /// Writes a plan "NAME.yaml" over the mesh: `contestants` is the YAML of that list, `rest` further keys.
  std::filesystem::path add_plan(const std::string& contestants, const std::string& rest = "",
                                 const std::string& name = "plan") const;

  /// Runs a plan into the folder "run"; `case_id` empty: all of it.
  experiments::RunResult run(const std::filesystem::path& plan, bool resume = false,
                             const std::string& case_id = "") const;
  /// The last record of each case of that run.
  std::map<std::string, nlohmann::json> records() const;
  /// What read_plan says of a plan; "no error" if nothing.
  std::string error_of_plan(const std::filesystem::path& plan) const;

 private:
  ScratchFolder folder_;
  experiments::Registry registry_;
};

/// What the program printed, and its exit code.
struct ProgramResult {
  int exit_code = -1;
  std::string out;
  std::string error;
};

/// Runs build/.../bin/palpate with these arguments.
ProgramResult run_program(const std::vector<std::string>& arguments);

}  // namespace palpate::test

#include "tests/support/quiet_run.h"

#include <utility>

#include "core/base/error.h"
#include "experiments/records/record_file.h"
#include "experiments/runner/read_plan.h"

namespace palpate::test {

experiments::RunResult run_quietly(const ExperimentFixture& fixture, const std::filesystem::path& file,
                                   const std::filesystem::path& folder, bool resume,
                                   const std::string& case_id) {
  const experiments::Plan plan = experiments::read_plan(file, fixture.registry());
  experiments::RunOptions options;
  options.folder = folder;
  options.resume = resume;
  options.case_id = case_id;
  experiments::Progress progress(true);
  return run_plan(plan, fixture.registry(), options, progress);
}

std::map<std::string, std::vector<nlohmann::json>> records_by_case(const std::filesystem::path& folder) {
  std::map<std::string, std::vector<nlohmann::json>> all;
  for (nlohmann::json& record : experiments::read_records(folder / "records.jsonl")) {
    all[record.at("case").get<std::string>()].push_back(std::move(record));
  }
  return all;
}

std::string run_error(const ExperimentFixture& fixture, const std::filesystem::path& plan,
                      const std::filesystem::path& folder, bool resume) {
  try {
    run_quietly(fixture, plan, folder, resume);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace palpate::test

#include "experiments/runner/repeat_run.h"

#include <filesystem>
#include <system_error>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/plain_file.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/processes/machine_load.h"
#include "experiments/records/case_record.h"
#include "experiments/records/untimed.h"
#include "experiments/registry/contestant.h"
#include "experiments/registry/option_spec.h"
#include "experiments/runner/repeat_end.h"
#include "reference/door/contest_files.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

void keep_output(const RepeatSetting& setting, const RepeatTask& task, const fs::path& output, json& record) {
  const fs::path kept = setting.contest.kept_output(task.run_case);
  if (task.repeat == 0 && record.at("output_hash").is_string()) {
    std::error_code error;
    fs::create_directories(kept.parent_path(), error);
    fs::rename(output, kept, error);
    if (error) throw InputError(kept.string(), 0, "a file that can be written", error.message());
    keep_beside(output, kept, reference::contest_files(setting.plan.contest).beside_file);
    sync_to_disk(kept);  // before the record that names it
  }
  record["mesh_file"] =
      fs::exists(kept) ? json(kept.lexically_relative(setting.folder.paths().folder).string()) : json();
}

}  // namespace

std::optional<json> run_repeat(const RepeatSetting& setting, RepeatTask task) {
  const Plan& plan = setting.plan;
  const Case& c = task.run_case;
  const PlanContestant& contestant = plan.contestants[c.contestant];
  const MethodEntry method = *setting.registry.find(contestant.method);
  ContestantTask request;
  ContestantAnswer answer;
  MachineLoad load;
  answer.outcome = "error";
  answer.message = std::move(task.not_run);
  if (answer.message.empty()) {
    request.options = c.options;
    answer.message = setting.contest.fill_task(c, request);
  }
  if (answer.message.empty()) {
    request.method = method;
    request.scratch = fs::absolute(setting.folder.fresh_scratch());
    request.stop = *task.stop;
    request.keep = contestant.keep;
    request.tuned = task.state.tuned;
    request.threads = setting.threads;
    request.timeout_s = plan.run.timeout_s;
    request.memory_mib = plan.run.memory_mib;
    request.stop_flag = setting.stop_flag;
    const LoadMeter meter;
    answer = run_contestant(request);
    load = meter.read();
  }
  if (answer.outcome == "interrupted") return std::nullopt;
  RepeatFacts facts{
      plan, c, contestant, task.stop.value_or(c.stop), task.repeat, task.repeat < plan.run.warmup};
  facts.deterministic =
      method.method->deterministic && count_ranks(method.method->options, request.options) == 1;
  facts.judge_bounds = judge_bounds(plan, setting.stop_flag);
  json record = setting.contest.build_record(facts, answer, task.state.earlier_answers());
  if (record.at("outcome") == "interrupted") return std::nullopt;
  throw_if_no_room(request.scratch, record);
  add_load(load, answer, record);
  add_file_hashes(*method.method, c, record);
  if (answer.stopped_s > 0.0)
    drop_times(record, "the run was stopped for " + short_number(answer.stopped_s) + " s meanwhile");
  keep_output(setting, task, answer.output, record);
  return record;
}

}  // namespace palpate::experiments

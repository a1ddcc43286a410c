#include "experiments/runner/side_by_side.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "core/base/atomic_file.h"
#include "experiments/files/output_file.h"
#include "experiments/files/places.h"
#include "experiments/processes/process.h"
#include "experiments/processes/report_script.h"
#include "experiments/rounds/case_groups.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

constexpr double kNoTimeOut = 1e9;
constexpr double kGraceSeconds = 30.0;  // for a part to end its record

/// Parts that have ended, handed from the threads that wait for them to the one that takes them.
class Ended {
 public:
  void add(fs::path part) {
    const std::lock_guard lock(mutex_);
    parts_.push_back(std::move(part));
    changed_.notify_one();
  }
  fs::path next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !parts_.empty(); });
    fs::path part = std::move(parts_.front());
    parts_.pop_front();
    return part;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<fs::path> parts_;
};

/// Runs one part to its end, or says on standard error what kept it from it.
void run_part(const SideBySide& setting, const fs::path& part) {
  fs::path cases = part;
  cases += ".txt";
  fs::path errors = part;
  errors += ".log";
  ProcessSpec spec;
  spec.arguments = {program_folder() + "/palpate",
                    "run",
                    setting.plan.string(),
                    "--part",
                    cases.string(),
                    "--out",
                    part.string(),
                    "--resume",
                    "--threads",
                    std::to_string(setting.threads)};
  spec.timeout_s = kNoTimeOut;
  spec.standard_error = errors;
  spec.threads = setting.threads;
  spec.stop_flag = setting.stop_flag;
  spec.stop_grace_s = kGraceSeconds;
  const ProcessResult result = run_process(spec);
  const bool is_done = result.end == ProcessEnd::kExited && result.exit_code == 0;
  const bool is_stopped = setting.stop_flag != nullptr && *setting.stop_flag != 0;
  if (!is_done && !is_stopped)
    print_note("a part of the run ended early (" + result.message + "): " + last_line(errors));
}

}  // namespace

std::vector<std::vector<std::string>> split_cases(const std::vector<Case>& cases,
                                                  const std::vector<bool>& due, std::size_t most) {
  const std::vector<std::size_t> group = group_cases(cases, std::vector<bool>(cases.size(), false));
  std::vector<bool> is_wanted(cases.size(), false);  // by group
  std::vector<std::size_t> size(cases.size(), 0);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (due[i]) is_wanted[group[i]] = true;
    if (due[i]) ++size[group[i]];
  }
  const auto wanted = static_cast<std::size_t>(std::count(is_wanted.begin(), is_wanted.end(), true));
  std::vector<std::vector<std::string>> parts(std::min(most, wanted));
  std::vector<std::size_t> load(parts.size(), 0);
  std::vector<std::size_t> part_of(cases.size(), 0);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (!is_wanted[group[i]]) continue;
    if (group[i] == i) {
      part_of[i] = static_cast<std::size_t>(std::min_element(load.begin(), load.end()) - load.begin());
      load[part_of[i]] += size[i];
    }
    if (due[i]) parts[part_of[group[i]]].push_back(cases[i].id);
  }
  return parts;
}

bool run_side_by_side(const std::vector<std::vector<std::string>>& parts, const SideBySide& setting,
                      const std::function<void(const fs::path&)>& take) {
  create_folder(setting.folder);
  std::vector<fs::path> folders;
  folders.reserve(parts.size());
  for (std::size_t k = 0; k < parts.size(); ++k) {
    folders.push_back(setting.folder / std::to_string(k));
    std::string lines;
    for (const std::string& id : parts[k]) lines += id + "\n";
    fs::path cases = folders.back();
    write_file_atomically(cases += ".txt", lines);
  }
  std::atomic<std::size_t> next{0};
  Ended ended;
  const auto is_stopped = [&] { return setting.stop_flag != nullptr && *setting.stop_flag != 0; };
  const auto work = [&] {
    for (std::size_t k = next++; k < folders.size(); k = next++) {
      if (!is_stopped()) run_part(setting, folders[k]);
      ended.add(folders[k]);
    }
  };
  std::vector<std::jthread> workers;
  workers.reserve(static_cast<std::size_t>(setting.jobs));
  for (int j = 0; j < setting.jobs; ++j) workers.emplace_back(work);
  try {
    for (std::size_t k = 0; k < folders.size(); ++k) {
      const fs::path part = ended.next();
      if (fs::exists(part / "records.jsonl")) take(part);
    }
  } catch (...) {
    next = folders.size();  // what runs now ends, and is waited for
    throw;
  }
  return !is_stopped();
}

}  // namespace palpate::experiments

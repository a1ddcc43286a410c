#include "experiments/runner/side_by_side.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
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

/// Parts that have ended, handed from the threads that wait for them to the one that takes them; or what kept
/// one of the threads from it.
class Ended {
 public:
  void add(fs::path part) {
    const std::lock_guard lock(mutex_);
    parts_.push_back(std::move(part));
    changed_.notify_one();
  }
  void fail(std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::move(error);
    changed_.notify_one();
  }
  /// Throws: what a thread threw.
  fs::path next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !parts_.empty() || error_; });
    if (error_) std::rethrow_exception(error_);
    fs::path part = std::move(parts_.front());
    parts_.pop_front();
    return part;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<fs::path> parts_;
  std::exception_ptr error_;
};

/// Whether somebody wants it to end.
bool is_stopped(const SideBySide& setting) {
  return setting.stop_flag != nullptr && *setting.stop_flag != 0;
}

fs::path log_of(const fs::path& folder) {
  fs::path log = folder;
  return log += ".log";
}

/// Runs `palpate run` with these words behind the plan, into a folder.
ProcessResult run_program(const SideBySide& setting, const fs::path& folder,
                          const std::vector<std::string>& words) {
  ProcessSpec spec;
  spec.arguments = {
      program_folder() + "/palpate",  "run", setting.plan.string(), "--out", folder.string(), "--threads",
      std::to_string(setting.threads)};
  spec.arguments.insert(spec.arguments.end(), words.begin(), words.end());
  spec.timeout_s = kNoTimeOut;
  spec.standard_error = log_of(folder);
  spec.threads = setting.threads;
  spec.stop_flag = setting.stop_flag;
  spec.stop_grace_s = kGraceSeconds;
  return run_process(spec);
}

/// Runs one part to its end, or says on standard error what kept it from it.
void run_part(const SideBySide& setting, const fs::path& part) {
  fs::path cases = part;
  cases += ".txt";
  const ProcessResult result = run_program(setting, part, {"--part", cases.string(), "--resume"});
  const bool is_done = result.end == ProcessEnd::kExited && result.exit_code == 0;
  if (!is_done && !is_stopped(setting))
    print_note("a part of the run ended early (" + result.message + "): " + last_line(log_of(part)));
}

/// Calls `work` with 0, 1, ..., count - 1, `jobs` of them at a time; with none that has not begun once
/// `next` is set to `count` or somebody wants it to end. The threads end when what is returned does. What
/// `work` throws goes to `fail`, and nothing is begun any more.
std::vector<std::jthread> start_workers(const SideBySide& setting, std::atomic<std::size_t>& next,
                                        std::size_t count, const std::function<void(std::size_t)>& work,
                                        const std::function<void(std::exception_ptr)>& fail) {
  std::vector<std::jthread> workers;
  workers.reserve(static_cast<std::size_t>(setting.jobs));
  const auto run = [&next, count, work, fail] {
    try {
      for (std::size_t k = next++; k < count; k = next++) work(k);
    } catch (...) {
      next = count;
      fail(std::current_exception());
    }
  };
  try {
    for (int j = 0; j < setting.jobs; ++j) workers.emplace_back(run);
  } catch (const std::system_error& error) {
    next = count;
    throw UnavailableError(std::string("cannot start a thread: ") + error.what());
  }
  return workers;
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
  const auto work = [&](std::size_t k) {
    if (!is_stopped(setting)) run_part(setting, folders[k]);
    ended.add(folders[k]);
  };
  const std::vector<std::jthread> workers = start_workers(
      setting, next, folders.size(), work, [&](std::exception_ptr error) { ended.fail(std::move(error)); });
  try {
    for (std::size_t k = 0; k < folders.size(); ++k) {
      const fs::path part = ended.next();
      if (fs::exists(part / "records.jsonl")) take(part);
    }
  } catch (...) {
    next = folders.size();  // what runs now ends, and is waited for
    throw;
  }
  return !is_stopped(setting);
}

bool prepare_side_by_side(const std::vector<std::string>& words, const SideBySide& setting) {
  create_folder(setting.folder);
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr first;
  const auto work = [&](std::size_t k) {
    if (!is_stopped(setting))
      run_program(setting, setting.folder / words[k], {"--prepare", "--only", words[k]});
  };
  const auto fail = [&](std::exception_ptr error) {
    const std::lock_guard lock(mutex);
    if (!first) first = std::move(error);
  };
  start_workers(setting, next, words.size(), work, fail).clear();  // waits for all
  if (first) std::rethrow_exception(first);
  return !is_stopped(setting);
}

}  // namespace palpate::experiments

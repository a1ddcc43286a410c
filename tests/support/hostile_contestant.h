// Contestants that do harm: Python programs in a folder of their own, started as the runner starts any other.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/contestants/contestant_run.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scratch_folder.h"

namespace palpate::test {

/// A contestant "hostile.copy" of the contest simplify with the program `text`. It finds `request` (the
/// request), `response` (the path of its answer) and `answer_well()`, which copies the mesh and answers, and
/// `here` (its own folder). All of its processes have that folder's path in their command line.
class HostileContestant {
 public:
  explicit HostileContestant(const std::string& text);

  /// The folder of the contestant, and of what it writes beside its scratch folder.
  const ScratchFolder& folder() const { return folder_; }

  /// Runs it once by itself.
  experiments::ContestantAnswer answer(double timeout_s = 60.0, std::uint64_t memory_mib = 0) const;
  /// Runs what never answers until it has made this file of its folder: for `timeout_s`, or on a busy machine
  /// for longer.
  experiments::ContestantAnswer answer_with(const std::string& file, double timeout_s = 2.0) const;

  /// A plan over it and the contestant that copies well ("good", before it and after it).
  std::filesystem::path plan(const std::string& run = "{repeats: 1}") const;
  /// Where the plan is run.
  std::filesystem::path out() const { return folder_ / "run"; }
  /// The words after "palpate" that run the plan there.
  std::vector<std::string> run_words(bool resume = false) const;
  /// The records of that run.
  std::vector<nlohmann::json> records() const;

  /// What of its processes is alive now.
  std::vector<pid_t> processes() const;
  /// Whether they all end within half a minute. A signal is sent, not yet delivered, when its sender goes on.
  bool all_end() const;

 private:
  ExperimentFixture fixture_;
  ScratchFolder folder_;
};

/// Processes whose command line has this text; zombies are none.
std::vector<pid_t> processes_with(const std::string& text);

/// A started program, with nobody waiting for it. Killed at the end if it still runs.
class StartedProgram {
 public:
  /// Starts `palpate` with these words; its output goes to a file.
  explicit StartedProgram(const std::vector<std::string>& words);
  ~StartedProgram();
  StartedProgram(const StartedProgram&) = delete;
  StartedProgram& operator=(const StartedProgram&) = delete;

  void signal(int number) const;
  /// Waits for its end. Returns: its exit code, or -N if signal N ended it.
  int wait();
  /// What it wrote to standard error.
  std::string error() const;

 private:
  ScratchFolder folder_;
  pid_t process_ = 0;
};

/// Waits up to half a minute until the file is there; false if it never is.
bool appears(const std::filesystem::path& file);

}  // namespace palpate::test

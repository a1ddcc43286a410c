// One run of a contestant through the door: request, process, answer, checks.
#pragma once

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "experiments/contestants/stop.h"
#include "experiments/registry/contestant.h"

namespace palpate::experiments {

/// Thrown out of longer work of several contestants once the stop flag rose. What was finished is kept where
/// a later start looks for it.
struct RunInterrupted : std::runtime_error {
  RunInterrupted() : std::runtime_error("the run was interrupted") {}
};

/// What to ask of a contestant.
struct ContestantTask {
  MethodEntry method;
  std::filesystem::path mesh_in;
  std::filesystem::path problem_in;  ///< contests deform and motion (reference/PROTOCOL.md)
  std::filesystem::path scratch;     ///< an empty folder of its own; request, answer and output go there
  Stop stop;                         ///< contest simplify alone; resolved: not kTetsOf
  nlohmann::json options;
  nlohmann::json tuned = nlohmann::json::object();  ///< what an earlier repeat's search found; {}: search
  std::vector<std::string> keep;                    ///< regions to keep, as parse_kept_region reads them
  int threads = 1;
  std::filesystem::path folder_out;  ///< for what is written as it comes; mostly none
  double timeout_s = 300.0;
  std::uint64_t memory_mib = 0;                           ///< 0: no bound
  const volatile std::sig_atomic_t* stop_flag = nullptr;  ///< the run is given up when it turns non-zero
  double stop_grace_s = 0.0;                              ///< what it may then take to end by itself
  std::function<void()> while_waiting;                    ///< called some ten times a second; may be empty
};

/// How it went. `outcome` is "ok", or what kept the answer from being judged: "bad_input", "error",
/// "crashed", "timed_out", "out_of_memory", "bad_answer", "unavailable"; "interrupted" if the stop flag rose.
struct ContestantAnswer {
  std::string outcome;
  std::string message;  ///< one line; empty for "ok"
  std::optional<double> kernel_s;
  std::optional<double> wall_s;
  double stopped_s = 0.0;  ///< of wall_s the run itself was stopped: its times say nothing
  std::optional<double> user_s;
  std::optional<std::uint64_t> peak_rss_bytes;
  nlohmann::json report;                            ///< null unless "ok"
  nlohmann::json tuned = nlohmann::json::object();  ///< name -> number, the parameters that a search found
  bool searched = false;  ///< whether this run searched for them: wall_s and memory then hold the search too
  std::vector<std::string> notes;
  std::string standard_error;  ///< the end of what it wrote there, at most 4 KiB of valid UTF-8
  /// Mesh, displacement or history (reference/door/contest_files.h), there only if "ok" and, where the
  /// contest's files ask for one, with the report's outcome that comes with it.
  std::filesystem::path output;
};

/// Runs it to its end, and to that of all that it started. Never throws for what the contestant does;
/// everything that it says is checked: exit code against status, keys and types of the answer, a kernel time
/// above zero and within the process's. The contestant gets a copy of the mesh; one that changes a file that
/// it was given ("bad_answer", which names the file) does not change it for those after it. The message of
/// one that crashed or gave a bad answer ends with the last lines that it wrote to standard error. Answer and
/// output are regular files in its own folder, the output of no more than kLargestFile bytes; no link is
/// followed. Throws: UnavailableError if it failed where the disk may have had no room (room_complaint):
/// nobody is to blame.
ContestantAnswer run_contestant(const ContestantTask& task);

}  // namespace palpate::experiments

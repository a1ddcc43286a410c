#include "experiments/contestants/contestant_run.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string_view>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/contestants/answer_form.h"
#include "experiments/contestants/input_guard.h"
#include "experiments/files/plain_file.h"
#include "experiments/processes/disk_room.h"
#include "experiments/processes/process.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"
#include "reference/door/contest_files.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr std::size_t kKeptError = 4096;  // bytes of standard error that a record holds
constexpr double kClockStepSeconds =
    1e-6;                              // both times come from the steady clock, which counts in nanoseconds
constexpr double kStartSeconds = 0.1;  // starting a process takes no longer
constexpr double kTinyShare = 1e-3;    // of the process's own time: below it a kernel time gets a note

/// The last `bytes` of a file as valid UTF-8, without the rest of a character that was cut; what is no UTF-8
/// becomes U+FFFD. Empty if the file is missing.
std::string read_end(const std::filesystem::path& path, std::size_t bytes) {
  std::error_code error;
  if (!file_complaint(path).empty()) return "";
  std::ifstream file(path, std::ios::binary);
  const std::size_t size = std::filesystem::file_size(path, error);
  if (error) return "";
  const std::size_t start = size > bytes ? size - bytes : 0;
  file.seekg(static_cast<std::streamoff>(start));
  std::string text(size - start, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  const auto is_rest = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; };
  if (start > 0)
    text.erase(0,
               static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_rest) - text.begin()));
  std::string valid =
      json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
  while (valid.size() > bytes) {  // U+FFFD is longer than what it stands for
    valid.erase(0, valid.size() - bytes);
    valid.erase(
        0, static_cast<std::size_t>(std::find_if_not(valid.begin(), valid.end(), is_rest) - valid.begin()));
  }
  return valid;
}

/// The last three lines of `text` that say something, as one printable line of at most 300 characters: where
/// a Python adapter raised what, what a C++ one threw.
std::string last_lines(const std::string& text) {
  constexpr std::size_t kLines = 3;
  constexpr std::size_t kLongest = 300;
  std::vector<std::string> lines;
  std::istringstream all(text);
  for (std::string line; std::getline(all, line);) {
    line.erase(0, line.find_first_not_of(" \t\r"));
    while (!line.empty() && std::string_view(" \t\r").find(line.back()) != std::string_view::npos)
      line.pop_back();
    const bool says_something = line.find_first_not_of(" \t^~") != std::string::npos;  // not Python's marks
    if (says_something) lines.push_back(one_line(line));
  }
  std::string joint;
  for (std::size_t i = lines.size() > kLines ? lines.size() - kLines : 0; i < lines.size(); ++i)
    joint += (joint.empty() ? "" : " | ") + lines[i];
  return joint.size() > kLongest ? "..." + joint.substr(joint.size() - (kLongest - 3)) : joint;
}

/// Whether what it wrote says that it ran out of memory.
bool ran_out_of_memory(const std::string& standard_error) {
  const std::string last = last_lines(standard_error);
  return last.find("bad_alloc") != std::string::npos || last.find("MemoryError") != std::string::npos;
}

reference::ContestFiles files_of(const ContestantTask& task) {
  return reference::contest_files(task.method.contestant->contest);
}

json build_request(const ContestantTask& task, const std::filesystem::path& mesh_in,
                   const std::filesystem::path& output) {
  json request = {{"schema", "palpate/request/1"},
                  {"contest", task.method.contestant->contest},
                  {"method", task.method.method->name},
                  {"mesh_in", mesh_in.string()},
                  {"options", task.options},
                  {"threads", task.threads}};
  const reference::ContestFiles files = files_of(task);
  if (files.has_problem) request["problem_in"] = task.problem_in.string();
  request[files.output_key] = output.string();
  if (!task.folder_out.empty()) request["folder_out"] = task.folder_out.string();
  if (files.output_key == std::string_view("mesh_out")) request["stop"] = stop_request(task.stop);
  if (!task.tuned.empty()) request["tuned"] = task.tuned;
  if (!task.keep.empty()) request["keep"] = task.keep;
  return request;
}

ContestantAnswer failed(ContestantAnswer answer, const char* outcome, const std::string& message) {
  answer.outcome = outcome;
  answer.message = message;
  return answer;
}

/// An answer that is none, with the last lines of standard error behind what is wrong with it.
ContestantAnswer bad_answer(ContestantAnswer answer, const std::string& wrong) {
  const std::string said = last_lines(answer.standard_error);
  return failed(std::move(answer), "bad_answer", wrong + (said.empty() ? "" : "; it wrote: " + said));
}

/// What is wrong with what was written, empty if nothing is.
std::string output_error(const ContestantTask& task, const json& report,
                         const std::filesystem::path& output) {
  const std::string is_no_file = file_complaint(output);
  const bool is_there = is_no_file != "none";
  const reference::ContestFiles files = files_of(task);
  if (is_there && !is_no_file.empty()) return std::string("its ") + files.output_word + " is " + is_no_file;
  if (!files.has_problem) return is_there ? "" : "it wrote no mesh";
  const json outcome = report.value("outcome", json());
  if (!outcome.is_string()) return "its report has no outcome";
  if (is_there) return "";
  if (files.output_outcome.empty()) return std::string("it wrote no ") + files.output_word;
  if (outcome != files.output_outcome) return "";
  return "it " + outcome.get<std::string>() + " and wrote no " + files.output_word;
}

ContestantAnswer read_answer(const ContestantTask& task, ContestantAnswer answer,
                             const ProcessResult& process, const std::filesystem::path& response_file) {
  const std::string is_no_file = file_complaint(response_file, kLargestAnswer);
  if (!is_no_file.empty()) return bad_answer(std::move(answer), "its answer is " + is_no_file);
  json response;
  try {
    response = parse_answer(reference::read_text_file(response_file, kLargestAnswer));
  } catch (const InputError& wrong) {
    return bad_answer(std::move(answer), one_line(wrong.what()));
  }
  const std::string status = response.at("status").get<std::string>();
  const int expected = status == "ok" ? 0 : (status == "bad_input" ? 2 : 3);
  if (process.exit_code != expected) {
    return bad_answer(std::move(answer), "it answered \"" + status + "\" and left with " + process.message);
  }
  if (status != "ok") {
    const std::string message = one_line(response.at("message").get<std::string>());
    const bool memory = message.find("bad_alloc") != std::string::npos;
    return failed(std::move(answer), memory ? "out_of_memory" : status.c_str(), message);
  }
  const std::string bad_tuned = tuned_error(response, task.tuned);
  if (!bad_tuned.empty()) return bad_answer(std::move(answer), bad_tuned);
  const double kernel_s = response.at("kernel_s").get<double>();
  if (kernel_s > process.wall_s + kClockStepSeconds) {
    return bad_answer(std::move(answer), "its kernel time of " + short_number(kernel_s) + " s exceeds the " +
                                             short_number(process.wall_s) + " s of its process");
  }
  answer.kernel_s = kernel_s;
  const std::string bad_output = output_error(task, response.at("report"), answer.output);
  if (!bad_output.empty()) return bad_answer(std::move(answer), bad_output);
  answer.report = response.at("report");
  answer.tuned = response.value("tuned", json::object());
  answer.searched = !answer.tuned.empty() && task.tuned.empty();
  for (const json& note : response.value("notes", json::array())) {
    answer.notes.push_back(one_line(note.get<std::string>()));
  }
  if (!answer.searched && process.has_usage && process.user_s > kStartSeconds &&
      kernel_s < kTinyShare * process.user_s) {
    answer.notes.push_back("kernel_s is " + short_number(kernel_s) + " s, less than a thousandth of the " +
                           short_number(process.user_s) + " s of processor time of its process");
  }
  answer.outcome = "ok";
  return answer;
}

/// Watches what the contestant is given, and copies its mesh to where it may not write. Returns the copy.
std::filesystem::path guard_inputs(const ContestantTask& task, InputGuard& guard) {
  if (!task.problem_in.empty()) guard.watch(task.problem_in);
  for (const OptionSpec& option : task.method.method->options) {
    if (option.type != OptionType::kFile || !task.options.contains(option.name)) continue;
    const std::string file = task.options.at(option.name).get<std::string>();
    if (!file.empty()) guard.watch(file);
  }
  return task.mesh_in.empty() ? task.mesh_in : guard.copy(task.mesh_in, task.scratch / "in");
}

/// A contestant that changed what it was given has no answer, whatever it says.
ContestantAnswer hold_to_inputs(ContestantAnswer answer, const InputGuard& guard) {
  const std::vector<std::string> changed = guard.restore();
  if (changed.empty() || answer.outcome == "interrupted") return answer;
  const std::string before = answer.message.empty() ? "" : "; " + answer.message;
  answer.report = nullptr;
  answer.kernel_s.reset();
  return failed(std::move(answer), "bad_answer", "it changed its input " + joined(changed) + before);
}

ContestantAnswer run_guarded(const ContestantTask& task, const std::filesystem::path& mesh_in) {
  const Contestant& contestant = *task.method.contestant;
  ContestantAnswer answer;
  const auto request_file = task.scratch / "request.json";
  const auto response_file = task.scratch / "response.json";
  const auto error_file = task.scratch / "stderr.txt";
  answer.output = task.scratch / files_of(task).output_file;
  write_file_atomically(request_file, build_request(task, mesh_in, answer.output).dump(2) + "\n");

  ProcessSpec spec;
  spec.arguments = contestant.command;
  spec.arguments.insert(spec.arguments.end(), {request_file.string(), response_file.string()});
  spec.timeout_s = task.timeout_s;
  spec.memory_bytes = task.memory_mib << 20U;
  spec.file_bytes = kLargestFile;
  spec.standard_error = error_file;
  spec.stop_flag = task.stop_flag;
  spec.stop_grace_s = task.stop_grace_s;
  spec.threads = task.threads;
  spec.while_waiting = task.while_waiting;
  const FolderIdentity scratch(task.scratch);
  const ProcessResult process = run_process(spec);
  answer.wall_s = process.wall_s;
  answer.stopped_s = process.stopped_s;
  if (process.has_usage) {
    answer.user_s = process.user_s;
    answer.peak_rss_bytes = process.peak_rss_bytes;
  }

  if (!scratch.is_same())
    return failed(std::move(answer), "bad_answer", "it put something else in the place of its folder");

  answer.standard_error = read_end(error_file, kKeptError);
  const std::string last = last_lines(answer.standard_error);
  const std::string said = last.empty() ? "" : ": " + last;
  const bool memory = ran_out_of_memory(answer.standard_error);
  switch (process.end) {
    case ProcessEnd::kInterrupted:
      return failed(std::move(answer), "interrupted", process.message);
    case ProcessEnd::kNotStarted:
      return failed(std::move(answer), "unavailable", process.message);
    case ProcessEnd::kTimedOut:
      return failed(std::move(answer), "timed_out", process.message);
    case ProcessEnd::kTooMuchMemory:
      return failed(std::move(answer), "out_of_memory", process.message);
    case ProcessEnd::kSignalled:
      return failed(std::move(answer), memory ? "out_of_memory" : "crashed", process.message + said);
    case ProcessEnd::kExited:
      break;
  }
  if (file_complaint(response_file, kLargestAnswer) == "none") {
    return failed(std::move(answer), memory ? "out_of_memory" : "crashed",
                  process.message + " without an answer" + said);
  }
  return read_answer(task, std::move(answer), process, response_file);
}

}  // namespace

ContestantAnswer run_contestant(const ContestantTask& task) {
  const std::string why = task.method.contestant->unavailable();
  if (!why.empty()) return failed({}, "unavailable", why);
  InputGuard guard;
  const std::filesystem::path mesh_in = guard_inputs(task, guard);
  ContestantAnswer answer = hold_to_inputs(run_guarded(task, mesh_in), guard);
  if (answer.outcome == "ok" || answer.outcome == "interrupted") return answer;
  const std::string no_room = room_complaint(task.scratch, answer.message + answer.standard_error);
  if (!no_room.empty())
    throw UnavailableError(no_room + "; " + task.method.method->name + ": " + answer.message);
  return answer;
}

}  // namespace palpate::experiments

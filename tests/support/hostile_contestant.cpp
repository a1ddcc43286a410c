#include "tests/support/hostile_contestant.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <thread>

#include "experiments/files/places.h"
#include "experiments/records/record_file.h"
#include "experiments/registry/description.h"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStart = R"(import json, os, shutil, signal, socket, sys, time
here = os.path.dirname(os.path.abspath(sys.argv[0]))
request = json.load(open(sys.argv[-2]))
response = sys.argv[-1]
scratch = os.path.dirname(response)

def answer_with(text):
    open(response, "w").write(text)

def answer_well(**more):
    if not os.path.lexists(request["mesh_out"]):
        shutil.copyfile(request["mesh_in"], request["mesh_out"])
    answer_with(json.dumps({"schema": "palpate/response/1", "status": "ok", "kernel_s": 1e-6, "report": {}, **more}))

)";

bool holds_in_time(const std::function<bool()>& condition) {
  constexpr int kTries = 3000;
  for (int i = 0; i < kTries; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

/// What a file of /proc has, 64 KiB of it at most; empty where its process ends meanwhile, at which reading
/// through a stream buffer throws.
std::string process_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string text(std::size_t{1} << 16U, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

bool is_zombie(const fs::path& folder) {
  const std::string status = process_text(folder / "stat");
  return status.empty() || status.find(") Z") != std::string::npos || status.find(") X") != std::string::npos;
}

}  // namespace

std::vector<pid_t> processes_with(const std::string& text) {
  std::vector<pid_t> found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (!std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isdigit(c) != 0; }))
      continue;
    const std::string words = process_text(entry.path() / "cmdline");
    if (words.find(text) != std::string::npos && !is_zombie(entry.path()))
      found.push_back(static_cast<pid_t>(std::stol(name)));
  }
  return found;
}

bool appears(const fs::path& file) {
  return holds_in_time([&] { return fs::exists(file); });
}

HostileContestant::HostileContestant(const std::string& text) {
  fs::create_directory(folder_ / "hostile");
  folder_.add("hostile/adapter.py", kStart + text);
  folder_.add("hostile/contestant.yaml",
              "schema: palpate/contestant/1\ncontest: simplify\ncommand: [/usr/bin/python3, -B, adapter.py]\n"
              "licence: MIT\nmethods: [{name: hostile.copy, summary: s, stops: [limit]}]\n");
}

experiments::ContestantAnswer HostileContestant::answer(double timeout_s, std::uint64_t memory_mib) const {
  const experiments::Registry registry(
      experiments::read_description(folder_ / "hostile/contestant.yaml", "/bin/folder"));
  experiments::ContestantTask task;
  task.method = *registry.find("hostile.copy");
  task.mesh_in = fixture_.folder() / "cube.mesh";
  task.scratch = folder_ / "scratch";
  fs::remove_all(task.scratch);
  fs::create_directory(task.scratch);
  task.options = nlohmann::json::object();
  task.timeout_s = timeout_s;
  task.memory_mib = memory_mib;
  return run_contestant(task);
}

experiments::ContestantAnswer HostileContestant::answer_with(const std::string& file,
                                                             double timeout_s) const {
  constexpr double kLong = 100.0;
  experiments::ContestantAnswer given = answer(timeout_s);
  while (!fs::exists(folder_ / "hostile" / file) && timeout_s < kLong) {
    timeout_s *= 4.0;
    given = answer(timeout_s);
  }
  return given;
}

fs::path HostileContestant::plan(const std::string& run) const {
  return folder_.add("plan.yaml",
                     "schema: palpate/plan/1\nquestion: Does it hold?\nmeshes: [{name: cube, file: " +
                         (fixture_.folder() / "cube.mesh").string() +
                         "}]\ncontest: simplify\ncontestant_folders: [hostile]\ncontestants:\n"
                         "  - {method: test.copy, label: good}\n"
                         "  - {method: hostile.copy, label: hostile}\n"
                         "  - {method: test.copy, label: good_too}\n"
                         "run: " +
                         run + "\n");
}

std::vector<std::string> HostileContestant::run_words(bool resume) const {
  std::vector<std::string> words{"run", (folder_ / "plan.yaml").string(), "--out", out().string(),
                                 "--no-report"};
  if (resume) words.emplace_back("--resume");
  return words;
}

std::vector<nlohmann::json> HostileContestant::records() const {
  return experiments::read_records(out() / "records.jsonl");
}

std::vector<pid_t> HostileContestant::processes() const {
  return processes_with((folder_ / "hostile/adapter.py").string());
}

bool HostileContestant::all_end() const {
  return holds_in_time([this] { return processes().empty(); });
}

StartedProgram::StartedProgram(const std::vector<std::string>& words) {
  std::vector<std::string> all{experiments::program_folder() + "/palpate"};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> pointers;
  pointers.reserve(all.size() + 1);
  for (std::string& word : all) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const std::string file = (folder_ / "error").string();
  process_ = ::fork();
  if (process_ != 0) return;
  const int error = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  ::dup2(error, STDERR_FILENO);
  ::dup2(error, STDOUT_FILENO);
  ::execv(pointers[0], pointers.data());
  ::_exit(127);
}

StartedProgram::~StartedProgram() {
  if (process_ <= 0) return;
  signal(SIGKILL);
  wait();
}

void StartedProgram::signal(int number) const {
  if (process_ > 0) ::kill(process_, number);
}

int StartedProgram::wait() {
  int status = 0;
  while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = 0;
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

std::string StartedProgram::error() const {
  return bytes_of(folder_ / "error");
}

}  // namespace palpate::test

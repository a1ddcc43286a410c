#include "experiments/processes/child/process_tree.h"

#include <dirent.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace palpate::experiments {
namespace {

struct Link {
  pid_t process = 0;
  pid_t parent = 0;
};

/// The parent of a process from its "pid (name) state ppid ..."; 0 if it is gone or a zombie. The name may
/// hold anything, parentheses and spaces too.
pid_t living_parent(pid_t process) {
  char path[64];
  std::snprintf(path, sizeof path, "/proc/%d/stat", static_cast<int>(process));
  std::FILE* file = std::fopen(path, "r");
  if (file == nullptr) return 0;
  char text[1024];
  const std::size_t size = std::fread(text, 1, sizeof text - 1, file);
  std::fclose(file);
  text[size] = '\0';
  const char* name_end = std::strrchr(text, ')');
  char state = 0;
  int parent = 0;
  if (name_end == nullptr || std::sscanf(name_end + 1, " %c %d", &state, &parent) != 2) return 0;
  return state == 'Z' || state == 'X' ? 0 : parent;
}

std::vector<Link> list_processes() {
  std::vector<Link> links;
  DIR* folder = ::opendir("/proc");
  if (folder == nullptr) return links;
  while (const dirent* entry = ::readdir(folder)) {
    char* end = nullptr;
    const long process = std::strtol(entry->d_name, &end, 10);
    if (process <= 0 || *end != '\0') continue;
    const pid_t parent = living_parent(static_cast<pid_t>(process));
    if (parent > 0) links.push_back({static_cast<pid_t>(process), parent});
  }
  ::closedir(folder);
  return links;
}

/// The number that a line "Pss:    1234 kB" has, in bytes; 0 if there is none.
std::uint64_t line_bytes(pid_t process, const char* file_name, const char* key) {
  char path[64];
  std::snprintf(path, sizeof path, "/proc/%d/%s", static_cast<int>(process), file_name);
  std::FILE* file = std::fopen(path, "r");
  if (file == nullptr) return 0;
  std::uint64_t bytes = 0;
  char line[256];
  while (std::fgets(line, sizeof line, file) != nullptr) {
    if (std::strncmp(line, key, std::strlen(key)) != 0) continue;
    bytes = std::strtoull(line + std::strlen(key), nullptr, 10) * 1024;
    break;
  }
  std::fclose(file);
  return bytes;
}

}  // namespace

std::vector<pid_t> find_descendants(pid_t root) {
  const std::vector<Link> links = list_processes();
  std::vector<pid_t> found;
  std::vector<pid_t> front{root};
  while (!front.empty()) {
    const pid_t parent = front.back();
    front.pop_back();
    for (const Link& link : links) {
      if (link.parent != parent || std::find(found.begin(), found.end(), link.process) != found.end())
        continue;
      found.push_back(link.process);
      front.push_back(link.process);
    }
  }
  return found;
}

std::size_t kill_descendants(pid_t root) {
  constexpr int kMostRounds = 100;  // one that starts others as fast as they are stopped is killed as it is
  std::vector<pid_t> stopped;
  for (int round = 0; round < kMostRounds; ++round) {
    bool is_new = false;
    for (const pid_t process : find_descendants(root)) {
      if (std::find(stopped.begin(), stopped.end(), process) != stopped.end()) continue;
      ::kill(process, SIGSTOP);
      stopped.push_back(process);
      is_new = true;
    }
    if (!is_new) break;
  }
  for (const pid_t process : stopped) ::kill(process, SIGKILL);
  return stopped.size();
}

std::uint64_t resident_bytes(const std::vector<pid_t>& processes) {
  std::uint64_t pages = 0;
  for (const pid_t process : processes) {
    char path[64];
    std::snprintf(path, sizeof path, "/proc/%d/statm", static_cast<int>(process));
    std::FILE* file = std::fopen(path, "r");
    if (file == nullptr) continue;
    unsigned long long all = 0;
    unsigned long long resident = 0;
    if (std::fscanf(file, "%llu %llu", &all, &resident) == 2) pages += resident;
    std::fclose(file);
  }
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

std::uint64_t proportional_bytes(const std::vector<pid_t>& processes) {
  std::uint64_t bytes = 0;
  for (const pid_t process : processes) bytes += line_bytes(process, "smaps_rollup", "Pss:");
  return bytes;
}

}  // namespace palpate::experiments

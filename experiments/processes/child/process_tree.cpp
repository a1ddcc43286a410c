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
  pid_t parent = 0;  ///< 0 if it is gone or a zombie
  pid_t group = 0;
};

/// What a process's "pid (name) state ppid pgrp ..." says. The name may hold anything, parentheses and spaces
/// too.
Link read_link(pid_t process) {
  char path[64];
  std::snprintf(path, sizeof path, "/proc/%d/stat", static_cast<int>(process));
  std::FILE* file = std::fopen(path, "r");
  if (file == nullptr) return {};
  char text[1024];
  const std::size_t size = std::fread(text, 1, sizeof text - 1, file);
  std::fclose(file);
  text[size] = '\0';
  const char* name_end = std::strrchr(text, ')');
  char state = 0;
  int parent = 0;
  int group = 0;
  if (name_end == nullptr || std::sscanf(name_end + 1, " %c %d %d", &state, &parent, &group) != 3) return {};
  if (state == 'Z' || state == 'X') return {};
  return {process, parent, group};
}

std::vector<Link> list_processes() {
  std::vector<Link> links;
  DIR* folder = ::opendir("/proc");
  if (folder == nullptr) return links;
  while (const dirent* entry = ::readdir(folder)) {
    char* end = nullptr;
    const long process = std::strtol(entry->d_name, &end, 10);
    if (process <= 0 || *end != '\0') continue;
    const Link link = read_link(static_cast<pid_t>(process));
    if (link.parent > 0) links.push_back(link);
  }
  ::closedir(folder);
  return links;
}

bool is_among(const std::vector<pid_t>& all, pid_t one) {
  return std::find(all.begin(), all.end(), one) != all.end();
}

std::vector<pid_t> descendants_among(const std::vector<Link>& links, pid_t root) {
  std::vector<pid_t> found;
  std::vector<pid_t> front{root};
  while (!front.empty()) {
    const pid_t parent = front.back();
    front.pop_back();
    for (const Link& link : links) {
      if (link.parent != parent || is_among(found, link.process)) continue;
      found.push_back(link.process);
      front.push_back(link.process);
    }
  }
  return found;
}

/// The process groups that have none but these processes.
std::vector<pid_t> groups_of(const std::vector<Link>& links, const std::vector<pid_t>& processes) {
  std::vector<pid_t> own;
  std::vector<pid_t> shared;
  for (const Link& link : links) (is_among(processes, link.process) ? own : shared).push_back(link.group);
  std::vector<pid_t> groups;
  for (const pid_t group : own) {
    if (!is_among(shared, group) && !is_among(groups, group)) groups.push_back(group);
  }
  return groups;
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
  return descendants_among(list_processes(), root);
}

std::size_t kill_descendants(pid_t root) {
  const std::vector<Link> links = list_processes();
  const std::vector<pid_t> found = descendants_among(links, root);
  for (const pid_t group : groups_of(links, found)) ::kill(-group, SIGKILL);
  for (const pid_t process : found) ::kill(process, SIGKILL);
  return found.size();
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

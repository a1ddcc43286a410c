#include "experiments/processes/child/process_tree.h"

#include <dirent.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <unordered_map>
#include <unordered_set>

namespace palpate::experiments {
namespace {

struct Link {
  pid_t process = 0;
  pid_t parent = 0;  ///< 0: it has none here (the first process, the kernel's, those from outside)
  pid_t group = 0;
  bool is_zombie = false;  ///< its first thread has ended, or all of them
};

/// What a process's "pid (name) state ppid pgrp ..." says; `process` is 0 if it is gone. The name may hold
/// anything, parentheses and spaces too.
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
  return {process, parent, group, state == 'Z' || state == 'X'};
}

/// All processes of the machine, by number.
using Links = std::unordered_map<pid_t, Link>;

Links list_processes() {
  Links links;
  DIR* folder = ::opendir("/proc");
  if (folder == nullptr) return links;
  while (const dirent* entry = ::readdir(folder)) {
    char* end = nullptr;
    const long process = std::strtol(entry->d_name, &end, 10);
    if (process <= 0 || *end != '\0') continue;
    const Link link = read_link(static_cast<pid_t>(process));
    if (link.process > 0) links.emplace(link.process, link);
  }
  ::closedir(folder);
  return links;
}

enum class Kin {
  kOwn,      ///< a descendant
  kForeign,  ///< none
  kUnknown   ///< an ancestor of it ended while the list was made: who inherited it is not in the list
};

Kin kin_of(const Links& links, const Link& link, pid_t root) {
  pid_t parent = link.parent;
  for (std::size_t steps = 0; steps <= links.size(); ++steps) {
    if (parent == root) return Kin::kOwn;
    if (parent == 0 || link.process == root) return Kin::kForeign;
    const auto next = links.find(parent);
    if (next == links.end()) return Kin::kUnknown;
    parent = next->second.parent;
  }
  return Kin::kUnknown;  // numbers were given anew meanwhile, so that the list closes a circle
}

/// A process's own, and what is known of all others.
struct Tree {
  std::vector<Link> own;
  std::vector<Link> others;  ///< those that are foreign for sure
};

Tree tree_of(pid_t root) {
  Links links = list_processes();
  Tree tree;
  std::vector<pid_t> unknown;
  const auto sort_in = [&](const Link& link) {
    const Kin kin = kin_of(links, link, root);
    if (kin == Kin::kOwn) tree.own.push_back(link);
    if (kin == Kin::kForeign) tree.others.push_back(link);
    return kin != Kin::kUnknown;
  };
  for (const auto& [process, link] : links) {
    if (!sort_in(link)) unknown.push_back(process);
  }
  for (const pid_t process : unknown) {  // by now somebody has inherited them
    links[process] = read_link(process);
    if (links[process].process > 0) sort_in(links[process]);
  }
  return tree;
}

/// The process groups of its own processes that nobody else is in. Those whose kin is not known are not
/// asked: a chain of processes that start one another and end has one of them at every look.
std::unordered_set<pid_t> groups_of(const Tree& tree) {
  std::unordered_set<pid_t> groups;
  for (const Link& link : tree.own) groups.insert(link.group);
  for (const Link& link : tree.others) groups.erase(link.group);
  groups.erase(0);  // would be this program's
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
  std::vector<pid_t> found;
  for (const Link& link : tree_of(root).own) {
    if (!link.is_zombie) found.push_back(link.process);
  }
  return found;
}

std::vector<pid_t> kill_descendants(pid_t root) {
  const Tree tree = tree_of(root);
  for (const pid_t group : groups_of(tree)) ::kill(-group, SIGKILL);
  std::vector<pid_t> found;
  for (const Link& link : tree.own) {
    ::kill(link.process, SIGKILL);  // of a zombie: its threads, where some go on without the first
    found.push_back(link.process);
  }
  std::sort(found.begin(), found.end());
  return found;
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

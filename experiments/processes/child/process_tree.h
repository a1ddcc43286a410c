// All that came of a process, and what memory it takes. A process that left its group and its session is
// still a descendant, as long as an ancestor of it collects orphans (PR_SET_CHILD_SUBREAPER).
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <vector>

namespace palpate::experiments {

/// Children of `root`, their children, and so on, as /proc has them now; zombies are left out.
std::vector<pid_t> find_descendants(pid_t root);

/// Kills all descendants of `root` that there are now, groups as a whole: one that goes on in a new child
/// every moment is met in its group, where it can't be met by itself. Returns: their numbers, in order, with
/// those that have ended and were not collected. To be repeated until there are none; those that are no
/// children of this process are collected by whoever inherits them.
std::vector<pid_t> kill_descendants(pid_t root);

/// Resident bytes of the processes together: pages that they share count once for each. 0 of one that is
/// gone.
std::uint64_t resident_bytes(const std::vector<pid_t>& processes);

/// The same, pages that they share counted once (proportional set size); slow for large processes.
std::uint64_t proportional_bytes(const std::vector<pid_t>& processes);

}  // namespace palpate::experiments

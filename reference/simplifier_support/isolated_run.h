// A vendor's kernel in a process of its own, so that a crash or a hang of one try is an error message and
// every try starts from the same fresh memory.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// A mesh, and how long the kernel that made it took.
struct TimedMesh {
  double kernel_s = 0.0;
  TetMesh mesh;
};

/// Runs `work` in a forked child, which is killed after `time_limit_s` (and with this process), and brings
/// its mesh back through a pipe. `work` times itself, so that the pipe costs it nothing. The child starts
/// with a copy of this process's memory: whatever earlier tries allocated is not there. Requires: this
/// process has one thread. Throws: InputError or std::runtime_error with the message of what `work` threw;
/// std::runtime_error if the child crashed or was too late.
TimedMesh run_isolated(const std::function<TimedMesh()>& work, double time_limit_s);

/// Runs a program (its path first) to its end, with this process's standard streams; it is killed with this
/// process. Returns its exit code. Throws: std::runtime_error if it cannot be started or a signal ended it.
int run_program(const std::vector<std::string>& arguments);

}  // namespace palpate::reference

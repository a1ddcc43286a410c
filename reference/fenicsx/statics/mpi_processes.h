// The processes that mpirun started, and what they do together.
#pragma once

#include <petscsys.h>

#include <cstdint>
#include <exception>
#include <iostream>

namespace palpate::reference::fenicsx {

inline constexpr std::int64_t kMostProcesses = 64;

inline int process_count() {
  int count = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &count);
  return count;
}

inline int process_rank() {
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  return rank;
}

/// Does the part that all processes do together: one that fails in it alone would leave the others waiting,
/// so all end with 3, and what went wrong stands on standard error. A single process throws it.
template <typename Work>
void together(const Work& work) {
  try {
    work();
  } catch (const std::exception& error) {
    if (process_count() == 1) throw;
    std::cerr << error.what() << '\n';
    MPI_Abort(PETSC_COMM_WORLD, 3);
  }
}

}  // namespace palpate::reference::fenicsx

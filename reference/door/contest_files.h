// Which files go through the door in each contest.
#pragma once

#include <array>
#include <string_view>

namespace palpate::reference {

/// The files of a request beside its mesh.
struct ContestFiles {
  std::string_view contest;
  bool has_problem = false;         ///< "problem_in"
  const char* output_key = "";      ///< of the request
  const char* output_file = "";     ///< the name that the runner gives it
  std::string_view output_outcome;  ///< the report's outcome with which there is an output; empty: always
  const char* output_word = "";     ///< in messages
  const char* beside_file =
      "";  ///< beside the output: for those who look at it, and never judged; empty: none
};

/// The files of a contest; contests that are not listed here have a mesh as their answer.
inline ContestFiles contest_files(std::string_view contest) {
  constexpr std::array kListed{
      ContestFiles{"deform", true, "displacement_out", "displacement.csv", "converged", "displacement"},
      ContestFiles{"motion", true, "history_out", "history.csv", "completed", "history", "states.json"},
      ContestFiles{"engine", true, "history_out", "history.csv", "completed", "history"},
      ContestFiles{"stability", true, "history_out", "history.json", "", "history"},
      ContestFiles{"springs", false, "springs_out", "springs.csv", "", "springs"},
      ContestFiles{"training", false, "springs_out", "springs.csv", "", "springs"},
  };
  for (const ContestFiles& files : kListed) {
    if (files.contest == contest) return files;
  }
  return {contest, false, "mesh_out", "out.mesh", "", "mesh"};
}

}  // namespace palpate::reference

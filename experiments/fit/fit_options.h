// What the user says to a fit beside its scene.
#pragma once

#include <csignal>
#include <filesystem>

namespace palpate::experiments {

struct FitOptions {
  std::filesystem::path scene;
  std::filesystem::path out;         ///< a folder that is made, or empty
  std::filesystem::path candidates;  ///< empty: candidates_path()
  double time_limit_s = 300.0;       ///< three fifths of it for the search
  const volatile std::sig_atomic_t* stop_flag = nullptr;
};

}  // namespace palpate::experiments

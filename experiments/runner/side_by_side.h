// Parts of a run in processes of their own, side by side.
#pragma once

#include <csignal>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "experiments/plan_reader/case_list.h"

namespace palpate::experiments {

/// Splits the cases that are `due` into at most `most` parts of ids: a case and those that it needs (due or
/// not) lie in one, each part has about as many, and the plan's order is kept inside each.
std::vector<std::vector<std::string>> split_cases(const std::vector<Case>& cases,
                                                  const std::vector<bool>& due, std::size_t most);

/// How parts are run.
struct SideBySide {
  std::filesystem::path plan;
  std::filesystem::path folder;  ///< gets a folder and a file of cases for each part
  int threads = 1;               ///< of a contestant
  int jobs = 1;
  const volatile std::sig_atomic_t* stop_flag = nullptr;
};

/// Runs each part by `palpate run --part`, `jobs` at a time, and calls `take` with its folder when it ends,
/// in this thread, one after the other. What a part failed at is said, and left to the caller. Returns false
/// if it was interrupted; what was finished by then is taken too.
bool run_side_by_side(const std::vector<std::vector<std::string>>& parts, const SideBySide& setting,
                      const std::function<void(const std::filesystem::path&)>& take);

/// Makes what the cases of each of these scenes (or meshes, labels: words of `--only`) need, their references
/// too, by `palpate run --prepare`, `jobs` at a time: a run of them then finds it in the cache. What fails is
/// left to that run, which says why. Returns false if it was interrupted.
bool prepare_side_by_side(const std::vector<std::string>& words, const SideBySide& setting);

}  // namespace palpate::experiments

// How far something long has come, in a file for whoever waits for it (palpate/progress/1).
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/stopwatch.h"

namespace palpate::reference {

/// Writes one JSON object, anew each time: {"schema": "palpate/progress/1", "seconds": since this was made}
/// and either {"stage": "modes"}, while the motion is prepared, or what `begin` was given and {"steps_done":
/// 100}. A file that cannot be written is no failure: the motion matters, not what is said of it.
class ProgressFile {
 public:
  /// An empty path: no file.
  explicit ProgressFile(std::filesystem::path file) : file_(std::move(file)) {}

  bool is_written() const { return !file_.empty(); }

  /// Something before the first step has begun; written at once.
  void stage(const std::string& what);

  /// The steps begin: `content` has time_step_s, stable_step_s, stable_by, steps and limiting. Written at
  /// once.
  void begin(nlohmann::json content);

  /// So many steps are done. Written a few times a second at most.
  void reach(std::uint64_t steps_done);

 private:
  void write();

  std::filesystem::path file_;
  nlohmann::json content_;
  Stopwatch watch_;
  double written_s_ = 0.0;
};

}  // namespace palpate::reference

// What a person is told while a motion is computed.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "experiments/text/terminal.h"

namespace palpate::experiments {

/// Reads the progress of a motion (palpate/progress/1, reference/engine/motion_progress.h) and says on
/// standard error: what is prepared; once, how many steps of which length there are and what limits it; then,
/// as it goes, the time that is left.
class MotionWatch {
 public:
  explicit MotionWatch(std::filesystem::path file) : file_(std::move(file)) {}

  /// Looks at the file, if there is one. Called as often as one likes.
  void look();

 private:
  void tell(const nlohmann::json& progress);
  void say_start(const nlohmann::json& progress);
  void say_stage(const std::string& stage);

  std::filesystem::path file_;
  Progress progress_;
  std::string stage_;
  bool has_started_ = false;
  bool has_estimated_ = false;
};

}  // namespace palpate::experiments

#include "reference/elastic_models/progress_file.h"

#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/error.h"

namespace palpate::reference {
namespace {

constexpr double kWritePeriodS = 0.3;

}  // namespace

void ProgressFile::stage(const std::string& what) {
  content_ = {{"stage", what}};
  write();
}

void ProgressFile::begin(nlohmann::json content) {
  content_ = std::move(content);
  content_["steps_done"] = 0;
  write();
}

void ProgressFile::reach(std::uint64_t steps_done) {
  if (file_.empty() || watch_.seconds() - written_s_ < kWritePeriodS) return;
  content_["steps_done"] = steps_done;
  write();
}

void ProgressFile::write() {
  if (file_.empty()) return;
  written_s_ = watch_.seconds();
  content_["schema"] = "palpate/progress/1";
  content_["seconds"] = written_s_;
  try {
    write_file_atomically(file_, content_.dump() + "\n");
  } catch (const InputError&) {
    file_.clear();
  }
}

}  // namespace palpate::reference

#include "reference/door/result_folder.h"

#include <string_view>
#include <vector>

#include "core/base/error.h"

namespace palpate::reference {
namespace fs = std::filesystem;
namespace {

bool is_frame_name(const std::string& name) {
  constexpr std::string_view kHead = "frame_";
  constexpr std::string_view kTail = ".vtu";
  if (!name.starts_with(kHead) || !name.ends_with(kTail)) return false;
  const std::string digits = name.substr(kHead.size(), name.size() - kHead.size() - kTail.size());
  return digits.size() >= 5 && digits.find_first_not_of("0123456789") == std::string::npos;
}

}  // namespace

std::string frame_name(std::size_t number) {
  std::string digits = std::to_string(number);
  if (digits.size() < 5) digits.insert(0, 5 - digits.size(), '0');
  return "frame_" + digits + ".vtu";
}

void remove_earlier_results(const fs::path& folder) {
  std::vector<fs::path> found;
  for (const char* name :
       {"history.csv", "frames.pvd", "summary.json", "displacement.csv", "displacement.vtu"})
    found.push_back(folder / name);
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (is_frame_name(entry.path().filename().string())) found.push_back(entry.path());
  }
  for (const fs::path& file : found) {
    fs::remove(file, error);
    if (error) throw InputError(file.string(), 0, "a file that can be removed", error.message());
  }
}

}  // namespace palpate::reference

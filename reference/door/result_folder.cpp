#include "reference/door/result_folder.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <string_view>

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

/// What stands in a result of this name, or an empty string: simulate writes no such file.
std::string mark_of(const std::string& name) {
  if (name == "history.csv") return "time_s,";
  if (name == "displacement.csv") return "vertex,ux_m,uy_m,uz_m";
  if (name == "frames.pvd") return "file=\"frame_";
  if (name == "summary.json") return "palpate/motion/1";
  return name == "displacement.vtu" || is_frame_name(name) ? "Name=\"displacement_m\"" : "";
}

/// How far into a result its mark may stand: a summary names all frames before its schema.
std::uintmax_t looked_at(const std::string& name) {
  return std::uintmax_t{1} << (name == "summary.json" ? 26U : 16U);
}

/// Whether a regular file has its mark where simulate writes it.
bool has_mark(const fs::path& file, const std::string& mark) {
  if (fs::is_symlink(file) || !fs::is_regular_file(file)) return false;
  std::ifstream in(file, std::ios::binary);
  std::string head(std::min(fs::file_size(file), looked_at(file.filename().string())), '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  return head.find(mark) != std::string::npos;
}

}  // namespace

std::string frame_name(std::size_t number) {
  std::string digits = std::to_string(number);
  if (digits.size() < 5) digits.insert(0, 5 - digits.size(), '0');
  return "frame_" + digits + ".vtu";
}

std::vector<fs::path> earlier_results(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string mark = mark_of(entry.path().filename().string());
    if (mark.empty()) continue;
    if (!has_mark(entry.path(), mark))
      throw InputError(entry.path().string(), 0, "what an earlier simulate has written, which may go",
                       "another file of that name");
    found.push_back(entry.path());
  }
  return found;
}

void remove_earlier_results(const fs::path& folder) {
  std::error_code error;
  for (const fs::path& file : earlier_results(folder)) {
    fs::remove(file, error);
    if (error) throw InputError(file.string(), 0, "a file that can be removed", error.message());
  }
}

}  // namespace palpate::reference

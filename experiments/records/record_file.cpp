#include "experiments/records/record_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <unordered_map>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/plain_file.h"
#include "experiments/records/key_forms.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

/// Throws: InputError.
[[noreturn]] void refuse_length(const std::string& file, std::size_t line, const std::string& found) {
  throw InputError(file, line, "a record of at most " + std::to_string(kLongestRecord) + " bytes", found);
}

/// Bytes up to and with the last newline; fewer than 0 where a line behind it is longer than any record.
long long whole_lines(int file, long long size) {
  std::string block;
  for (long long end = size; end > 0;) {
    const long long begin = std::max(0LL, end - 65536);
    block.resize(static_cast<std::size_t>(end - begin));
    if (::pread(file, block.data(), block.size(), begin) != static_cast<ssize_t>(block.size())) return size;
    const std::size_t newline = block.rfind('\n');
    if (newline != std::string::npos) return begin + static_cast<long long>(newline) + 1;
    end = begin;
    if (size - end > static_cast<long long>(kLongestRecord)) return -1;
  }
  return 0;
}

using nlohmann::json;

bool is_text_or_null(const json& value) {
  return value.is_string() || value.is_null();
}

bool is_list_of_texts(const json& value) {
  return value.is_null() || (value.is_array() && std::all_of(value.begin(), value.end(), is_text));
}

constexpr std::array<KeyForm, 8> kKeyForms{{
    {"repeat", kCountForm, is_count},
    {"sitting", kCountForm, is_count},
    {"label", "a text", is_text},
    {"contestant", "a text or null", is_text_or_null},
    {"mesh_file", "a text or null", is_text_or_null},
    {"output_hash", "a text or null", is_text_or_null},
    {"message", "a text or null", is_text_or_null},
    {"violations", "a list of texts", is_list_of_texts},
}};

void check_record(const json& record, const std::string& file, std::size_t line) {
  const bool sound = record.is_object() && record.value("schema", json()) == "palpate/record/1" &&
                     record.value("case", json()).is_string() &&
                     record.value("outcome", json()).is_string() &&
                     record.value("repeat", json()).is_number_integer();
  if (!sound) throw InputError(file, line, "a record (palpate/record/1)", "something else");
  check_keys(record, kKeyForms, file + ":" + std::to_string(line));
}

/// Reads the next line without its newline. False at the end, and of a rest that has no newline: the run was
/// killed while it wrote that.
bool next_line(std::ifstream& file, const std::string& name, std::size_t number, std::string& line) {
  std::array<char, 65536> part{};
  line.clear();
  while (true) {
    file.getline(part.data(), part.size());
    const auto got = static_cast<std::size_t>(file.gcount());
    if (file.bad()) throw InputError(name, number, "a line that can be read", "a read error");
    if (file.eof()) return false;
    const bool is_whole = !file.fail();  // otherwise the line goes on behind the part
    line.append(part.data(), is_whole ? got - 1 : got);
    if (line.size() > kLongestRecord) refuse_length(name, number, "more");
    if (is_whole) return true;
    file.clear();
  }
}

}  // namespace

std::vector<nlohmann::json> read_records(const std::filesystem::path& path) {
  std::vector<nlohmann::json> records;
  for_each_record(path, [&records](nlohmann::json record) { records.push_back(std::move(record)); });
  return records;
}

void for_each_record(const std::filesystem::path& path, const std::function<void(nlohmann::json)>& use) {
  refuse_no_file(path, "the records of a run");
  const std::string name = path.string();
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(name, 0, "the records of a run", "no such file");
  std::string line;
  std::unordered_map<std::string, std::set<std::int64_t>> seen;  // repeats, by case
  for (std::size_t number = 1; next_line(file, name, number, line); ++number) {
    json record = reference::parse_json(line, name + ":" + std::to_string(number));
    check_record(record, name, number);
    const auto repeat = record.at("repeat").get<std::int64_t>();
    if (!seen[record.at("case").get<std::string>()].insert(repeat).second)
      throw InputError(name, number, "each repeat of a case once",
                       "repeat " + std::to_string(repeat) + " of " + record.at("case").get<std::string>() +
                           " a second time");
    try {
      use(std::move(record));
    } catch (const json::exception& odd) {
      throw InputError(name, number, "a record (palpate/record/1)", std::string("an odd one: ") + odd.what());
    }
  }
}

double median(std::vector<double> values) {
  require(!values.empty(), "median: no values");
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

RecordFile::RecordFile(const std::filesystem::path& path) : path_(path) {
  file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (file_ < 0) fail_to_write(path_, "a file that can be written", errno);
  struct stat status {};
  const bool known = ::fstat(file_, &status) == 0;
  size_ = known ? whole_lines(file_, status.st_size) : 0;
  if (size_ < 0) {
    ::close(file_);
    refuse_length(path_.string(), 0, "more");
  }
  if (!known || (size_ < status.st_size && ::ftruncate(file_, size_) != 0)) {
    const int reason = errno;
    ::close(file_);
    fail_to_write(path_, "a file that can be written", reason);
  }
}

RecordFile::~RecordFile() {
  ::close(file_);
}

std::string record_line(const nlohmann::json& record) {
  return record.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

void RecordFile::append(const nlohmann::json& record) {
  const std::string line = record_line(record);
  if (line.size() > kLongestRecord + 1)  // with its newline; it could not be read again
    refuse_length(path_.string(), 0, std::to_string(line.size() - 1));
  errno = 0;
  const ssize_t written = ::write(file_, line.data(), line.size());
  const bool whole = written == static_cast<ssize_t>(line.size());
  const bool synced = whole && (::fsync(file_) == 0 || errno == EINVAL);
  if (!synced) {
    const int reason = errno != 0 ? errno : ENOSPC;  // a write that was cut short says nothing
    const bool taken_back = ::ftruncate(file_, size_) == 0;
    fail_to_write(path_,
                  taken_back ? "room for a record" : "room for a record, and a torn line to be taken back",
                  reason);
  }
  size_ += written;
}

FolderLock::FolderLock(const std::filesystem::path& folder) {
  const auto path = folder / ".lock";
  file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (file_ < 0) {
    throw InputError(folder.string(), 0, "a folder that can be written", std::strerror(errno));
  }
  // One that was just killed may have had a child that judged and holds the lock until it is gone too.
  constexpr int kTries = 50;
  constexpr unsigned kWaitUs = 20'000;
  for (int i = 0; ::flock(file_, LOCK_EX | LOCK_NB) != 0; ++i) {
    if (i < kTries) {
      ::usleep(kWaitUs);
      continue;
    }
    ::close(file_);
    throw InputError(folder.string() + ": another run is at work in this folder");
  }
}

FolderLock::~FolderLock() {
  ::close(file_);
}

}  // namespace palpate::experiments

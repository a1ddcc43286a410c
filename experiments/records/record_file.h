// records.jsonl: one JSON object a line, each line whole or dropped.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace palpate::experiments {

/// The records of a file in order. A last line without its newline is what a killed run leaves, and is left
/// out.
/// Throws: InputError with the line for any other line that is no record, or a second one of a repeat.
std::vector<nlohmann::json> read_records(const std::filesystem::path& path);

/// The same records one after the other, so that no more than one is held.
void for_each_record(const std::filesystem::path& path, const std::function<void(nlohmann::json)>& use);

/// The median of `values`, the mean of the middle two for an even number. Requires at least one.
double median(std::vector<double> values);

/// A record as the line that it has in the file, with its newline.
std::string record_line(const nlohmann::json& record);

/// Appends records, each with one write and one fsync, so that a kill loses at most the line being written.
class RecordFile {
 public:
  /// Opens or creates the file, and cuts off a torn last line. Throws: InputError if it cannot be written.
  explicit RecordFile(const std::filesystem::path& path);
  ~RecordFile();
  RecordFile(const RecordFile&) = delete;
  RecordFile& operator=(const RecordFile&) = delete;

  /// Throws: NoRoomError when the disk is full, InputError for one that is longer than what is read again
  /// (kLongestRecord); the file then holds whole lines only.
  void append(const nlohmann::json& record);

 private:
  std::filesystem::path path_;
  int file_ = -1;
  long long size_ = 0;
};

/// Keeps two runs out of one folder, by a lock that the system drops when its holder dies.
class FolderLock {
 public:
  /// Waits a second for another holder. Throws: InputError if another run holds the folder or the folder
  /// cannot be written.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace palpate::experiments

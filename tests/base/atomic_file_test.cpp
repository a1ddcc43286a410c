#include "core/base/atomic_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <string>

#include "core/base/error.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/scratch_folder.h"

namespace palpate {
namespace {

using test::bytes_of;
using test::FileSizeLimit;
using test::ScratchFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// The message of the InputError that `action` throws; empty if it throws none.
std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(AtomicFile, WritesTheBytesAndNothingElse) {
  const ScratchFolder folder;
  const std::string bytes("a\0b\n\xff", 5);
  write_file_atomically(folder / "out", bytes);
  EXPECT_EQ(bytes_of(folder / "out"), bytes);
  EXPECT_EQ(folder.count(), 1U);
}

TEST(AtomicFile, IsAbsentUntilCommitted) {
  const ScratchFolder folder;
  AtomicFile file(folder / "out");
  file.write("half");
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  file.write(" whole");
  file.commit();
  EXPECT_EQ(bytes_of(folder / "out"), "half whole");
}

TEST(AtomicFile, LeavesNothingWithoutACommit) {
  const ScratchFolder folder;
  {
    AtomicFile file(folder / "out");
    file.write(std::string(100000, 'x'));
  }
  EXPECT_EQ(folder.count(), 0U);
}

TEST(AtomicFile, ReplacesAFileOnlyOnCommit) {
  const ScratchFolder folder;
  folder.add("out", "old");
  {
    AtomicFile file(folder / "out");
    file.write("new");
  }
  EXPECT_EQ(bytes_of(folder / "out"), "old");
  write_file_atomically(folder / "out", "new");
  EXPECT_EQ(bytes_of(folder / "out"), "new");
}

TEST(AtomicFile, RefusesUseAfterCommit) {
  const ScratchFolder folder;
  AtomicFile file(folder / "out");
  file.commit();
  EXPECT_THROW(file.write("more"), ContractError);
  EXPECT_THROW(file.commit(), ContractError);
}

TEST(AtomicFile, NamesAFolderThatDoesNotExist) {
  const ScratchFolder folder;
  const std::string path = folder / "missing/out";
  EXPECT_EQ(message_of([&] { write_file_atomically(path, "x"); }),
            path + ": expected a folder that can be written, found No such file or directory");
  EXPECT_EQ(folder.count(), 0U);
}

TEST(AtomicFile, NamesAFolderThatIsAFile) {
  const ScratchFolder folder;
  folder.add("file", "x");
  EXPECT_THAT(message_of([&] { write_file_atomically(folder / "file/out", "x"); }),
              HasSubstr("expected a folder that can be written, found Not a directory"));
  EXPECT_EQ(folder.count(), 1U);
}

TEST(AtomicFile, DoesNotReplaceAFolder) {
  const ScratchFolder folder;
  EXPECT_EQ(message_of([&] { write_file_atomically(folder.path(), "x"); }),
            folder.path().string() + ": expected a file to write, found a folder");
  EXPECT_TRUE(std::filesystem::is_directory(folder.path()));
  EXPECT_FALSE(std::filesystem::exists(folder.path().string() + ".partial-" + std::to_string(::getpid())));
}

TEST(AtomicFile, RefusesAFileNameThatIsTooLong) {
  const ScratchFolder folder;
  EXPECT_THAT(message_of([&] { write_file_atomically(folder / std::string(300, 'n'), "x"); }),
              HasSubstr("File name too long"));
  EXPECT_EQ(folder.count(), 0U);
}

TEST(AtomicFile, AFullDiskWhileWritingLeavesNothing) {
  const ScratchFolder folder;
  const FileSizeLimit limit(65536);
  EXPECT_THAT(message_of([&] { write_file_atomically(folder / "out", std::string(1 << 20, 'x')); }),
              AllOf(HasSubstr((folder / "out").string()), HasSubstr("expected room on the disk")));
  EXPECT_EQ(folder.count(), 0U);
}

TEST(AtomicFile, AFullDiskAtTheLastFlushLeavesTheOldFile) {
  const ScratchFolder folder;
  folder.add("out", "old");
  std::string message;
  {
    // Fewer bytes than a buffer of stdio: write() takes them, and commit() finds no room.
    const FileSizeLimit limit(10);
    AtomicFile file(folder / "out");
    file.write(std::string(100, 'x'));
    message = message_of([&] { file.commit(); });
  }
  EXPECT_THAT(message, HasSubstr("expected room on the disk"));
  EXPECT_EQ(bytes_of(folder / "out"), "old");
  EXPECT_EQ(folder.count(), 1U);
}

TEST(AtomicFile, AFullDeviceIsReportedAndNotReplaced) {
  EXPECT_EQ(message_of([] { write_file_atomically("/dev/full", "x"); }),
            "/dev/full: expected room on the disk, found No space left on device");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST(AtomicFile, WritesStraightIntoAPipe) {
  const ScratchFolder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  write_file_atomically(pipe, "through");
  std::string got(16, '\0');
  const ssize_t size = ::read(reader, got.data(), got.size());
  ::close(reader);
  ASSERT_EQ(size, 7);
  EXPECT_EQ(got.substr(0, 7), "through");
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST(AtomicFile, FollowsALink) {
  const ScratchFolder folder;
  folder.add("target", "old");
  std::filesystem::create_symlink("target", folder / "link");
  write_file_atomically(folder / "link", "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(bytes_of(folder / "target"), "new");
  EXPECT_EQ(folder.count(), 2U);
}

}  // namespace
}  // namespace palpate

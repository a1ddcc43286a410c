// Folders of strangers are emptied: deep ones, closed ones, and never beyond a link.
#include "experiments/files/remove_tree.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;

/// Makes so many folders within one another, a file in each.
void nest(const fs::path& folder, int depth) {
  int at = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY);
  for (int i = 0; i < depth; ++i) {
    ::close(::openat(at, "file", O_CREAT | O_WRONLY, 0600));
    ASSERT_EQ(::mkdirat(at, "d", 0700), 0);
    const int next = ::openat(at, "d", O_RDONLY | O_DIRECTORY);
    ::close(at);
    at = next;
  }
  ::close(at);
}

TEST(RemoveTree, DeeperThanAProcessMayHaveFilesOpen) {
  const test::ScratchFolder folder;
  nest(folder.path(), 600);
  rlimit before{};
  ::getrlimit(RLIMIT_NOFILE, &before);
  const rlimit few{100, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
  empty_folder(folder.path());
  ::setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_EQ(folder.count(), 0U);
}

TEST(RemoveTree, ClosedFoldersGoAndWhatALinkLeadsToStays) {
  const test::ScratchFolder folder;
  const test::ScratchFolder other;
  other.add("theirs", "x");
  fs::create_directories(folder / "closed/deep");
  std::error_code ignored;
  fs::create_symlink(other.path(), folder / "closed/deep/link", ignored);
  fs::create_symlink(other / "theirs", folder / "file", ignored);
  fs::permissions(folder / "closed/deep", fs::perms::none);
  fs::permissions(folder / "closed", fs::perms::none);
  empty_folder(folder.path());
  EXPECT_EQ(folder.count(), 0U);
  EXPECT_EQ(test::bytes_of(other / "theirs"), "x");
  empty_folder(folder / "nothing");  // no error
}

}  // namespace
}  // namespace palpate::experiments

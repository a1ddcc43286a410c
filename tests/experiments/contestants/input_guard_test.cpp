// What a contestant was given is as it was afterwards, or the run ends: never a part of it for the whole.
#include "experiments/contestants/input_guard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/error.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::uint64_t kFew = 4;

/// What a contestant does that owns the file.
void change(const fs::path& file, const std::string& bytes) {
  fs::permissions(file, fs::perms::owner_all);
  std::ofstream(file, std::ios::binary) << bytes;
}

TEST(InputGuard, AFileThatIsKeptIsPutBack) {
  const test::ScratchFolder folder;
  const fs::path input = folder.add("in", "abc");
  InputGuard guard(kFew);
  const fs::path copy = guard.copy(input, folder / "copies");
  EXPECT_THAT(guard.restore(), IsEmpty());
  change(input, "other");
  change(copy, "other");
  EXPECT_THAT(guard.restore(), ElementsAre("in"));
  EXPECT_EQ(test::bytes_of(input), "abc");
}

TEST(InputGuard, ALargeFileIsPutBackFromItsCopy) {
  const test::ScratchFolder folder;
  const fs::path input = folder.add("in", "larger than few");
  InputGuard guard(kFew);
  const fs::path copy = guard.copy(input, folder / "copies");
  EXPECT_EQ(test::bytes_of(copy), "larger than few");
  EXPECT_THAT(guard.restore(), IsEmpty());
  change(input, "LARGER THAN FEW");  // of the same size
  EXPECT_THAT(guard.restore(), ElementsAre("in"));
  EXPECT_EQ(test::bytes_of(input), "larger than few");
  EXPECT_THAT(guard.restore(), IsEmpty());
}

TEST(InputGuard, ALargeFileWithoutAWholeCopyIsSaidAndLeftAlone) {
  const test::ScratchFolder folder;
  const fs::path input = folder.add("in", "larger than few");
  InputGuard guard(kFew);
  const fs::path copy = guard.copy(input, folder / "copies");
  change(input, "theirs, longer than it was");
  change(copy, "theirs");
  try {
    guard.restore();
    FAIL() << "nothing is there to put it back from";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("one that a contestant has changed"));
  }
  EXPECT_EQ(test::bytes_of(input), "theirs, longer than it was");
}

}  // namespace
}  // namespace palpate::experiments

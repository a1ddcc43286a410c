// What hashes of files are of, and how large a file may be.
#include "experiments/files/file_hash.h"

#include <gtest/gtest.h>

#include <string>

#include "core/base/error.h"
#include "experiments/files/plain_file.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

TEST(FileHash, IsThatOfItsBytes) {
  const test::ScratchFolder folder;
  const std::string bytes(600'000, 'x');  // more than is read at once
  EXPECT_EQ(hash_file(folder.add("file", bytes)), hash_bytes(bytes));
  EXPECT_EQ(hash_bytes(""), "xxh3:99aa06d3014798d86001c324468d497f") << "as xxhash's own test has it";
}

TEST(FileHash, AFileOfHolesIsRefusedAtOnce) {
  const test::ScratchFolder folder;
  const auto path = folder.add("file", "");
  std::filesystem::resize_file(path, std::uint64_t{1} << 40U);
  EXPECT_THROW(hash_file(path), InputError);
  EXPECT_THROW(hash_file("/dev/zero"), InputError);
}

}  // namespace
}  // namespace palpate::experiments

// Scratch folders: gone at the end, whoever ends.
#include "experiments/files/scratch_folder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;

void grow_old(const fs::path& folder) {
  fs::last_write_time(folder, fs::file_time_type::clock::now() - std::chrono::hours(1));
}

TEST(ScratchFolder, WhatAStoppedProgramLeftGoesWithTheNextOne) {
  const test::ScratchFolder own;  // other programs look after the usual place
  const char* usual = std::getenv("TMPDIR");
  const std::string before = usual == nullptr ? "/tmp" : usual;
  ::setenv("TMPDIR", own.path().c_str(), 1);
  const ScratchFolder held;
  EXPECT_EQ(held.path().parent_path(), own.path());
  std::ofstream(held.file("in use")) << "1\n";
  grow_old(held.path());
  const fs::path left = held.path().parent_path() / "palpate-scratch-a-stopped-one";
  const fs::path young = held.path().parent_path() / "palpate-scratch-a-young-one";
  const fs::path other = held.path().parent_path() / "palpate-scratches-of-a-user";
  for (const fs::path& folder : {left, young, other}) fs::create_directories(folder / "deep");
  grow_old(left);
  grow_old(other);
  std::optional<ScratchFolder> next(std::in_place);
  EXPECT_FALSE(fs::exists(left));
  EXPECT_TRUE(fs::exists(young)) << "its program may not have locked it yet";
  EXPECT_TRUE(fs::exists(other));
  EXPECT_TRUE(fs::exists(held.file("in use")));
  const fs::path path = next->path();
  EXPECT_TRUE(fs::is_directory(path));
  next.reset();
  EXPECT_FALSE(fs::exists(path));
  ::setenv("TMPDIR", before.c_str(), 1);
}

}  // namespace
}  // namespace palpate::experiments

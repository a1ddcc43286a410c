// Which commit the sources are: by git, by a source archive, by a package, or by nobody.
#include "experiments/records/source_version.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>

#include "experiments/processes/process.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCommit = "0123456789abcdef0123456789abcdef01234567";
constexpr const char* kFile = "sources/experiments/records/source_version.yaml";

void git(const fs::path& folder, std::vector<std::string> words) {
  words.insert(words.begin(),
               {"/usr/bin/git", "-C", folder.string(), "-c", "user.name=a", "-c", "user.email=a@b.c"});
  ProcessSpec spec;
  spec.arguments = words;
  ASSERT_EQ(run_process(spec).exit_code, 0) << words.back();
}

/// What is said of sources with this text in their version file.
SourceVersion version_by(const test::ScratchFolder& folder, const std::string& text) {
  fs::create_directories((folder / kFile).parent_path());
  folder.add(kFile, text);
  return find_source_version((folder / "sources").string());
}

TEST(SourceVersion, AnArchiveNamesItsCommitAndNotWhetherItWasChanged) {
  const test::ScratchFolder folder;
  const SourceVersion found =
      version_by(folder, std::string("# words\ncommit: \"") + kCommit + "\"\nsource: archive\n");
  EXPECT_EQ(found.commit, "012345678");
  EXPECT_EQ(found.source, "archive");
  EXPECT_FALSE(found.dirty.has_value());
}

TEST(SourceVersion, APackageSaysWhetherItsSourcesWereChanged) {
  const test::ScratchFolder folder;
  const SourceVersion found =
      version_by(folder, std::string("commit: \"") + kCommit + "\"\nsource: package\ndirty: true\n");
  EXPECT_EQ(found.source, "package");
  EXPECT_EQ(found.dirty, true);
}

TEST(SourceVersion, WhereNobodyKnowsItIsUnknown) {
  const test::ScratchFolder folder;
  EXPECT_EQ(find_source_version((folder / "nowhere").string()).commit, "unknown");
  for (const std::string text :
       {"commit: \"$Format:%H$\"\nsource: archive\n", "commit: \"\"\nsource: package\n",
        "commit: \"not a commit\"\nsource: archive\n", "{", "commit: [1]\n", ""}) {
    const SourceVersion found = version_by(folder, text);
    EXPECT_EQ(found.commit, "unknown") << text;
    EXPECT_EQ(found.source, "unknown") << text;
    EXPECT_FALSE(found.dirty.has_value()) << text;
  }
}

/// A run that is killed while git refreshes the index would leave a lock there: it is not refreshed.
TEST(SourceVersion, ACheckoutIsAskedWithoutALock) {
  const test::ScratchFolder folder;
  version_by(folder, "commit: \"$Format:%H$\"\nsource: archive\n");
  const fs::path sources = folder / "sources";
  git(sources, {"init", "--quiet"});
  git(sources, {"add", "."});
  git(sources, {"commit", "--quiet", "-m", "first"});
  fs::last_write_time(folder / kFile, fs::file_time_type::clock::now() - std::chrono::hours(24));
  const std::string before = test::bytes_of(sources / ".git/index");
  EXPECT_EQ(find_source_version(sources.string()).dirty, false);
  EXPECT_EQ(test::bytes_of(sources / ".git/index"), before);
}

TEST(SourceVersion, ACheckoutIsAsked) {
  const test::ScratchFolder folder;
  const SourceVersion before = version_by(folder, "commit: \"$Format:%H$\"\nsource: archive\n");
  EXPECT_EQ(before.source, "unknown");
  const fs::path sources = folder / "sources";
  git(sources, {"init", "--quiet"});
  git(sources, {"add", "."});
  git(sources, {"commit", "--quiet", "-m", "one"});
  const SourceVersion clean = find_source_version(sources.string());
  EXPECT_EQ(clean.source, "checkout");
  EXPECT_EQ(clean.commit.size(), 9U);
  EXPECT_EQ(clean.dirty, false);
  folder.add(kFile, "changed\n");
  EXPECT_EQ(find_source_version(sources.string()).dirty, true);
}

TEST(SourceVersion, SourcesInsideSomebodyElsesCheckoutAreNotIts) {
  const test::ScratchFolder folder;
  folder.add("a_file", "\n");
  git(folder.path(), {"init", "--quiet"});
  git(folder.path(), {"add", "a_file"});
  git(folder.path(), {"commit", "--quiet", "-m", "another project"});
  EXPECT_EQ(version_by(folder, "commit: \"$Format:%H$\"\nsource: archive\n").source, "unknown");
  EXPECT_EQ(version_by(folder, std::string("commit: \"") + kCommit + "\"\nsource: archive\n").commit,
            "012345678");
}

}  // namespace
}  // namespace palpate::experiments

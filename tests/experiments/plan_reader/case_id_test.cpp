#include "experiments/plan_reader/case_id.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "core/base/random.h"

namespace palpate::experiments {
namespace {

TEST(CaseId, OrdinaryPartsStayAsTheyRead) {
  for (const char* text :
       {"kidney", "cgal.remesh", "hierarchical_87", "0.22", "1e-05", "-3", "1e+06", "true", "a.csv"})
    EXPECT_EQ(safe_part(text), text);
  EXPECT_EQ(case_part("tets_removed_ratio", "0.5"), "tets_removed_ratio=0.5");
}

TEST(CaseId, NoPartLeadsOutOfItsFolder) {
  EXPECT_EQ(safe_part("../../x"), "..%2F..%2Fx");
  EXPECT_EQ(safe_part(".."), "%2E.");
  EXPECT_EQ(safe_part("."), "%2E");
  EXPECT_EQ(safe_part("/etc/passwd"), "%2Fetc%2Fpasswd");
  EXPECT_EQ(safe_part("a=b c%d"), "a%3Db%20c%25d");
  EXPECT_EQ(safe_part(std::string("a\0b\n", 4)), "a%00b%0A");
  for (const char* text : {"..", "../..", "/", "./a", "..\\a"}) {
    const std::filesystem::path place = std::filesystem::path("run") / safe_part(text);
    EXPECT_EQ(std::distance(place.begin(), place.end()), 2) << text;
    EXPECT_EQ(place.lexically_normal(), place) << text;
  }
}

TEST(CaseId, DifferentTextsGiveDifferentParts) {
  std::set<std::string> texts{"a%2Fb", "a/b", "A/b", "a=b", "a%3Db", ".", "..", "%2E", std::string(400, 'x')};
  SplitMix64 random(7);
  for (int i = 0; i < 20'000; ++i) {
    std::string text;
    const auto length = static_cast<int>(3.0 * random.uniform()) + (i % 100 == 0 ? 200 : 1);
    for (int k = 0; k < length; ++k) text += "/.%=aA2F\n"[static_cast<int>(9.0 * random.uniform())];
    texts.insert(text);
  }
  std::set<std::string> parts;
  for (const std::string& text : texts) {
    const std::string part = safe_part(text);
    EXPECT_LE(part.size(), 100U);
    EXPECT_TRUE(parts.insert(part).second) << text;
  }
}

}  // namespace
}  // namespace palpate::experiments

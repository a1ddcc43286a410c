#include "core/base/enum_names.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

enum class Colour { kRed, kGreen, kBlue };
constexpr EnumNames<Colour, 3> kNames{"colour", {"red", "green", "blue"}};

TEST(EnumNames, NameAndValueBelongTogether) {
  for (const Colour colour : {Colour::kRed, Colour::kGreen, Colour::kBlue})
    EXPECT_EQ(kNames.parse(kNames.of(colour)), colour);
  EXPECT_STREQ(kNames.of(Colour::kGreen), "green");
}

TEST(EnumNames, RefuseWhatHasNoNameAndListThoseThatHave) {
  EXPECT_THROW(kNames.of(static_cast<Colour>(3)), ContractError);
  try {
    kNames.parse("Red");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "colour: expected red, green or blue, found Red");
  }
}

}  // namespace
}  // namespace palpate

#include "experiments/scene_writer/unit_guess.h"

#include <gtest/gtest.h>

namespace palpate::experiments {
namespace {

TEST(UnitGuess, TakesWhatMakesAnOrganOfIt) {
  EXPECT_EQ(guess_unit(130.0)->unit_m, 0.001);  // a kidney in mm: 1.3 m in cm
  EXPECT_TRUE(guess_unit(130.0)->others.empty());
  EXPECT_EQ(guess_unit(0.13)->unit_m, 1.0);
  EXPECT_TRUE(guess_unit(0.13)->others.empty());
}

TEST(UnitGuess, OfSeveralTheUsualSizeAndThenTheSmallestUnit) {
  const auto kidney_in_cm = guess_unit(13.0);  // 13 mm or 13 cm
  EXPECT_EQ(kidney_in_cm->unit_m, 0.01);
  EXPECT_EQ(kidney_in_cm->others, std::vector<double>{0.001});
  EXPECT_EQ(guess_unit(40.0)->unit_m, 0.001);  // 4 cm or 40 cm, both usual
  EXPECT_EQ(guess_unit(50.0)->unit_m, 0.001);  // 5 cm, or 50 cm
  EXPECT_EQ(guess_unit(50.0)->others, std::vector<double>{0.01});
  EXPECT_EQ(guess_unit(2.0)->unit_m, 0.01);  // 2 cm: no other, as 2 mm is too small and 2 m too large
}

TEST(UnitGuess, NothingWhereNoneFits) {
  EXPECT_FALSE(guess_unit(601.0).has_value());
  EXPECT_FALSE(guess_unit(0.7).has_value());  // 0.7 mm, 7 mm, 70 cm
  EXPECT_FALSE(guess_unit(0.005).has_value());
  EXPECT_FALSE(guess_unit(0.0).has_value());
  EXPECT_TRUE(guess_unit(600.0).has_value());
  EXPECT_TRUE(guess_unit(0.01).has_value());
}

TEST(UnitGuess, UnitsHaveNames) {
  EXPECT_EQ(unit_name(0.001), "mm");
  EXPECT_EQ(unit_name(0.01), "cm");
  EXPECT_EQ(unit_name(1.0), "m");
  EXPECT_EQ(unit_name(0.0254), "0.0254 m");
}

}  // namespace
}  // namespace palpate::experiments

#include "core/springs/identification/identify_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace palpate::springs {
namespace {

using testing::ElementsAre;

TEST(IdentifyOptions, AreSetByName) {
  IdentifyOptions options;
  set_spring_option(SpringMethod::kIsotropyPatch, "face_opposite", "true", "--set", options);
  set_spring_option(SpringMethod::kIsotropyPatch, "patch_length", "0.5", "--set", options);
  set_spring_option(SpringMethod::kUniform, "stiffness_n_per_m", "12.5", "--set", options);
  set_spring_option(SpringMethod::kThesisPrinted, "row_weight", "1e2", "--set", options);
  set_spring_option(SpringMethod::kThesisPrinted, "rows", "substituted", "--set", options);
  EXPECT_EQ(options.printed_rows, ThesisRows::kSubstituted);
  EXPECT_TRUE(options.face_opposite);
  EXPECT_EQ(options.patch_length, 0.5);
  EXPECT_EQ(options.uniform_stiffness_n_per_m, 12.5);
  EXPECT_EQ(options.stiffness_row_weight, 100.0);
  EXPECT_THAT(spring_option_names(SpringMethod::kIsotropyPatch),
              ElementsAre("face_opposite", "patch_length"));
  EXPECT_THAT(spring_option_names(SpringMethod::kLloyd), ElementsAre("face_opposite"));
  const auto refuse = [&](SpringMethod method, const char* name, const char* text,
                          const std::string& message) {
    try {
      set_spring_option(method, name, text, "--set", options);
      FAIL() << "accepted: " << message;
    } catch (const InputError& error) {
      EXPECT_EQ(error.what(), message);
    }
  };
  refuse(SpringMethod::kLloyd, "stiffness_n_per_m", "1",
         "--set: lloyd has no option \"stiffness_n_per_m\"; it has face_opposite");
  refuse(SpringMethod::kUniform, "row_weight", "1",
         "--set: uniform has no option \"row_weight\"; it has face_opposite, stiffness_n_per_m");
  refuse(SpringMethod::kUniform, "stiffness_n_per_m", "1x",
         "--set stiffness_n_per_m: expected a finite number, found \"1x\"");
  refuse(SpringMethod::kThesisPrinted, "rows", "corrected",
         "--set rows: expected letter, b4_sign or substituted, found \"corrected\"");
  refuse(SpringMethod::kThesisCorrected, "rows", "letter",
         "--set: thesis_corrected has no option \"rows\"; it has face_opposite, row_weight");
  refuse(SpringMethod::kUniform, "face_opposite", "yes",
         "--set face_opposite: expected true or false, found \"yes\"");
}

}  // namespace
}  // namespace palpate::springs

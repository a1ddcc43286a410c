#include "reference/door/json_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/scratch_folder.h"

namespace palpate::reference {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string error_of(const std::string& text, const JsonBounds& bounds = {}) {
  try {
    parse_json(text, "a.json", bounds);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

/// Lists within one another.
std::string nested(std::size_t depth) {
  return std::string(depth, '[') + std::string(depth, ']');
}

TEST(JsonFile, ReadsWhatJsonIs) {
  const json value = {{"numbers", {1, -2.5, 1e-300, 18446744073709551615U}},
                      {"text", "NaN [[[ \"{ \\ \u00e9 \n"},
                      {"nested", {{"a", nullptr}, {"b", {true, false}}}}};
  EXPECT_EQ(parse_json(value.dump(), "a.json"), value);
  EXPECT_EQ(parse_json(value.dump(2), "a.json"), value);
  EXPECT_EQ(parse_json("7", "a.json"), 7);
  const auto ordered = parse_ordered_json(R"({"b": 1, "a": {"d": 1, "c": 2}})", "a.json");
  EXPECT_EQ(ordered.dump(), R"({"b":1,"a":{"d":1,"c":2}})");
}

TEST(JsonFile, NestingHasABound) {
  EXPECT_EQ(error_of(nested(64)), "no error");
  EXPECT_THAT(error_of(nested(65)), HasSubstr("a.json: expected at most 64 levels of nesting, found more"));
  EXPECT_THAT(error_of(nested(5), {100, 4}), HasSubstr("at most 4 levels"));
  EXPECT_THAT(error_of("{\"a\":\n" + nested(100'000) + "}"), HasSubstr("a.json:2: expected at most 64"));
  EXPECT_THAT(error_of(std::string(200'000, '[')), HasSubstr("levels")) << "had overflowed the stack";
  std::string objects;
  for (int i = 0; i < 50'000; ++i) objects += "{\"a\":";
  EXPECT_THAT(error_of(objects), HasSubstr("levels"));
}

TEST(JsonFile, NumbersThatAreNone) {
  for (const char* word : {"NaN", "nan", "Infinity", "-Infinity", "inf"}) {
    EXPECT_THAT(error_of("{\"a\": 1,\n\"b\": " + std::string(word) + "}"),
                HasSubstr("a.json:2: expected a number, found " + std::string(word)));
  }
  EXPECT_THAT(error_of("[1e999]"), HasSubstr("numbers that fit into a double, found '1e999'"));
  EXPECT_THAT(error_of("[-1e999]"), HasSubstr("'-1e999'"));
}

TEST(JsonFile, WhatIsNoJson) {
  EXPECT_THAT(error_of("{\"a\": 1,\n}"), HasSubstr("a.json:2: expected JSON"));
  for (const char* text : {"", "{", "[1,]", "{} {}", "{'a': 1}", "\x7f\x45", "\"\xff\""}) {
    EXPECT_THAT(error_of(text), HasSubstr("expected JSON")) << text;
  }
  EXPECT_THAT(error_of("[1, 2, 3]", {4, 64}), HasSubstr("at most 4 bytes of JSON, found 9"));
  EXPECT_THAT(error_of(R"({"a": {"b": 1, "c": 2, "b": 3}})"), HasSubstr("the key \"b\" stands twice"));
  EXPECT_EQ(error_of(R"({"a": {"b": 1}, "b": {"b": 3}})"), "no error");
}

TEST(JsonFile, ShortValuesWithoutEndAreRefusedBeforeTheyAreHeld) {
  constexpr std::size_t kMost = std::size_t{1} << 25U;
  std::string text(2 * kMost + 2, ',');
  for (std::size_t k = 0; k < text.size(); k += 2) text[k] = '1';
  EXPECT_THAT(error_of("[" + text + "1]"), HasSubstr("expected at most 33554432 values of JSON, found more"));
}

TEST(JsonFile, FilesThatCannotBeRead) {
  const test::ScratchFolder folder;
  EXPECT_THROW(read_json_file(folder / "none.json"), InputError);
  EXPECT_THROW(read_json_file(folder.path()), InputError);
  EXPECT_THROW(read_json_file("/dev/zero"), InputError);
  EXPECT_EQ(read_json_file(folder.add("a.json", "{\"a\": 1}")), (json{{"a", 1}}));
  EXPECT_THROW(read_json_file(folder.add("a.json", "[1, 2]"), {3, 64}), InputError);
}

}  // namespace
}  // namespace palpate::reference

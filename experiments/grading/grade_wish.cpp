#include "experiments/grading/grade_wish.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/simplify/sizing/kept_region_text.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

constexpr double kLeastSize = 0.01;
constexpr double kLargestReach = 1e3;  // m

const std::vector<std::string>& near_words() {
  static const std::vector<std::string> words{"loads", "pads", "forces", "supports", "probes"};
  return words;
}

void read_pilot(const YamlValue& value, const Registry& registry, GradeWish& wish) {
  const auto where = [](const YamlValue& at) { return at.file() + ":" + std::to_string(at.line()); };
  if (value.is_text()) {
    wish.pilot = value.text();
    find_pilot(wish.pilot, registry, where(value));
    return;
  }
  const YamlFields fields = value.fields({"method", "set"});
  const YamlValue method = fields.need("method");
  wish.pilot = method.text();
  const MethodEntry entry = find_pilot(wish.pilot, registry, where(method));
  if (const auto set = fields.find("set")) {
    for (const auto& [name, option] : set->entries()) wish.pilot_set[name] = {option.text(), where(option)};
    resolve_options(*entry.method, wish.pilot_set);  // throws where a name or a value is wrong
  }
}

}  // namespace

std::string check_near(const std::string& text, const std::string& where) {
  const std::vector<std::string>& words = near_words();
  if (std::find(words.begin(), words.end(), text) != words.end()) return text;
  const std::string first = text.substr(0, text.find(' '));
  if (first == "patch")
    throw InputError(where, 0, "a sphere or a half_space in metres, or one of " + joined(words), "a patch");
  const std::vector<std::string>& kinds = simplify::kept_region_kinds();
  if (std::find(kinds.begin(), kinds.end(), first) == kinds.end())
    throw InputError(where, 0, "a region in metres, or one of " + joined(words), "\"" + text + "\"");
  simplify::parse_kept_region(text, where);  // throws
  return text;
}

MethodEntry find_pilot(const std::string& method, const Registry& registry, const std::string& where) {
  const auto entry = registry.find(method);
  if (!entry)
    throw InputError(where + ": unknown method \"" + method + "\"" +
                     nearest_hint(method, registry.method_names()));
  if (entry->contestant->contest != "deform")
    throw InputError(where + ": pilot: method " + method + " is in the contest " +
                     entry->contestant->contest + ", not in deform");
  return *entry;
}

GradeWish read_grade(const YamlValue& value, const Registry& registry) {
  const YamlFields fields =
      value.fields({"near", "near_size", "radius_m", "reach_m", "pilot", "least_size", "growth"});
  GradeWish wish;
  if (const auto near = fields.find("near")) {
    for (const YamlValue& item : near->items())
      wish.near.push_back(
          check_near(item.text(), item.file() + ":" + std::to_string(item.line()) + ": near"));
    if (wish.near.empty()) near->fail_expected("at least one place");
  }
  if (const auto pilot = fields.find("pilot")) read_pilot(*pilot, registry, wish);
  if (wish.near.empty() && wish.pilot.empty()) value.fail("grade: expected near, pilot or both");
  const auto number = [&](const char* key, double low, double high, double& target) {
    if (const auto given = fields.find(key)) target = given->number(low, high);
  };
  number("near_size", kLeastSize, 1.0, wish.near_size);
  number("radius_m", 0.0, kLargestReach, wish.radius_m);
  if (const auto reach = fields.find("reach_m")) wish.reach_m = reach->number(1e-9, kLargestReach);
  number("least_size", kLeastSize, 1.0, wish.least_size);
  number("growth", 0.01, 10.0, wish.growth);
  return wish;
}

}  // namespace palpate::experiments

#include "experiments/scene_reader/scene_require.h"

#include <algorithm>
#include <array>
#include <utility>

#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

constexpr double kLeastTolerance = 1e-4;
constexpr double kMostTolerance = 1.0;
constexpr double kLeastTime = 1e-9;
constexpr double kMostTime = 1e9;

constexpr std::array<std::pair<const char*, const char*>, 5> kErrors{{
    {"deformation_l2", "displacement_deformation"},
    {"relative_l2", "displacement_l2"},
    {"energy", "displacement_energy"},
    {"max", "displacement_max"},
    {"pad_force", "pad_force"},
}};

std::string read_error_name(const YamlValue& value) {
  const std::string name = value.text();
  std::vector<std::string> known;
  for (const auto& [error, measure] : kErrors) {
    if (name == error) return measure;
    known.emplace_back(error);
  }
  value.fail("unknown error \"" + name + "\"" + nearest_hint(name, known));
}

void read_changes(const YamlValue& value, SceneRequirement& require) {
  const std::vector<std::string>& known = changeable_things();
  for (const YamlValue& item : value.items()) {
    const std::string name = item.text();
    if (std::find(known.begin(), known.end(), name) == known.end())
      item.fail("unknown thing that may change \"" + name + "\"" + nearest_hint(name, known));
    if (std::find(require.needs.begin(), require.needs.end(), name) != require.needs.end())
      item.fail("\"" + name + "\" twice");
    require.needs.push_back(name);
  }
}

}  // namespace

const std::vector<std::string>& changeable_things() {
  static const std::vector<std::string> things{"supports", "material", "cuts"};
  return things;
}

SceneRequirement read_requirement(const YamlValue& value) {
  const YamlFields fields = value.fields(
      {"error", "time_per_second_s", "rate_hz", "answer_s", "memory_bytes", "large_strain", "may_change"});
  const YamlFields error = fields.need("error").fields({"measure", "at_most"});
  SceneRequirement require;
  require.measure = read_error_name(error.need("measure"));
  require.at_most = error.need("at_most").number(kLeastTolerance, kMostTolerance);
  if (const auto given = fields.find("time_per_second_s"))
    require.time_per_second_s = given->number(kLeastTime, kMostTime);
  if (const auto given = fields.find("rate_hz")) require.rate_hz = given->number(1.0 / kMostTime, kMostTime);
  if (const auto given = fields.find("answer_s")) {
    if (require.rate_hz || require.time_per_second_s)
      given->fail(
          "answer_s is of one answer with its set-up: it goes with neither rate_hz nor time_per_second_s");
    require.answer_s = given->number(kLeastTime, kMostTime);
  }
  if (require.rate_hz && require.time_per_second_s)
    fields.need("rate_hz").fail(
        "rate_hz is of answers at rest, time_per_second_s of a model that moves: a scene takes one of them");
  if (const auto given = fields.find("memory_bytes"))
    require.memory_bytes = static_cast<std::uint64_t>(given->number(1.0, 1e15));
  if (const auto given = fields.find("may_change")) read_changes(*given, require);
  if (const auto given = fields.find("large_strain"); given && given->boolean())
    require.needs.emplace_back("large_strain");
  return require;
}

}  // namespace palpate::experiments

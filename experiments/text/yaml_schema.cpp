#include "experiments/text/yaml_schema.h"

#include <array>
#include <optional>
#include <utility>

namespace palpate::experiments {
namespace {

/// Whatever the version: what is it, and who takes it?
constexpr std::array<std::pair<const char*, const char*>, 7> kKinds{
    {{"palpate/plan/", "a plan, which palpate run takes"},
     {"palpate/scene/", "a scene, which palpate simulate takes"},
     {"palpate/training/", "a training plan, which palpate train takes"},
     {"palpate/contestant/", "a contestant, whose folder a plan names in contestant_folders"},
     {"palpate/candidates/", "what palpate fit --candidates takes"},
     {"palpate/accepted/", "accepted figures, which palpate gate --accepted takes"},
     {"palpate/fit/", "a fit, whose folder palpate envelope takes"}}};

std::optional<YamlValue> schema_of(const YamlValue& root) {
  for (const auto& [key, value] : root.entries()) {
    if (key == "schema") return value;
  }
  return std::nullopt;
}

}  // namespace

void require_schema(const YamlValue& root, const std::string& schema) {
  if (!root.is_map()) return;
  const auto value = schema_of(root);
  if (!value) root.fail("the key \"schema\" is missing: expected schema: " + schema);
  if (!value->is_text()) value->fail_expected(schema);
  const std::string found = value->text();
  if (found == schema) return;
  for (const auto& [kind, what] : kKinds) {
    if (found.starts_with(kind) && !schema.starts_with(kind))
      value->fail("schema: expected " + schema + ", found \"" + found + "\": " + what);
  }
  value->fail_expected(schema);
}

std::string find_schema(const YamlValue& root) {
  if (!root.is_map()) return "";
  const auto value = schema_of(root);
  return value && value->is_text() ? value->text() : "";
}

}  // namespace palpate::experiments

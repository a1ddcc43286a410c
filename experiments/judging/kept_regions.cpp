#include "experiments/judging/kept_regions.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/simplify/sizing/kept_region_text.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {

std::string parse_kept_region(const std::string& text, const std::string& where) {
  const std::vector<std::string>& kinds = simplify::kept_region_kinds();
  const std::size_t start = std::min(text.find_first_not_of(' '), text.size());
  const std::string kind = text.substr(start, text.find(' ', start) - start);
  if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end())
    throw InputError(where + ": unknown region \"" + kind + "\"" + nearest_hint(kind, kinds));
  simplify::parse_kept_region(text, where);
  return text;
}

std::vector<std::string> read_kept_regions(const YamlValue& value) {
  std::vector<std::string> regions;
  for (const YamlValue& item : value.items())
    regions.push_back(parse_kept_region(item.text(), item.file() + ":" + std::to_string(item.line())));
  if (regions.empty()) value.fail_expected("at least one region");
  return regions;
}

std::string keeping_methods(const Registry& registry) {
  std::vector<std::string> names;
  for (const Contestant& contestant : registry.contestants()) {
    for (const MethodSpec& method : contestant.methods) {
      if (method.keeps) names.push_back(method.name);
    }
  }
  return names.empty() ? "; none does" : "; those that do are " + joined(names);
}

std::vector<judge::Region> judge_regions(std::span<const std::string> regions) {
  std::vector<judge::Region> result;
  for (const std::string& text : regions) {
    const simplify::KeptRegion region = simplify::parse_kept_region(text, "keep");
    switch (region.kind) {
      case simplify::KeptRegion::Kind::kSphere:
        result.push_back({judge::Region::Kind::kSphere, region.center, region.radius, 0.0});
        break;
      case simplify::KeptRegion::Kind::kHalfSpace:
        result.push_back({judge::Region::Kind::kHalfSpace, region.normal, region.offset, 0.0});
        break;
      case simplify::KeptRegion::Kind::kSurfacePatch:
        result.push_back({judge::Region::Kind::kSurfacePatch, region.center, region.radius, region.depth});
        break;
    }
  }
  return result;
}

bool meets_region(const std::string& region, const TetMesh& mesh) {
  const std::vector<std::string> alone{region};
  return judge::compare_in_regions(mesh, mesh, judge_regions(alone)).input_tets > 0;
}

}  // namespace palpate::experiments

// Regions to keep, as plans and the command line give them: one line of text each.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/judge/mesh/judge.h"
#include "experiments/registry/registry.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// Checks a region (simplify::parse_kept_region has the forms). Returns the text.
/// Throws: InputError that starts with `where`, with the nearest kind for an unknown one.
std::string parse_kept_region(const std::string& text, const std::string& where);

/// A YAML list of at least one region. Throws: InputError with file and line.
std::vector<std::string> read_kept_regions(const YamlValue& value);

/// The end of a message about a method that keeps no regions: "; those that do are a, b".
std::string keeping_methods(const Registry& registry);

/// The same regions for the judge.
std::vector<judge::Region> judge_regions(std::span<const std::string> regions);

/// Whether any tetrahedron of the mesh meets the region.
bool meets_region(const std::string& region, const TetMesh& mesh);

}  // namespace palpate::experiments

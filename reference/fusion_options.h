// Requests of the fusion family (palpate.hierarchical, tetfusion.sequential) as options structs, and their
// reports.
#pragma once

#include <cstdint>

#include "core/base/error.h"
#include "core/simplify/hierarchical.h"
#include "reference/adapter.h"

namespace palpate::reference {

/// Removes `key` from `options` and returns its value as T, or `fallback` if it is absent. `is_type` is the
/// test of the JSON value that it must pass. Throws: InputError for another type.
template <typename T>
T take_option(nlohmann::json& options, const char* key, bool (nlohmann::json::*is_type)() const noexcept,
              const char* expected, T fallback) {
  const auto it = options.find(key);
  if (it == options.end()) return fallback;
  if (!((*it).*is_type)()) throw InputError(key, 0, expected, it->dump());
  T value = it->template get<T>();
  options.erase(it);
  return value;
}

/// Takes a number from `least` to `most` out of `options`. Throws: InputError for anything else.
double take_number(nlohmann::json& options, const char* key, double least, double most, double fallback);

/// The same for a whole number.
std::int64_t take_whole(nlohmann::json& options, const char* key, std::int64_t least, std::int64_t most,
                        std::int64_t fallback);

/// Reads "stop" of a request. Throws: InputError for an unknown stop or a value that does not fit.
simplify::StopRule read_stop(const nlohmann::json& stop);

/// Reads "stop" and the options that the fusion family shares, and removes them from `options`.
/// Throws: InputError for a wrong type, a value out of range or an unknown stop.
simplify::SimplifyOptions take_fusion_options(const nlohmann::json& stop, nlohmann::json& options);

/// Reads the regions to keep, and the options "near_size" and "reach", which are removed from `options`.
/// Throws: InputError for a region or a value that makes no sense.
simplify::SizingOptions take_sizing_options(const std::vector<std::string>& keep, nlohmann::json& options);

/// Takes a choice out of `options`: the position of its value in `choices`. Throws: InputError for any other.
std::size_t take_choice(nlohmann::json& options, const char* key, const std::vector<std::string>& choices);

/// Throws InputError naming the first option that nobody took.
void require_all_taken(const nlohmann::json& options);

/// Reads the mesh, calls `simplify` on it (the timed kernel), writes the result and reports as in cli.md.
Response run_fusion(const Request& request,
                    const std::function<simplify::SimplifyReport(TetMesh&)>& simplify);

}  // namespace palpate::reference

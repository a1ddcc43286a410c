// The response of a contestant as text: what it may be (reference/PROTOCOL.md).
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

namespace palpate::experiments {

/// The largest response that is read.
inline constexpr std::size_t kLargestAnswer = std::size_t{16} << 20U;

/// The most that it may take in a record, where numbers may be written at greater length: those of a
/// reference's four levels are one record, which is read again up to kLongestRecord.
inline constexpr std::size_t kLongestInARecord = std::size_t{12} << 20U;

/// Reads a response. Returns: an object whose keys and types are those of the protocol. Throws: InputError,
/// one line that is fit for a record, for anything else.
nlohmann::json parse_answer(const std::string& text);

/// What is wrong with the parameters that a search found: they are numbers by name, and those that were
/// handed back stay as they are. Empty if nothing is.
std::string tuned_error(const nlohmann::json& response, const nlohmann::json& given);

/// Text from a contestant as one printable line of at most 300 characters.
std::string one_line(const std::string& text);

}  // namespace palpate::experiments

#include "experiments/contestants/answer_form.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr std::size_t kDeepestAnswer = 32;  // half of what other readers take: records and caches enclose it
constexpr std::size_t kMostTuned = 16;

/// What is wrong with an answer's form, empty if nothing is.
std::string form_error(const json& response) {
  if (!response.is_object()) return "its answer is no JSON object";
  if (response.value("schema", json()) != "palpate/response/1") {
    return "its answer's schema is not palpate/response/1";
  }
  const json status = response.value("status", json());
  if (!status.is_string()) return "its answer has no status";
  const bool ok = status == "ok";
  if (!ok && status != "bad_input" && status != "error") return "unknown status " + one_line(status.dump());
  const std::set<std::string> known =
      ok ? std::set<std::string>{"schema", "status", "kernel_s", "report", "notes", "tuned"}
         : std::set<std::string>{"schema", "status", "message"};
  for (const auto& [key, value] : response.items()) {
    if (known.count(key) == 0) return "unknown key \"" + one_line(key) + "\" in its answer";
  }
  if (!ok) return response.value("message", json()).is_string() ? "" : "its answer has no message";
  if (!response.contains("kernel_s")) return "the key \"kernel_s\" is missing in its answer";
  const json& kernel_s = response.at("kernel_s");
  if (!kernel_s.is_number() || !std::isfinite(kernel_s.get<double>()) || kernel_s.get<double>() <= 0.0) {
    return "kernel_s is no time above zero: " + one_line(kernel_s.dump());
  }
  if (!response.value("report", json()).is_object()) return "its answer has no report";
  const json notes = response.value("notes", json::array());
  const bool texts = notes.is_array() &&
                     std::all_of(notes.begin(), notes.end(), [](const json& n) { return n.is_string(); });
  return texts ? "" : "its notes are no list of texts";
}

}  // namespace

json parse_answer(const std::string& text) {
  json response = reference::parse_json(text, "its answer", {kLargestAnswer, kDeepestAnswer});
  const std::string wrong = form_error(response);
  if (!wrong.empty()) throw InputError(wrong);
  const std::size_t bytes = response.dump().size();
  if (bytes > kLongestInARecord) {
    throw InputError("its answer takes " + std::to_string(bytes) + " bytes in a record, where " +
                     std::to_string(kLongestInARecord) + " are the most");
  }
  return response;
}

std::string tuned_error(const json& response, const json& given) {
  const json tuned = response.value("tuned", json::object());
  if (!tuned.is_object() || tuned.size() > kMostTuned) {
    return "its tuned parameters are no list of at most 16 numbers by name";
  }
  for (const auto& [name, value] : tuned.items()) {
    if (!value.is_number() || !std::isfinite(value.get<double>())) {
      return "its tuned parameter " + one_line(name) + " is no number: " + one_line(value.dump());
    }
  }
  if (!given.empty() && tuned != given) {
    return "its tuned parameters are not those it was given: " + one_line(tuned.dump());
  }
  return "";
}

std::string one_line(const std::string& text) {
  std::string line;
  for (const char c : text.substr(0, text.find('\n'))) {
    const auto byte = static_cast<unsigned char>(c);
    line += byte < 32 || byte >= 127 ? '?' : c;
    if (line.size() == 300) break;
  }
  return line;
}

}  // namespace palpate::experiments

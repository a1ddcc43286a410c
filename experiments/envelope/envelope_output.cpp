#include "experiments/envelope/envelope_output.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/envelope/fitted_difference.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/plain_file.h"
#include "experiments/text/figure_text.h"
#include "experiments/text/yaml_value.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;
using reference::number_or_null;

constexpr std::size_t kLargestEnvelope = std::size_t{16} << 20U;
constexpr std::size_t kEnvelopeDepth = 16;
/// A scene that is the fitted one but for rounding is within.
constexpr double kRounding = 1e-9;

json optional_number(const std::optional<double>& value) {
  return value ? number_or_null(*value) : json();
}

json describe_probe(const EnvelopeProbe& probe) {
  json out{{"factor", probe.factor},
           {"rest_error", optional_number(probe.rest_error)},
           {"reference_error", optional_number(probe.reference_error)},
           {"step_error", optional_number(probe.step_error)},
           {"ending", probe.ending.empty() ? json() : json(probe.ending)}};
  if (!probe.message.empty()) out["message"] = probe.message;
  return out;
}

json describe_border(EnvelopeAxis axis, const EnvelopeBorder& border) {
  json out{{"name", axis_name(axis)},
           {"text", axis_text(axis)},
           {"most", most_factor(axis)},
           {"holds_to", optional_number(border.holds_to)},
           {"fails_at", optional_number(border.fails_at)},
           {"ending", nullptr},
           {"complete", border.is_complete},
           {"probes", json::array()}};
  for (const EnvelopeProbe& probe : border.probes) {
    out["probes"].push_back(describe_probe(probe));
    if (border.fails_at && probe.factor == *border.fails_at) out["ending"] = probe.ending;
  }
  return out;
}

json describe_place(const EnvelopePlace& place) {
  return {{"young_modulus_pa", place.young_modulus_pa},
          {"density_kg_m3", place.density_kg_m3},
          {"poisson_ratio", place.poisson_ratio},
          {"load_kinds", place.load_kinds},
          {"load_sizes", place.load_sizes},
          {"rise_s", optional_number(place.rise_s)},
          {"time_step_s", optional_number(place.step_s)}};
}

std::optional<double> figure_at(const json& value, const char* key) {
  const json found = value.value(key, json());
  return found.is_number() ? std::optional(found.get<double>()) : std::nullopt;
}

EnvelopePlace read_place(const json& value) {
  EnvelopePlace place;
  place.young_modulus_pa = value.at("young_modulus_pa").get<double>();
  place.density_kg_m3 = value.at("density_kg_m3").get<double>();
  place.poisson_ratio = value.at("poisson_ratio").get<double>();
  place.load_kinds = value.at("load_kinds").get<std::vector<std::string>>();
  place.load_sizes = value.at("load_sizes").get<std::vector<double>>();
  place.rise_s = figure_at(value, "rise_s");
  place.step_s = figure_at(value, "time_step_s");
  return place;
}

/// An ending as people say it.
std::string ending_text(const json& ending) {
  if (!ending.is_string()) return "-";
  auto name = ending.get<std::string>();
  if (name == kPassesTolerance) return "the error passes the tolerance";
  if (name == kNotMeasured) return "no error could be measured, so the border is not known";
  return name;
}

std::string border_text(const json& axis) {
  if (axis.at("holds_to").is_null()) return "not even as it is";
  std::string holds = three_digits(axis.at("holds_to").get<double>());
  if (axis.at("fails_at").is_null())
    return (axis.at("complete").get<bool>() ? "at least " : "at least (stopped) ") + holds;
  return holds;
}

/// What is beyond the border of one axis; empty if nothing is.
std::string beyond(const json& axis, double factor) {
  const auto holds = figure_at(axis, "holds_to");
  if (factor <= (1.0 + kRounding) * holds.value_or(0.0)) return "";
  if (factor <= 1.0 + kRounding && !holds) return "";  // the fit itself does not hold: said once, not here
  const bool is_known = !axis.at("fails_at").is_null();
  return std::string(axis.at("text").get<std::string>()) + " " + three_digits(factor) + ", " +
         (holds ? "measured to hold up to " + three_digits(*holds) : "which does not hold from 1 on") +
         (is_known ? " (at " + three_digits(axis.at("fails_at").get<double>()) + ": " +
                         ending_text(axis.at("ending")) + ")"
                   : " and no further looked at");
}

/// What is beyond the borders of all axes.
void add_beyond(const json& axes, const EnvelopeFactors& factors, std::vector<std::string>& lines) {
  for (const json& axis : axes) {
    for (const EnvelopeAxis each : kEnvelopeAxes) {
      const auto& factor = factors.factor.at(static_cast<std::size_t>(each));
      if (axis.at("name") != axis_name(each) || !factor) continue;
      std::string line = beyond(axis, *factor);
      if (!line.empty()) lines.push_back(std::move(line));
    }
  }
}

/// All ways in which the scene is not the fitted one, a line each.
std::vector<std::string> exits_of(const Scene& scene, const json& own, const json& envelope) {
  constexpr const char* kNothing = ": the envelope says nothing of it";
  std::vector<std::string> lines;
  if (own.value("model", json()) != envelope.at("model"))
    lines.push_back(std::string("its model is not the fitted one") + kNothing);
  if (scene.mesh.shape || !fs::exists(scene.mesh.file) ||
      hash_file(scene.mesh.file) != envelope.at("mesh_hash"))
    lines.push_back(std::string("its mesh is not the fitted one") + kNothing);
  EnvelopeFactors factors = factors_between(read_place(envelope.at("place")), place_of(own));
  if (!factors.why_none.empty()) lines.push_back(factors.why_none + kNothing);
  if (!lines.empty()) return lines;
  if (envelope.contains("scene")) {
    const json& fitted = envelope.at("scene");
    for (const std::string& line : differences_between(fitted, own)) lines.push_back(line + kNothing);
    if (const auto shorter = times_shortened(fitted, own))
      factors.factor.at(static_cast<std::size_t>(EnvelopeAxis::kFaster)) = shorter;
  } else {
    lines.push_back(scene.envelope->string() +
                    " is of an older Palpate and does not say with which supports, places of loads and "
                    "integrator it was measured: remove it and run palpate envelope again");
  }
  add_beyond(envelope.at("axes"), factors, lines);
  return lines;
}

}  // namespace

json describe_envelope(const EnvelopeResult& result) {
  json out{{"schema", "palpate/envelope/1"},
           {"measure", result.measure},
           {"at_most", result.at_most},
           {"place", describe_place(result.place)},
           {"model", result.model},
           {"mesh_hash", result.mesh_hash},
           {"scene", result.scene},
           {"complete", result.borders.size() == result.axes.size()},
           {"wall_s", result.wall_s},
           {"at_one", result.borders.empty() ? json() : describe_probe(result.at_one)},
           {"axes", json::array()}};
  for (std::size_t k = 0; k < result.borders.size(); ++k) {
    out["axes"].push_back(describe_border(result.axes[k], result.borders[k]));
    if (!result.borders[k].is_complete) out["complete"] = false;
  }
  return out;
}

std::string envelope_text(const json& envelope) {
  std::ostringstream text;
  text << "# How far the model may be taken\n\nTolerance: " << percent_of(envelope.at("at_most")) << " ("
       << envelope.at("measure").get<std::string>()
       << "), the reference's own error and what the time step adds on top.\n\n"
          "| axis | holds up to | fails at | there | error at the last that holds |\n|---|---|---|---|---|\n";
  for (const json& axis : envelope.at("axes")) {
    const json* last = nullptr;
    for (const json& probe : axis.at("probes")) {
      if (probe.at("factor") == axis.at("holds_to")) last = &probe;
    }
    const auto part = [&](const char* key) { return last == nullptr ? json() : last->at(key); };
    text << "| " << axis.at("text").get<std::string>() << " | " << border_text(axis) << " | "
         << (axis.at("fails_at").is_null() ? "-" : three_digits(axis.at("fails_at").get<double>())) << " | "
         << ending_text(axis.at("ending")) << " | " << percent_of(part("rest_error")) << " at rest, + "
         << percent_of(part("reference_error")) << " of the reference, + " << percent_of(part("step_error"))
         << " of the step |\n";
  }
  if (!envelope.at("complete").get<bool>()) text << "\nIt was stopped before all borders were found.\n";
  return text.str();
}

void write_envelope(const json& envelope, const fs::path& folder) {
  write_file_atomically(folder / "envelope.md", envelope_text(envelope));
  write_file_atomically(folder / "envelope.json", envelope.dump(1) + "\n");
  const fs::path scene = folder / "scene.yaml";
  std::string text = read_bytes(scene).value_or("");
  if (read_yaml(scene).json().contains("envelope")) return;
  if (!text.empty() && text.back() != '\n') text += '\n';
  write_file_atomically(scene, text + "envelope: envelope.json\n");
}

std::vector<std::string> leaves_envelope(const Scene& scene) {
  if (!scene.envelope) return {};
  const json envelope = reference::read_json_file(*scene.envelope, {kLargestEnvelope, kEnvelopeDepth});
  const json own = read_yaml(scene.file).json();
  try {
    if (envelope.at("schema") != "palpate/envelope/1")
      throw InputError(scene.envelope->string() + ": schema", 0, "palpate/envelope/1",
                       envelope.at("schema").dump());
    return exits_of(scene, own, envelope);
  } catch (const json::exception& error) {
    throw InputError(scene.envelope->string() + ": not as palpate envelope leaves it: " + error.what());
  }
}

}  // namespace palpate::experiments

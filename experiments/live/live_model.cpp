#include "experiments/live/live_model.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/springs/identification/identify_options.h"
#include "experiments/spring_training/identified_springs.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr const char* kUsualSprings = "springs.isotropy_patch";
constexpr std::size_t kMostSmoothedVertices = 4000;  ///< beyond, springs are what is fluent

/// An option as text, as identify_options reads it; empty if it is not there.
std::string text_of(const json& options, const std::string& key) {
  if (!options.contains(key) || options.at(key).is_null()) return "";
  const json& value = options.at(key);
  return value.is_string() ? value.get<std::string>() : value.dump();
}

SpringNetwork identify(const LiveLevel& level, const json& source, LiveBodyData& out) {
  const json& options = source.at("options");
  const std::string name = source.at("method").get<std::string>().substr(std::string("springs.").size());
  SpringWish wish;
  wish.method = springs::parse_spring_method(name);
  wish.material = level.holding.material;
  springs::IdentifyOptions checked;
  for (const std::string& key : springs::spring_option_names(wish.method)) {
    const std::string text = text_of(options, key);
    if (text.empty()) continue;
    springs::set_spring_option(wish.method, key, text, "model", checked);
    wish.set[key] = text;
  }
  wish.calibrate = options.value("calibrate", false);
  IdentifiedSprings found = obtain_springs(level.mesh, wish);
  for (const std::string& warning : found.report.warnings) {
    if (&level == &out.levels.front()) out.notes.push_back(warning);
  }
  return std::move(found.network);
}

/// The scene's model with all of its options; null without one.
json read_model(const Scene& scene, const Registry& registry) {
  if (!scene.model) return nullptr;
  const MethodEntry entry = find_model(scene, registry);
  return {{"method", scene.model->method}, {"options", resolve_options(*entry.method, scene.model->set)}};
}

/// Whether springs of that model are made here.
bool is_identified(const json& model) {
  if (model.is_null()) return false;
  const auto method = model.at("method").get<std::string>();
  return method.starts_with("springs.") && method != "springs.trained" &&
         text_of(model.at("options"), "mean_n_per_m").empty();
}

/// The law that the page starts with. At small strain a scene at rest moves with the corotated one, which is
/// the same there and turns with the body.
std::string law_of(const Scene& scene, const json& model) {
  if (scene.is_dynamic && scene.strain == StrainSize::kSmall) return "linear";
  if (model.is_null() || scene.strain == StrainSize::kSmall) return "corotated";
  std::string law = text_of(model.at("options"), "law");
  if (!law.empty() && law != "default") return law;
  return model.at("method").get<std::string>().starts_with("springs.") ? "corotated" : "neo_hookean";
}

json smoothed_start(double theta, const char* domain, const char* rest) {
  return {{"model", "smoothed"}, {"theta", theta}, {"domain", domain}, {"rest", rest}, {"stabilise", 0.0}};
}

json usual_start(const LiveBodyData& out) {
  if (out.levels.front().mesh.points.size() > kMostSmoothedVertices)
    return {{"model", "springs"}, {"volume", "none"}};
  return smoothed_start(0.0, "node", "edge");
}

/// What stands in for a model that does not move here by itself: finite elements as what has the same shape
/// functions, and a table where there is one. Else the usual start stays.
void choose_stand_in(const std::string& method, LiveBodyData& out) {
  const bool has_table = out.table.has_value();
  if (method == "fem.p1") {
    out.start = smoothed_start(1.0, "tet", "tet");
    out.notes.push_back("The scene's own model, fem.p1, moves as linear tetrahedra: the same elements.");
  } else if (has_table && (method == "reduced.compliance" || method == "fem.p2")) {
    out.start = {{"model", "reduced"}};
    if (method == "fem.p2")
      out.notes.push_back(
          "The scene's own model, fem.p2, stands here as the table of its answers: at rest, of small "
          "strain.");
  } else {
    out.notes.push_back("The scene's own model, " + method +
                        ", does not move live: another one starts in its place.");
  }
}

}  // namespace

void choose_start(const Scene& scene, const Registry& registry, LiveBodyData& out) {
  const json model = read_model(scene, registry);
  out.spring_source = {{"method", kUsualSprings}, {"options", json::object()}};
  out.start = usual_start(out);
  if (is_identified(model)) {
    out.spring_source = model;
    const json& options = model.at("options");
    out.start = {{"model", "springs"},
                 {"volume", options.value("volume", "none")},
                 {"theta", options.value("theta", 0.6)},
                 {"shear", options.value("shear", "node")}};
  } else if (!model.is_null() && model.at("method").get<std::string>().starts_with("smoothed.")) {
    out.start = {{"model", "smoothed"}};
    for (const char* key : {"theta", "domain", "rest", "stabilise"})
      out.start[key] = model["options"].at(key);
  } else if (!model.is_null()) {
    choose_stand_in(model.at("method").get<std::string>(), out);
  }
  if (!model.is_null()) out.start["method"] = model.at("method");
  out.start["law"] = law_of(scene, model);
  if (scene.is_dynamic && scene.dynamic.time_step_s) out.start["step_s"] = *scene.dynamic.time_step_s;
  out.start["integrator"] =
      scene.is_dynamic ? dynamics::integrator_name(scene.dynamic.integrator) : "symplectic_euler";
  for (LiveLevel& level : out.levels) level.springs = identify(level, out.spring_source, out);
}

}  // namespace palpate::experiments

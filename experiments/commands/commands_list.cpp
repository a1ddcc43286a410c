// list contestants, meshes, measures.
#include <iostream>
#include <memory>

#include "core/base/error.h"
#include "experiments/commands/commands.h"
#include "experiments/contestants/contestant.h"
#include "experiments/judging/measure.h"
#include "experiments/meshes/mesh_source.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

std::string text_of(const json& value) {
  if (value.is_null()) return "not given";
  return value.is_string() ? value.get<std::string>() : value.dump();
}

json describe_option(const OptionSpec& option) {
  json value = {{"name", option.name},
                {"type", kOptionTypeNames.of(option.type)},
                {"default", option.default_value},
                {"help", option.help}};
  if (!option.choices.empty()) value["choices"] = option.choices;
  if (option.min) value["min"] = *option.min;
  if (option.max) value["max"] = *option.max;
  return value;
}

json describe_contestant(const Contestant& contestant) {
  json methods = json::array();
  for (const MethodSpec& method : contestant.methods) {
    json options = json::array();
    for (const OptionSpec& option : method.options) options.push_back(describe_option(option));
    methods.push_back({{"name", method.name},
                       {"summary", method.summary},
                       {"stops", method.stops},
                       {"keep", method.keeps},
                       {"deterministic", method.deterministic},
                       {"options", std::move(options)}});
  }
  const std::string why = contestant.unavailable();
  return {{"folder", contestant.folder},     {"contest", contestant.contest},
          {"available", why.empty()},        {"reason", why},
          {"packages", contestant.packages}, {"licence", contestant.licence},
          {"source", contestant.source},     {"methods", std::move(methods)}};
}

void print_method(const MethodSpec& method) {
  std::cout << "  " << colored(method.name, Color::kBold) << ": " << method.summary << '\n';
  if (!method.stops.empty()) std::cout << "    stops at: " << joined(method.stops) << '\n';
  if (method.keeps) std::cout << "    takes --keep \"sphere x y z r\" and the like\n";
  if (!method.deterministic) std::cout << "    not deterministic: the same request may give another mesh\n";
  for (const OptionSpec& option : method.options) {
    std::string values = kOptionTypeNames.of(option.type);
    if (!option.choices.empty()) {
      values.clear();
      for (const std::string& choice : option.choices) values += (values.empty() ? "" : "|") + choice;
    }
    std::cout << "    --set " << option.name << '=' << values << " (" << text_of(option.default_value)
              << "): " << option.help << '\n';
  }
}

int list_contestants(bool as_json) {
  const Registry registry = load_registry();
  json all = json::array();
  for (const Contestant& contestant : registry.contestants()) all.push_back(describe_contestant(contestant));
  if (as_json) {
    print_json({{"contestants", all}});
    return kDone;
  }
  for (const Contestant& contestant : registry.contestants()) {
    const std::string why = contestant.unavailable();
    std::cout << contestant.folder << " (" << contestant.contest << ", " << contestant.licence << "): "
              << (why.empty() ? colored("available", Color::kGreen)
                              : colored("unavailable", Color::kRed) + ", " + why)
              << '\n';
    for (const MethodSpec& method : contestant.methods) print_method(method);
  }
  if (registry.contestants().empty()) std::cout << "There are no contestants.\n";
  return kDone;
}

int list_meshes(bool as_json) {
  if (as_json) {
    json all = json::array();
    for (const ShapeInfo& shape : list_shapes()) {
      all.push_back({{"name", shape.name},
                     {"summary", shape.summary},
                     {"unit", shape.unit},
                     {"available", shape.unavailable.empty()},
                     {"reason", shape.unavailable}});
    }
    print_json({{"meshes", all}});
    return kDone;
  }
  TextTable table({"shape", "unit", "", "summary"}, "llll");
  for (const ShapeInfo& shape : list_shapes()) {
    const bool available = shape.unavailable.empty();
    table.add({shape.name, shape.unit,
               available ? colored("available", Color::kGreen) : colored("unavailable", Color::kRed),
               available ? shape.summary : shape.summary + " (" + shape.unavailable + ")"});
  }
  std::cout << table.text();
  return kDone;
}

int print_measures(bool as_json) {
  if (as_json) {
    json all = json::array();
    for (const Measure& measure : list_measures()) {
      all.push_back({{"name", measure.name},
                     {"unit", measure.unit},
                     {"better", measure.better},
                     {"record_key", measure.key},
                     {"summary", measure.summary}});
    }
    print_json({{"measures", all}});
    return kDone;
  }
  TextTable table({"measure", "unit", "better", "summary"}, "llll");
  for (const Measure& measure : list_measures()) {
    table.add({measure.name, measure.unit, measure.better, measure.summary});
  }
  std::cout << table.text();
  return kDone;
}

}  // namespace

void add_list_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("list", "List contestants, meshes or measures");
  command->require_subcommand(1);
  command->footer(
      "The environment variable PALPATE_CONTESTANTS adds folders of contestants, separated by colons.");
  const auto add = [&](const char* name, const char* summary, int (*print)(bool)) {
    auto as_json = std::make_shared<bool>(false);
    CLI::App* what = command->add_subcommand(name, summary);
    what->add_flag("--json", *as_json, "Print as JSON");
    what->callback([as_json, print, &exit_code] { exit_code = print(*as_json); });
  };
  add("contestants", "Methods, their options, and whether they can run here", list_contestants);
  add("meshes", "Shapes that palpate make and plans know", list_meshes);
  add("measures", "Figures that plans can ask for and bound", print_measures);
}

}  // namespace palpate::experiments

// list contestants, meshes, measures.
#include <algorithm>
#include <cctype>
#include <iostream>
#include <memory>

#include "core/base/error.h"
#include "experiments/commands/commands.h"
#include "experiments/judging/measure.h"
#include "experiments/meshes/mesh_source.h"
#include "experiments/registry/contestant.h"
#include "experiments/registry/option_spec.h"
#include "experiments/registry/registry.h"
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

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Whether a name has these letters in it, capitals or not.
bool has_part(const std::string& name, const std::string& part) {
  return lower(name).find(lower(part)) != std::string::npos;
}

/// The contestants whose folder, contest or methods have `part` in their names; of the others' methods only
/// those. All for "". Throws: InputError if there is none.
std::vector<Contestant> choose_contestants(const Registry& registry, const std::string& part) {
  std::vector<Contestant> chosen;
  std::vector<std::string> names;
  for (Contestant contestant : registry.contestants()) {
    names.insert(names.end(), {contestant.folder, contestant.contest});
    for (const MethodSpec& method : contestant.methods) names.push_back(method.name);
    if (!has_part(contestant.folder, part) && !has_part(contestant.contest, part)) {
      std::erase_if(contestant.methods,
                    [&](const MethodSpec& method) { return !has_part(method.name, part); });
      if (contestant.methods.empty()) continue;
    }
    chosen.push_back(std::move(contestant));
  }
  if (!chosen.empty() || part.empty()) return chosen;
  const std::string hint = nearest_hint(part, names);
  const bool is_near = hint.find("did you mean") != std::string::npos;
  throw InputError(
      "list contestants: expected a part of the name of a contestant, a contest or a method, found \"" +
      part + "\"" + (is_near ? hint : "; palpate list contestants shows all"));
}

/// Prints a line in as many as it takes, those behind the first further in.
void print_wrapped(const std::string& text, std::size_t indent) {
  constexpr std::size_t kHanging = 4;
  const std::size_t columns = output_columns();
  std::size_t margin = indent;
  for (const std::string& line : wrapped(text, columns - std::min(columns - 1, indent + kHanging))) {
    std::cout << std::string(margin, ' ') << line << '\n';
    margin = indent + kHanging;
  }
}

void print_method(const MethodSpec& method) {
  print_wrapped(colored(method.name, Color::kBold) + ": " + method.summary, 2);
  if (!method.stops.empty()) print_wrapped("stops at: " + joined(method.stops), 4);
  if (method.keeps) print_wrapped("takes --keep \"sphere x y z r\" and the like", 4);
  if (!method.deterministic) print_wrapped("not deterministic: the same request may give another mesh", 4);
  for (const OptionSpec& option : method.options) {
    std::string values = kOptionTypeNames.of(option.type);
    if (!option.choices.empty()) {
      values.clear();
      for (const std::string& choice : option.choices) values += (values.empty() ? "" : "|") + choice;
    }
    print_wrapped(
        "--set " + option.name + "=" + values + " (" + text_of(option.default_value) + "): " + option.help,
        4);
  }
}

int list_contestants(const std::string& part, bool as_json) {
  const Registry registry = load_registry();
  const std::vector<Contestant> chosen = choose_contestants(registry, part);
  if (as_json) {
    json all = json::array();
    for (const Contestant& contestant : chosen) all.push_back(describe_contestant(contestant));
    print_json({{"contestants", all}});
    return kDone;
  }
  for (const Contestant& contestant : chosen) {
    const std::string why = contestant.unavailable();
    print_wrapped(contestant.folder + " (" + contestant.contest + ", " + contestant.licence + "): " +
                      (why.empty() ? colored("available", Color::kGreen)
                                   : colored("unavailable", Color::kRed) + ", " + why),
                  0);
    for (const MethodSpec& method : contestant.methods) print_method(method);
  }
  if (chosen.empty()) std::cout << "There are no contestants.\n";
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
      "palpate list contestants cgal: only those with this in the name of the contestant, its contest or the "
      "method.\n"
      "The environment variable PALPATE_CONTESTANTS adds folders of contestants, separated by colons.");
  struct Asked {
    std::string part;
    bool as_json = false;
  };
  auto asked = std::make_shared<Asked>();
  CLI::App* contestants =
      command->add_subcommand("contestants", "Methods, their options, and whether they can run here");
  contestants->add_option("FILTER", asked->part,
                          "Only those with this in the name of the contestant, its contest or the method");
  contestants->callback([asked, &exit_code] { exit_code = list_contestants(asked->part, asked->as_json); });
  CLI::App* meshes = command->add_subcommand("meshes", "Shapes that palpate make and plans know");
  meshes->callback([asked, &exit_code] { exit_code = list_meshes(asked->as_json); });
  CLI::App* measures = command->add_subcommand("measures", "Figures that plans can ask for and bound");
  measures->callback([asked, &exit_code] { exit_code = print_measures(asked->as_json); });
  for (CLI::App* what : {contestants, meshes, measures})
    what->add_flag("--json", asked->as_json, "Print as JSON");
}

}  // namespace palpate::experiments

#include "experiments/registry/description.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <sstream>

#include "experiments/registry/method_options.h"
#include "experiments/registry/stability_settings.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/yaml_schema.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {
namespace {

const std::vector<std::string> kStops{"fusions", "tets", "ratio", "limit"};

OptionType read_type(const YamlValue& value) {
  if (const auto type = kOptionTypeNames.find(value.text())) return *type;
  value.fail_expected(kOptionTypeNames.known());
}

std::vector<std::string> read_texts(const YamlValue& value) {
  std::vector<std::string> texts;
  for (const YamlValue& item : value.items()) texts.push_back(item.text());
  return texts;
}

OptionSpec read_option(const YamlValue& value) {
  const YamlFields fields =
      value.fields({"name", "type", "choices", "min", "max", "default", "help", "ranks"});
  OptionSpec option;
  option.name = fields.need("name").identifier();
  option.type = read_type(fields.need("type"));
  if (const auto choices = fields.find("choices")) option.choices = read_texts(*choices);
  if (option.choices.empty() == (option.type == OptionType::kChoice)) {
    value.fail("option " + option.name + ": choices belong to the type choice, and only there");
  }
  if (const auto min = fields.find("min")) option.min = min->number();
  if (const auto max = fields.find("max")) option.max = max->number();
  const YamlValue preset = fields.need("default");
  const bool can_be_left_out = option.type == OptionType::kNumber || option.type == OptionType::kFile;
  const bool is_left_out = can_be_left_out && preset.text() == "none";
  if (!is_left_out)
    option.default_value =
        parse_option(option, preset.text(), value.file() + ":" + std::to_string(preset.line()));
  option.help = fields.need("help").text();
  if (const auto ranks = fields.find("ranks")) option.counts_ranks = ranks->boolean();
  if (option.counts_ranks && (option.type != OptionType::kInteger || option.default_value != 1))
    value.fail("option " + option.name + ": a number of MPI ranks is an integer whose default is 1");
  return option;
}

/// The options of every method that honours regions to keep.
std::vector<OptionSpec> keep_options() {
  OptionSpec near_size{"near_size", OptionType::kNumber, {}, 1e-3, 1.0, 0.5, ""};
  near_size.help = "with regions to keep: edge length wanted at a region's border over that far away";
  OptionSpec reach{"reach", OptionType::kNumber, {}, 0.0, std::nullopt, 0.0, ""};
  reach.help =
      "with regions to keep: how far from one sizes reach their full length; 0: a quarter of the "
      "bounding box's diagonal";
  return {near_size, reach};
}

/// Stops belong to the contest `simplify`: nothing else ends at a count.
std::vector<std::string> read_stops(const YamlFields& fields, const std::string& method,
                                    const std::string& contest) {
  std::vector<std::string> stops;
  if (contest != "simplify" && !fields.find("stops")) return stops;
  for (const YamlValue& stop : fields.need("stops").items()) {
    const std::string kind = stop.text();
    if (std::find(kStops.begin(), kStops.end(), kind) == kStops.end()) {
      stop.fail("unknown stop \"" + kind + "\"" + nearest_hint(kind, kStops));
    }
    stops.push_back(kind);
  }
  if (stops.empty()) fields.self().fail("method " + method + " has no stop");
  return stops;
}

void add_option(const YamlValue& at, OptionSpec option, std::vector<OptionSpec>& options) {
  for (const OptionSpec& other : options) {
    if (other.name == option.name) at.fail("option \"" + option.name + "\" twice");
  }
  options.push_back(std::move(option));
}

void add_options(const YamlValue& list, std::vector<OptionSpec>& options) {
  for (const YamlValue& item : list.items()) add_option(item, read_option(item), options);
}

/// By name, for the methods that name them.
using OptionSets = std::map<std::string, std::vector<OptionSpec>>;

void add_sets(const YamlValue& names, const OptionSets& sets, std::vector<OptionSpec>& options) {
  for (const YamlValue& name : names.items()) {
    const auto found = sets.find(name.text());
    if (found == sets.end()) name.fail("no option set \"" + name.text() + "\"");
    for (const OptionSpec& option : found->second) add_option(name, option, options);
  }
}

MethodSpec read_method(const YamlValue& value, const std::string& contest,
                       const std::vector<OptionSpec>& of_all, const OptionSets& sets) {
  const YamlFields fields =
      value.fields({"name", "summary", "stops", "keep", "option_sets", "options", "deterministic"});
  MethodSpec method;
  method.name = fields.need("name").identifier();
  method.summary = fields.need("summary").text();
  method.stops = read_stops(fields, method.name, contest);
  if (const auto keep = fields.find("keep")) method.keeps = keep->boolean();
  if (method.keeps) method.options = keep_options();
  if (contest == "stability") method.options = stability_settings();
  for (const OptionSpec& option : of_all) add_option(value, option, method.options);
  if (const auto named = fields.find("option_sets")) add_sets(*named, sets, method.options);
  if (const auto given = fields.find("deterministic")) method.deterministic = given->boolean();
  if (const auto options = fields.find("options")) add_options(*options, method.options);
  return method;
}

/// What a folder offers in one contest; `shared` is what all its contests have.
Contestant read_contest(const YamlFields& fields, const Contestant& shared, const OptionSets& sets) {
  Contestant contestant = shared;
  contestant.contest = fields.need("contest").identifier();
  if (const auto source = fields.find("source")) contestant.source = source->text();
  std::vector<OptionSpec> of_all;
  if (const auto options = fields.find("options")) add_options(*options, of_all);
  for (const YamlValue& method : fields.need("methods").items())
    contestant.methods.push_back(read_method(method, contestant.contest, of_all, sets));
  if (contestant.methods.empty()) fields.self().fail("a contestant needs at least one method");
  return contestant;
}

/// The program of a description: a path is relative to the description's folder, a name is looked for there
/// and else in the build's bin folder.
std::filesystem::path find_program(const YamlValue& value, const std::filesystem::path& folder,
                                   const std::filesystem::path& bin_folder) {
  const std::string text = value.text();
  std::filesystem::path own = std::filesystem::absolute(folder / text).lexically_normal();
  if (text.find('/') != std::string::npos) return own;
  const std::string name = value.identifier();
  std::error_code error;
  return std::filesystem::is_regular_file(own, error) ? own : bin_folder / name;
}

/// A name as the shell would find it in PATH; the name itself if it does not.
std::filesystem::path find_in_path(const std::string& name) {
  const char* list = std::getenv("PATH");
  std::istringstream folders(list != nullptr ? list : "/usr/bin:/bin");
  std::string folder;
  while (std::getline(folders, folder, ':')) {
    std::filesystem::path found = std::filesystem::absolute(std::filesystem::path(folder) / name);
    std::error_code error;
    if (std::filesystem::is_regular_file(found, error) && ::access(found.c_str(), X_OK) == 0) return found;
  }
  return name;
}

/// The words of a description's `command`. The first one is a path (relative to the description) or a name in
/// PATH; a later one that names a file beside the description becomes its path.
void read_command(const YamlValue& value, const std::filesystem::path& folder, Contestant& contestant) {
  const std::vector<std::string> words = read_texts(value);
  if (words.empty() || words[0].empty())
    value.fail_expected("a list of words that starts with a program, such as [python3, adapter.py]");
  const bool is_path = words[0].find('/') != std::string::npos;
  contestant.program =
      is_path ? std::filesystem::absolute(folder / words[0]).lexically_normal() : find_in_path(words[0]);
  contestant.command = {contestant.program.string()};
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::filesystem::path file = std::filesystem::absolute(folder / words[i]).lexically_normal();
    std::error_code error;
    const bool is_file = !words[i].empty() && std::filesystem::is_regular_file(file, error);
    if (is_file) contestant.files.push_back(file);
    contestant.command.push_back(is_file ? file.string() : words[i]);
  }
}

/// What is started, and what that needs: `program` or `command`, `files`, and `starts`.
void read_program(const YamlFields& fields, const std::filesystem::path& folder,
                  const std::filesystem::path& bin_folder, Contestant& contestant) {
  const auto command = fields.find("command");
  if (command && fields.find("program")) command->fail("a contestant has a program or a command, not both");
  if (command) {
    read_command(*command, folder, contestant);
  } else {
    contestant.program = find_program(fields.need("program"), folder, bin_folder);
    contestant.command = {contestant.program.string()};
  }
  if (const auto starts = fields.find("starts")) {
    for (const YamlValue& other : starts->items())
      contestant.starts.push_back(find_program(other, folder, bin_folder));
  }
  if (const auto files = fields.find("files")) {
    for (const std::string& file : read_texts(*files))
      contestant.files.push_back(std::filesystem::absolute(folder / file).lexically_normal());
  }
}

}  // namespace

std::vector<Contestant> read_description(const std::filesystem::path& description,
                                         const std::filesystem::path& bin_folder) {
  const YamlValue root = read_yaml(description);
  require_schema(root, "palpate/contestant/1");
  const YamlFields fields =
      root.fields({"schema", "program", "command", "files", "starts", "packages", "licence", "option_sets",
                   "contests", "contest", "source", "options", "methods"});
  Contestant shared;
  const std::filesystem::path folder =
      std::filesystem::absolute(description).lexically_normal().parent_path();
  shared.folder = folder.filename().string();
  read_program(fields, folder, bin_folder, shared);
  if (const auto packages = fields.find("packages")) shared.packages = read_texts(*packages);
  shared.licence = fields.need("licence").text();
  OptionSets sets;
  if (const auto given = fields.find("option_sets")) {
    for (const auto& [name, list] : given->entries()) add_options(list, sets[name]);
  }
  const auto contests = fields.find("contests");
  if (!contests) return {read_contest(fields, shared, sets)};
  for (const char* key : {"contest", "source", "options", "methods"}) {
    if (fields.find(key)) root.fail(std::string(key) + " belongs to each of the contests");
  }
  std::vector<Contestant> all;
  for (const YamlValue& item : contests->items())
    all.push_back(read_contest(item.fields({"contest", "source", "options", "methods"}), shared, sets));
  if (all.empty()) contests->fail_expected("at least one contest");
  return all;
}

}  // namespace palpate::experiments

#include "experiments/contestants/contestant.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <set>
#include <sstream>

#include "core/base/error.h"
#include "experiments/contestants/stability_settings.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/places.h"
#include "experiments/processes/program_output.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

const std::vector<std::string> kStops{"fusions", "tets", "ratio", "limit"};

void check_schema(const YamlFields& fields, const std::string& schema) {
  const YamlValue value = fields.need("schema");
  if (value.text() != schema) value.fail_expected(schema);
}

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

std::string bounds_text(const OptionSpec& option) {
  std::ostringstream text;
  text << (option.type == OptionType::kInteger ? "a whole number" : "a number");
  if (option.min && option.max) {
    text << " from " << *option.min << " to " << *option.max;
  } else if (option.min) {
    text << ", at least " << *option.min;
  } else if (option.max) {
    text << ", at most " << *option.max;
  }
  return text.str();
}

template <typename T>
json parse_bounded(const OptionSpec& option, const std::string& text, const std::string& where) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  const auto real = static_cast<double>(value);
  if (!whole || !std::isfinite(real) || (option.min && real < *option.min) ||
      (option.max && real > *option.max)) {
    throw InputError(where + ": " + option.name, 0, bounds_text(option), "\"" + text + "\"");
  }
  return value;
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

std::string not_built(const std::filesystem::path& program, const std::vector<std::string>& packages) {
  std::string why = "its program " + program.filename().string() + " was not built";
  if (!packages.empty()) why += " (needs " + joined(packages) + ")";
  return why;
}

std::string why_not_started(const std::filesystem::path& program) {
  const std::string library = missing_library(program);
  if (library.empty()) return "";
  return "its program " + program.filename().string() + " lacks the shared library " + library +
         ", of a package that palpate recommends";
}

/// Descriptions directly in `root` or one folder below it.
std::vector<std::filesystem::path> find_descriptions(const std::filesystem::path& root) {
  std::vector<std::filesystem::path> found;
  std::error_code error;
  if (std::filesystem::exists(root / "contestant.yaml", error)) found.push_back(root / "contestant.yaml");
  for (const auto& entry : std::filesystem::directory_iterator(root, error)) {
    const auto description = entry.path() / "contestant.yaml";
    if (std::filesystem::exists(description, error)) found.push_back(description);
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

const OptionSpec* MethodSpec::find_option(const std::string& option) const {
  for (const OptionSpec& spec : options) {
    if (spec.name == option) return &spec;
  }
  return nullptr;
}

bool MethodSpec::takes_stop(const std::string& kind) const {
  return std::find(stops.begin(), stops.end(), kind) != stops.end();
}

std::string Contestant::unavailable() const {
  std::error_code error;
  if (std::filesystem::exists(program, error)) {
    const bool runs =
        std::filesystem::is_regular_file(program, error) && ::access(program.c_str(), X_OK) == 0;
    if (!runs) return "its program " + program.filename().string() + " is not executable";
    for (const std::filesystem::path& file : files) {
      if (!std::filesystem::is_regular_file(file, error)) return "its file " + file.string() + " is missing";
    }
    if (std::string why = why_not_started(program); !why.empty()) return why;
    for (const std::filesystem::path& other : starts) {
      if (!std::filesystem::exists(other, error)) return not_built(other, packages);
      if (std::string why = why_not_started(other); !why.empty()) return why;
    }
    return "";
  }
  if (program.is_relative()) return "its program " + program.string() + " is not in PATH";
  return not_built(program, packages);
}

Registry::Registry(std::vector<Contestant> contestants) : contestants_(std::move(contestants)) {
  std::stable_sort(contestants_.begin(), contestants_.end(),
                   [](const Contestant& a, const Contestant& b) { return a.folder < b.folder; });
  std::set<std::string> seen;
  for (const std::string& name : method_names()) {
    if (!seen.insert(name).second) throw InputError("method " + name + " is offered by two contestants");
  }
}

std::vector<std::string> Registry::method_names() const {
  std::vector<std::string> names;
  for (const Contestant& contestant : contestants_) {
    for (const MethodSpec& method : contestant.methods) names.push_back(method.name);
  }
  return names;
}

std::optional<MethodEntry> Registry::find(const std::string& method) const {
  for (const Contestant& contestant : contestants_) {
    for (const MethodSpec& spec : contestant.methods) {
      if (spec.name == method) return MethodEntry{&contestant, &spec};
    }
  }
  return std::nullopt;
}

std::vector<Contestant> read_description(const std::filesystem::path& description,
                                         const std::filesystem::path& bin_folder) {
  const YamlValue root = read_yaml(description);
  const YamlFields fields =
      root.fields({"schema", "program", "command", "files", "starts", "packages", "licence", "option_sets",
                   "contests", "contest", "source", "options", "methods"});
  check_schema(fields, "palpate/contestant/1");
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

Registry load_registry(const std::vector<std::filesystem::path>& more) {
  std::vector<std::filesystem::path> roots{std::filesystem::path(source_folder()) / "reference"};
  if (const char* extra = std::getenv("PALPATE_CONTESTANTS")) {
    std::istringstream list(extra);
    std::string folder;
    while (std::getline(list, folder, ':')) {
      if (folder.empty()) continue;
      if (!std::filesystem::is_directory(folder))
        throw InputError("PALPATE_CONTESTANTS", 0, "folders of contestants", "no folder " + folder);
      roots.emplace_back(folder);
    }
  }
  roots.insert(roots.end(), more.begin(), more.end());
  std::vector<Contestant> contestants;
  std::set<std::filesystem::path> seen;
  for (const auto& root : roots) {
    for (const auto& description : find_descriptions(root)) {
      if (!seen.insert(std::filesystem::weakly_canonical(description)).second) continue;
      for (Contestant& each : read_description(description, program_folder()))
        contestants.push_back(std::move(each));
    }
  }
  return Registry(std::move(contestants));
}

std::string hash_contestant(const Contestant& contestant) {
  std::string all = hash_file(contestant.program);
  if (contestant.files.empty()) return all;
  for (const std::filesystem::path& file : contestant.files)
    all += "\n" + file.filename().string() + " " + hash_file(file);
  return hash_bytes(all);
}

json parse_option(const OptionSpec& option, const std::string& text, const std::string& where) {
  switch (option.type) {
    case OptionType::kChoice:
      if (std::find(option.choices.begin(), option.choices.end(), text) == option.choices.end()) {
        throw InputError(where + ": " + option.name, 0, "one of " + joined(option.choices),
                         "\"" + text + "\"" + nearest_hint(text, option.choices));
      }
      return text;
    case OptionType::kBool:
      if (text != "true" && text != "false") {
        throw InputError(where + ": " + option.name, 0, "true or false", "\"" + text + "\"");
      }
      return text == "true";
    case OptionType::kInteger:
      return parse_bounded<std::int64_t>(option, text, where);
    case OptionType::kNumber:
      return parse_bounded<double>(option, text, where);
    case OptionType::kFile: {
      std::error_code error;
      if (text.empty()) return text;
      if (!std::filesystem::is_regular_file(text, error))
        throw InputError(where + ": " + option.name, 0, "a file", "none at \"" + text + "\"");
      return std::filesystem::absolute(text).lexically_normal().string();
    }
  }
  throw ContractError("parse_option: unknown type");
}

json resolve_options(const MethodSpec& method, const std::map<std::string, GivenOption>& given) {
  json options = json::object();
  for (const OptionSpec& option : method.options) {
    if (!option.default_value.is_null()) options[option.name] = option.default_value;
  }
  for (const auto& [name, value] : given) {
    const OptionSpec* option = method.find_option(name);
    if (option == nullptr) {
      std::vector<std::string> names;
      for (const OptionSpec& spec : method.options) names.push_back(spec.name);
      throw InputError(value.where + ": " + method.name + " has no option \"" + name + "\"" +
                       nearest_hint(name, names));
    }
    options[name] = parse_option(*option, value.text, value.where);
  }
  return options;
}

}  // namespace palpate::experiments

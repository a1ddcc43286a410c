#include "experiments/commands/usage.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

/// Help with a name for each value in place of its type, its range and its relations.
class PlainFormatter : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override {
    std::string text;
    if (!option->get_positional() && option->get_type_size() > 0) text = " " + option->get_type_name();
    if (option->get_positional() && option->get_expected_max() > 1) text = " ...";
    return text;
  }
};

template <typename T>
bool parse(const std::string& text, T& value) {
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, value);
  return parsed.ec == std::errc() && parsed.ptr == end;
}

std::string refused(const std::string& what, const std::string& least, const std::string& most,
                    const std::string& found) {
  return "expected " + what + " from " + least + " to " + most + ", found \"" + found + "\"";
}

CLI::Validator check_with(CLI::Validator check) {
  check.description("");
  return check;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

/// The innermost command that was given.
const CLI::App& find_command(const CLI::App& app) {
  const auto given = app.get_subcommands();
  return given.empty() ? app : find_command(*given.front());
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// Throws: InputError if `word` is none of the names, or empty.
void check_command_name(const CLI::App& command, const std::vector<std::string>& names,
                        const std::string& word) {
  const std::string before = command.get_parent() == nullptr ? "" : command.get_name() + ": ";
  if (word.empty()) throw InputError(before + "a command is missing; known are " + joined(names));
  if (std::find(names.begin(), names.end(), word) != names.end()) return;
  throw InputError(before + "unknown command \"" + word + "\"" + nearest_hint(word, names));
}

std::string explain_extra(const std::string& word, const std::vector<std::string>& options) {
  if (word.size() < 2 || word.front() != '-') return "unexpected argument \"" + word + "\"";
  const std::string name = word.substr(0, word.find('='));
  return "unknown option \"" + name + "\"" + nearest_hint(name, options);
}

std::vector<CLI::App*> commands_of(CLI::App& app) {
  return app.get_subcommands([](CLI::App*) { return true; });
}

}  // namespace

void set_plain_help(CLI::App& app) {
  auto formatter = std::make_shared<PlainFormatter>();
  formatter->column_width(26);
  formatter->label("SUBCOMMAND", "COMMAND");
  formatter->label("Positionals", "Arguments");
  app.formatter(formatter);
}

void name_command_groups(CLI::App& app) {
  for (CLI::App* command : commands_of(app)) {
    command->group("Commands");
    name_command_groups(*command);
  }
}

CLI::Validator number_from(double least, double most) {
  return check_with(CLI::Validator(
      [least, most](const std::string& text) {
        double value = 0.0;
        const bool good = parse(text, value) && std::isfinite(value) && value >= least && value <= most;
        return good ? "" : refused("a number", short_number(least), short_number(most), text);
      },
      ""));
}

CLI::Validator whole_number_from(std::int64_t least, std::int64_t most) {
  return check_with(CLI::Validator(
      [least, most](std::string& text) {
        std::int64_t value = 0;
        if (!parse(text, value) || value < least || value > most)
          return refused("a whole number", std::to_string(least), std::to_string(most), text);
        text = std::to_string(value);
        return std::string();
      },
      ""));
}

void check_material_options(double young_pa, double poisson, std::optional<double> density) {
  const auto check_above_zero = [](double value, const char* flag) {
    if (!(value > 0.0) || !std::isfinite(value))
      throw InputError(flag, 0, "a finite number above 0", short_number(value));
  };
  check_above_zero(young_pa, "--young-pa");
  if (!(poisson > -1.0 && poisson < 0.5))
    throw InputError("--poisson", 0, "a number above -1 and below 0.5", short_number(poisson));
  if (density) check_above_zero(*density, "--density");
}

void refuse_empty_values(CLI::App& app) {
  const CLI::Validator refuse = check_with(CLI::Validator(
      [](const std::string& text) { return text.empty() ? "expected a value, found \"\"" : ""; }, ""));
  for (CLI::App* command : commands_of(app)) {
    for (CLI::Option* option : command->get_options()) {
      if (option->nonpositional() && option->get_type_size() > 0) option->check(refuse);
    }
    refuse_empty_values(*command);
  }
}

void check_command_names(const CLI::App& app, int argc, char** argv) {
  const CLI::App* command = &app;
  for (int i = 1; !command_names(*command).empty(); ++i) {
    if (i < argc && argv[i][0] == '-') return;
    const std::string word = i < argc ? argv[i] : "";
    check_command_name(*command, command_names(*command), word);
    command = command->get_subcommand(word);
  }
}

std::string explain(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = find_command(app);
  const std::string before = command.get_name() == app.get_name() ? "" : command.get_name() + ": ";
  const std::vector<std::string> extras = app.remaining(true);
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr && !extras.empty()) {
    return before + explain_extra(extras.front(), option_names(command));
  }
  std::string message = error.what();
  std::replace(message.begin(), message.end(), '\n', ' ');
  return before + message + " (palpate " + (before.empty() ? "" : command.get_name() + " ") +
         "--help shows what there is)";
}

}  // namespace palpate::experiments

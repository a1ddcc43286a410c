// How the command line reads: plain help, checks of options, and hints at what was meant.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

namespace palpate::experiments {

/// Sets plain help for an application and the commands that are added after it.
void set_plain_help(CLI::App& app);

/// Puts all commands that the application has under the heading "Commands".
void name_command_groups(CLI::App& app);

inline constexpr double kMostNumber = 1e15;  ///< that an option without a limit of its own may be

/// A check that an option is a finite number from `least` to `most`.
CLI::Validator number_from(double least, double most);

/// A check that an option is a whole number from `least` to `most`, in decimal digits. For `transform`, not
/// `check`: the digits are handed on without leading zeros, which would be read as octal.
CLI::Validator whole_number_from(std::int64_t least, std::int64_t most);

/// Throws: InputError that names --young-pa, --poisson or --density unless they are those of a material.
void check_material_options(double young_pa, double poisson, std::optional<double> density);

/// Has every option that takes a value refuse an empty one, as a script gives that leaves a variable unset.
void refuse_empty_values(CLI::App& app);

/// Checks the first words against the names of the commands, and of their commands.
/// Throws: InputError with the nearest name if a word is no command, or if one is missing.
void check_command_names(const CLI::App& app, int argc, char** argv);

/// One line on what is wrong with the command line, with the nearest option if an unknown one was given.
std::string explain(const CLI::App& app, const CLI::ParseError& error);

}  // namespace palpate::experiments

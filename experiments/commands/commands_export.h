// The command export, in a file of its own.
#pragma once

#include <CLI/CLI.hpp>

namespace palpate::experiments {

/// Adds `export`: a whole model of a mesh as one file (docs/model_file.md).
void add_export_command(CLI::App& app, int& exit_code);

}  // namespace palpate::experiments

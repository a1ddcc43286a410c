// The commands of the program, each a subcommand that sets the exit code.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace palpate::experiments {

/// Exit codes of the command line.
enum ExitCode : int {
  kDone = 0,          ///< done and accepted
  kNotAccepted = 1,   ///< done, but a gate, an acceptance or a check did not hold
  kBadInput = 2,      ///< bad input or usage
  kCouldNotRun = 3,   ///< something needed could not run
  kInterrupted = 130  ///< stopped by Ctrl-C
};

void add_archive_command(CLI::App& app, int& exit_code);
void add_run_command(CLI::App& app, int& exit_code);
void add_check_command(CLI::App& app, int& exit_code);
void add_envelope_command(CLI::App& app, int& exit_code);
void add_fit_command(CLI::App& app, int& exit_code);
void add_compare_command(CLI::App& app, int& exit_code);
void add_grade_command(CLI::App& app, int& exit_code);
void add_export_command(CLI::App& app, int& exit_code);
void add_gate_command(CLI::App& app, int& exit_code);
void add_history_command(CLI::App& app, int& exit_code);
void add_list_command(CLI::App& app, int& exit_code);
void add_live_command(CLI::App& app, int& exit_code);
void add_make_command(CLI::App& app, int& exit_code);
void add_mesh_command(CLI::App& app, int& exit_code);
void add_report_command(CLI::App& app, int& exit_code);
void add_scene_command(CLI::App& app, int& exit_code);
void add_simplify_command(CLI::App& app, int& exit_code);
void add_simulate_command(CLI::App& app, int& exit_code);
void add_quality_command(CLI::App& app, int& exit_code);
void add_springs_command(CLI::App& app, int& exit_code);
void add_train_command(CLI::App& app, int& exit_code);
void add_test_command(CLI::App& app, int& exit_code);
void add_workflow_command(CLI::App& app, int& exit_code);

/// Runs the program: parses, calls the command, and turns every failure into one message on standard error,
/// "palpate: ...", and its exit code.
int run_command_line(int argc, char** argv);

}  // namespace palpate::experiments

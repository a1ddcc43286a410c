#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <csignal>
#include <exception>
#include <iostream>
#include <new>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/records/source_version.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

int fail(const std::string& message, int code) {
  print_note(message);
  return code;
}

std::string version_text() {
  const SourceVersion version = find_source_version();
  std::string text = std::string("palpate ") + PALPATE_VERSION;
  if (version.commit == "unknown") return text;
  text += " (" + version.commit;
  if (version.source != "checkout") text += ", " + version.source;
  return text + (version.dirty.value_or(false) ? ", changed)" : ")");
}

void add_commands(CLI::App& app, int& exit_code) {
  add_run_command(app, exit_code);
  add_check_command(app, exit_code);
  add_grade_command(app, exit_code);
  add_fit_command(app, exit_code);
  add_envelope_command(app, exit_code);
  add_workflow_command(app, exit_code);
  add_gate_command(app, exit_code);
  add_history_command(app, exit_code);
  add_compare_command(app, exit_code);
  add_report_command(app, exit_code);
  add_archive_command(app, exit_code);
  add_list_command(app, exit_code);
  add_make_command(app, exit_code);
  add_mesh_command(app, exit_code);
  add_scene_command(app, exit_code);
  add_simplify_command(app, exit_code);
  add_simulate_command(app, exit_code);
  add_live_command(app, exit_code);
  add_quality_command(app, exit_code);
  add_springs_command(app, exit_code);
  add_export_command(app, exit_code);
  add_train_command(app, exit_code);
  add_test_command(app, exit_code);
  name_command_groups(app);
  refuse_empty_values(app);
}

/// True if standard output is a pipe that nobody reads any more.
bool reader_has_left() {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&out, 1, 0) == 1 && (out.revents & (POLLERR | POLLHUP)) != 0;
}

/// Throws: InputError for a word that is no UTF-8. Names of files stand in records, provenances and messages,
/// which are UTF-8 all of them.
void check_is_text(int argc, char** argv) {
  for (int k = 1; k < argc; ++k) {
    const nlohmann::json word(argv[k]);
    const std::string shown = word.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    if (nlohmann::json::parse(shown) != word)
      throw InputError("word " + std::to_string(k) + " of the command line", 0, "UTF-8", shown);
  }
}

/// Who started this may have closed the standard files: the next file that is opened would be taken for one,
/// and messages be written into it.
void open_standard_files() {
  for (const int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(file, F_GETFD) == -1 && ::open("/dev/null", O_RDWR) < 0) return;
  }
}

int parse_and_run(CLI::App& app, int argc, char** argv, const int& exit_code) {
  try {
    app.parse(argc, argv);
    return exit_code;
  } catch (const CLI::Success& help) {  // --help, --version
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    return fail(explain(app, error), kBadInput);
  }
}

}  // namespace

int run_command_line(int argc, char** argv) {
  open_standard_files();
  std::signal(SIGPIPE, SIG_IGN);  // a reader that left early (palpate ... | head) is no failure
  std::signal(SIGXFSZ, SIG_IGN);  // a bound on the size of files is said, as a full disk is
  CLI::App app("Benchmark and validation harness for tetrahedral organ models", "palpate");
  app.set_version_flag("--version", version_text, "Print the version and exit");
  app.require_subcommand(1);
  set_plain_help(app);
  int exit_code = kDone;
  add_commands(app, exit_code);
  int code = kDone;
  try {
    check_is_text(argc, argv);
    check_command_names(app, argc, argv);
    code = parse_and_run(app, argc, argv, exit_code);
  } catch (const NoRoomError& error) {
    code = fail(error.what(), kCouldNotRun);
  } catch (const InputError& error) {
    code = fail(error.what(), kBadInput);
  } catch (const UnavailableError& error) {
    code = fail(error.what(), kCouldNotRun);
  } catch (const ContractError& error) {
    code = fail(std::string("a fault of its own: ") + error.what(), kCouldNotRun);
  } catch (const std::bad_alloc&) {
    code = fail("out of memory", kCouldNotRun);
  } catch (const std::exception& error) {
    code = fail(std::string("a fault of its own: ") + error.what(), kCouldNotRun);
  }
  std::cout.flush();
  if (!std::cout && !reader_has_left()) return fail("standard output cannot be written", kBadInput);
  return code;
}

}  // namespace palpate::experiments

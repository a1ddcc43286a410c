#include <algorithm>
#include <csignal>
#include <exception>
#include <iostream>
#include <new>

#include "core/base/error.h"
#include "experiments/commands.h"
#include "experiments/nearest_name.h"
#include "experiments/provenance.h"

namespace palpate::experiments {
namespace {

int fail(const std::string& message, int code) {
  print_note(message);
  return code;
}

std::string version_text() {
  const SourceVersion version = find_source_version();
  std::string text = std::string("palpate ") + PALPATE_VERSION;
  if (version.commit != "unknown") text += " (" + version.commit + (version.dirty ? ", changed)" : ")");
  return text;
}

void add_commands(CLI::App& app, int& exit_code) {
  add_run_command(app, exit_code);
  add_check_command(app, exit_code);
  add_gate_command(app, exit_code);
  add_list_command(app, exit_code);
  add_make_command(app, exit_code);
  add_mesh_command(app, exit_code);
  add_simplify_command(app, exit_code);
  add_quality_command(app, exit_code);
  add_test_command(app, exit_code);
}

/// Throws: InputError if the first word is no command.
void check_command_name(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  if (std::find(names.begin(), names.end(), argv[1]) == names.end()) {
    throw InputError("unknown command \"" + std::string(argv[1]) + "\"" + nearest_hint(argv[1], names));
  }
}

int parse_and_run(CLI::App& app, int argc, char** argv, const int& exit_code) {
  try {
    app.parse(argc, argv);
    return exit_code;
  } catch (const CLI::Success& help) {  // --help, --version
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    std::string message = error.what();
    for (std::size_t at = message.find('\n'); at != std::string::npos; at = message.find('\n'))
      message[at] = ' ';
    return fail(message + " (palpate --help shows what there is)", kBadInput);
  }
}

}  // namespace

void print_json(const nlohmann::json& value) {
  std::cout << value.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
}

void print_note(const std::string& line) {
  std::cerr << "palpate: " << line << '\n';
}

int run_command_line(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // a reader that left early (palpate ... | head) is no failure
  CLI::App app("Benchmark and validation harness for tetrahedral organ models", "palpate");
  app.set_version_flag("--version", version_text, "Print the version and exit");
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  int exit_code = kDone;
  add_commands(app, exit_code);
  int code = kDone;
  try {
    check_command_name(app, argc, argv);
    code = parse_and_run(app, argc, argv, exit_code);
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
  return code;
}

}  // namespace palpate::experiments

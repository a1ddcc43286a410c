// run, check, test.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iostream>
#include <memory>
#include <thread>

#include "core/base/error.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/contests/moving_task.h"
#include "experiments/files/places.h"
#include "experiments/files/plain_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/plan_reader/plan_report.h"
#include "experiments/processes/process.h"
#include "experiments/processes/report_script.h"
#include "experiments/processes/stop_signals.h"
#include "experiments/records/run_folder.h"
#include "experiments/rounds/case_choice.h"
#include "experiments/rounds/case_groups.h"
#include "experiments/runner/contest_table.h"
#include "experiments/runner/read_plan.h"
#include "experiments/runner/runner.h"
#include "experiments/scene_reader/scene_motion.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/text/terminal.h"
#include "experiments/text/yaml_schema.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

struct RunArguments {
  std::string plan;
  std::string out;
  std::string case_id;
  std::vector<std::string> only;
  std::string part;
  std::vector<std::string> take;
  int jobs = 1;
  bool resume = false;
  bool retry_failed = false;
  bool prepare = false;
  bool list_cases = false;
  bool no_report = false;
  int threads = 0;
};

fs::path choose_folder(const RunArguments& arguments, const Plan& plan) {
  if (!arguments.out.empty()) return arguments.out;
  const fs::path parent = results_folder(plan.name);
  return arguments.resume ? find_run(parent) : new_run_folder(parent);
}

/// Runs the report over a finished run and prints what it says. Returns kDone, kNotAccepted if something that
/// the plan requires does not hold, or kCouldNotRun.
int make_report(const fs::path& folder) {
  ProcessSpec spec = page_script("make_report.py", {folder.string()});
  spec.standard_output = folder / "report.txt";
  spec.standard_error = folder / "report_errors.txt";
  const ProcessResult result = run_process(spec);
  std::cout << read_bytes(spec.standard_output).value_or("");
  if (result.end == ProcessEnd::kExited && (result.exit_code == kDone || result.exit_code == kNotAccepted)) {
    std::error_code ignored;
    fs::remove(spec.standard_error, ignored);
    return result.exit_code;
  }
  const std::string why = last_line(spec.standard_error);
  print_note("the report failed (" + result.message + "): " + (why.empty() ? "it could not say why" : why));
  return kCouldNotRun;
}

void print_outcomes(const RunResult& result) {
  TextTable table({"contestant", "cases", "outcome"}, "lrl");
  for (const auto& [label, outcomes] : result.outcomes) {
    for (const auto& [outcome, count] : outcomes) {
      const Color color = outcome == "accepted" ? Color::kGreen : Color::kRed;
      table.add({label, std::to_string(count), colored(outcome, color)});
    }
  }
  std::cout << '\n' << table.text();
  std::size_t shown = 0;
  for (const auto& [id, failure] : result.failures) {
    if (++shown > 20) break;
    std::cout << "  " << id << ": " << failure << '\n';
  }
  if (result.failures.size() > 20) {
    std::cout << "  and " << result.failures.size() - 20 << " more in records.jsonl\n";
  }
}

bool is_all_timed(const Plan& plan, const std::vector<Case>& cases) {
  const std::vector<bool> timed = find_timed(plan, cases);
  return std::all_of(timed.begin(), timed.end(), [](bool is_timed) { return is_timed; });
}

int run(const RunArguments& arguments) {
  const fs::path file = find_plan(arguments.plan);
  const Registry registry = load_registry(read_contestant_folders(file));
  const Plan plan = read_plan(file, registry);
  const auto cases = build_cases(plan, registry);
  const auto chosen = choose_cases(plan, cases, {arguments.case_id, arguments.only, arguments.part});
  if (arguments.list_cases) {
    for (const std::size_t i : chosen) std::cout << cases[i].id << '\n';
    return kDone;
  }
  require_available(plan, registry);
  for (const std::string& note : plan.notes) print_note(note);
  RunOptions options;
  options.stop_flag = catch_stop_signals();
  options.folder = choose_folder(arguments, plan);
  options.resume = arguments.resume;
  std::error_code error;
  if (options.resume && !fs::exists(options.folder, error))
    print_note(options.folder.string() + ": there is no run yet to go on with: it starts anew");
  options.retry_failed = arguments.retry_failed;
  options.case_id = arguments.case_id;
  options.only = arguments.only;
  options.part = arguments.part;
  options.prepare_only = arguments.prepare;
  options.take.assign(arguments.take.begin(), arguments.take.end());
  options.jobs = arguments.jobs;
  if (options.jobs > 1 && is_all_timed(plan, cases))
    print_note(
        "--jobs has nothing to do: the plan is timed, and timed cases run alone (run: {timed: false})");
  if (arguments.threads > 0) options.threads = arguments.threads;
  Progress progress;
  const RunResult result = run_plan(plan, registry, options, progress);
  if (result.interrupted) {
    progress.say("interrupted; what is finished is kept, go on with: palpate run " + arguments.plan +
                 " --out " + options.folder.string() + " --resume");
    return kInterrupted;
  }
  if (arguments.prepare) {
    progress.say("inputs are made; nothing was run");
    return kDone;
  }
  if (!arguments.part.empty()) {
    progress.say("part " + options.folder.string() + (result.is_whole ? ": whole" : ": repeats are missing"));
    return result.is_whole ? kDone : kCouldNotRun;
  }
  progress.show("report");
  if (arguments.no_report && requires_report(plan.file))
    print_note("without a report, nobody looks at what the plan requires (required: true)");
  const int reported = arguments.no_report ? kDone : make_report(options.folder);
  progress.say("done");
  print_outcomes(result);
  if (chosen.size() < cases.size())
    std::cout << chosen.size() << " of the plan's " << cases.size()
              << " cases; --resume without --only and --case runs the rest\n";
  std::cout << "Run: " << options.folder.string() << '\n';
  if (!arguments.no_report && fs::exists(options.folder / "report.html"))
    std::cout << "Page: " << (options.folder / "report.html").string() << '\n';
  if (result.required_failed || reported == kCouldNotRun) return kCouldNotRun;
  return result.required_rejected ? kNotAccepted : reported;
}

/// Whether a file says that it is a scene; anything else is read as a plan.
bool is_scene(const std::string& file) {
  const YamlValue root = read_yaml(file);
  const auto entries = root.is_map() ? root.entries() : std::vector<std::pair<std::string, YamlValue>>{};
  const bool has_schema =
      std::any_of(entries.begin(), entries.end(), [](const auto& entry) { return entry.first == "schema"; });
  if (!entries.empty() && !has_schema)
    root.fail("the key \"schema\" is missing: expected palpate/plan/1 or palpate/scene/1");
  return find_schema(root).starts_with("palpate/scene/");
}

/// Reads the scene and puts it on its mesh, which finds the regions that take hold of nothing.
void check_scene(const std::string& file, const Registry& registry) {
  const Scene scene = read_scene(file);
  const MadeMesh made = build_scene_mesh(scene.mesh);
  if (!scene.mesh.shape) {
    for (const std::string& note : made.notes) print_note(file + ": " + note);
  } else if (const std::string odd = size_complaint(scene.mesh, made.mesh); !odd.empty()) {
    print_note(file + ": " + odd);
  }
  const Scene placed = place_scene(scene, made.mesh);
  if (scene.is_dynamic) {
    for (const std::string& useless : check_moving_scene(placed, made.mesh)) print_note(useless);
    const ScratchFolder scratch;
    ContestantTask task = start_replay(build_moving_body(placed, made.mesh, registry), made.mesh, registry,
                                       scratch.file("body"));
    task.options["setup_only"] = true;
    run_moving_task(task, scene.analysis_where);
  } else {
    build_problem(placed, made.mesh);
  }
  if (scene.model) resolve_options(*find_model(scene, registry).method, scene.model->set);
  try {
    if (placed.require) find_error_points(*placed.require, made.mesh);
  } catch (const InputError& error) {
    print_note(std::string(error.what()) + ": palpate fit refuses it");
  }
  std::cout << file << ": good, a " << (scene.is_dynamic ? "dynamic" : "static") << " scene of "
            << made.mesh.points.size() << " vertices\n";
}

int check(const std::vector<std::string>& files) {
  const Registry registry = load_registry();
  int code = kDone;
  for (const std::string& given : files) {
    try {
      const std::string file = find_plan(given).string();  // a scene is given by its path
      if (is_scene(file)) {
        check_scene(file, registry);
        continue;
      }
      const Registry known = load_registry(read_contestant_folders(file));
      const Plan plan = read_plan(file, known);
      const std::vector<Case> cases = build_cases(plan, known);
      int runs = 0;
      int most = 0;
      for (const Case& c : cases) runs += plan.run.warmup + repeats_of(plan.run, c);
      for (const Case& c : cases) most += plan.run.warmup + most_repeats_of(plan.run, c);
      std::cout << given << ": good, " << cases.size() << " cases, " << runs
                << (most > runs ? " to " + std::to_string(most) : "") << " runs\n";
      for (const std::string& note : plan.notes) std::cout << given << ": note: " << note << '\n';
    } catch (const InputError& error) {
      print_note(error.what());
      code = kBadInput;
    }
  }
  return code;
}

/// Refuses a long option that ctest does not have: it would pass over it in silence, and run everything.
void require_options_of_ctest(const std::vector<std::string>& words) {
  const auto is_long = [](const std::string& word) { return word.size() > 2 && word.rfind("--", 0) == 0; };
  if (std::none_of(words.begin(), words.end(), is_long)) return;
  const ScratchFolder folder;
  ProcessSpec spec;
  spec.arguments = {"/usr/bin/env", "ctest", "--help"};
  spec.standard_output = folder.file("help.txt");
  run_process(spec);
  const std::string help = read_bytes(spec.standard_output).value_or("");
  if (help.empty()) return;  // there is no ctest: said where it is started
  const auto is_listed = [&](const std::string& word) {
    const std::size_t length = std::min(word.size(), word.find('='));
    const std::string name = word.substr(0, length);
    for (std::size_t at = help.find(name); at != std::string::npos; at = help.find(name, at + 1)) {
      const std::string behind = help.substr(at + length, 2);
      const bool takes = behind.rfind('=', 0) == 0 || behind == "[=";
      if (length < word.size() ? takes : behind.find_first_of(" ,\n=[") == 0) return true;
    }
    return false;
  };
  for (const std::string& word : words) {
    if (is_long(word) && !is_listed(word)) {
      throw InputError("test: ctest has no option \"" + word +
                       "\"; ctest --help has those that there are, and -N lists the tests");
    }
  }
}

/// Runs ctest on the build that this program comes from, with its output passed through. `full` takes nothing
/// as known.
int test(bool full, const std::vector<std::string>& extra) {
  if (install_prefix()) throw UnavailableError("the tests run in the sources; an installed palpate has none");
  require_options_of_ctest(extra);
  const fs::path build = fs::path(program_folder()).parent_path();
  std::vector<std::string> arguments{"ctest",
                                     "--test-dir",
                                     build.string(),
                                     "--output-on-failure",
                                     "--no-tests=error",
                                     "--parallel",
                                     std::to_string(std::max(1U, std::thread::hardware_concurrency()))};
  if (full) {
    ::setenv("PALPATE_FULL", "1", 1);
  } else {
    arguments.insert(arguments.end(), {"--label-exclude", "full"});
  }
  arguments.insert(arguments.end(), extra.begin(), extra.end());
  std::vector<char*> pointers;
  pointers.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  std::cout.flush();
  const pid_t child = ::fork();
  if (child < 0) throw UnavailableError(std::string("cannot start ctest: ") + std::strerror(errno));
  if (child == 0) {
    ::execvp(pointers[0], pointers.data());
    ::_exit(127);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) {
    throw UnavailableError("cannot start ctest (the package cmake has it)");
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? kDone : kNotAccepted;
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "Run a plan: contestants, judge, records, report");
  command
      ->add_option("PLAN", arguments->plan, "Plan file (.yaml), or the bare name of one in experiments/plans")
      ->required();
  command->add_option("--out", arguments->out, "Run folder (default: results/<plan>/<time>-<commit>)")
      ->type_name("DIR");
  command
      ->add_option("--case", arguments->case_id,
                   "Only this case, or those that start so (kidney/hierarchical)")
      ->type_name("ID");
  command
      ->add_option("--only", arguments->only,
                   "Only cases of this mesh, scene, label or tag, or whose id fits a pattern\n"
                   "('kidney/*=0.5'); repeatable: what any of them fits")
      ->allow_extra_args(false)
      ->type_name("PATTERN");
  CLI::Option* resume = command->add_flag("--resume", arguments->resume,
                                          "Go on with the run in --out (default: the plan's newest)");
  command
      ->add_flag("--retry-failed", arguments->retry_failed,
                 "With --resume: run repeats anew that gave nothing to judge (crashed, timed\n"
                 "out, ...); their records move to retried.jsonl")
      ->needs(resume);
  command
      ->add_option("--jobs", arguments->jobs,
                   "Run cases that are not timed (timed: false) so many at a time, and make the\n"
                   "inputs of a plan of scenes that takes no times; timed ones run alone,\n"
                   "whatever this says")
      ->transform(whole_number_from(1, 1024))
      ->type_name("N");
  command
      ->add_option("--part", arguments->part,
                   "Only the cases that a file names, one a line: a part of a run that another\n"
                   "one takes. No report; exit code 0 once every repeat has its record")
      ->type_name("FILE");
  command
      ->add_option("--take", arguments->take,
                   "Take the repeats that another run of this plan has, and run those that none\n"
                   "has; repeatable. Of other kinds of nodes they come without times")
      ->type_name("DIR");
  command->add_option("--threads", arguments->threads, "Threads a contestant, in place of the plan's")
      ->transform(whole_number_from(1, 1024))
      ->type_name("N");
  command->add_flag("--prepare", arguments->prepare,
                    "Make meshes, references and trained springs, and run nothing: parts that start\n"
                    "together then find them in the cache");
  command->add_flag("--list-cases", arguments->list_cases, "Print the cases and run nothing");
  command->add_flag("--no-report", arguments->no_report, "Leave tables, charts and page out");
  command->footer(
      "Exit codes: 0 done and accepted; 1 a required answer was rejected, or a comparison, a target or\n"
      "the claim with required: true does not hold (the report's last lines say which); 3 a required case\n"
      "or the report could not run; 130 interrupted.");
  command->callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

void add_check_command(CLI::App& app, int& exit_code) {
  auto files = std::make_shared<std::vector<std::string>>();
  CLI::App* command = app.add_subcommand("check", "Validate plans and scenes, run nothing");
  command->add_option("FILE", *files, "Plan and scene files; plans by their bare names too")->required();
  command->callback([files, &exit_code] { exit_code = check(*files); });
}

void add_test_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("test", "Run the project's tests");
  auto full = std::make_shared<bool>(false);
  command->add_flag("--full", *full, "Hold every source against every tool, as if none had passed before");
  command->footer("Anything else goes to ctest: palpate test -R runner");
  command->prefix_command();
  command->callback([command, full, &exit_code] { exit_code = test(*full, command->remaining()); });
}

}  // namespace palpate::experiments

#include "experiments/runner/runner.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "experiments/files/file_hash.h"
#include "experiments/records/provenance.h"
#include "experiments/records/record_file.h"
#include "experiments/records/run_folder.h"
#include "experiments/records/set_aside.h"
#include "experiments/records/untimed.h"
#include "experiments/rounds/case_choice.h"
#include "experiments/rounds/case_groups.h"
#include "experiments/rounds/case_ledger.h"
#include "experiments/rounds/rest_time.h"
#include "experiments/rounds/round_order.h"
#include "experiments/runner/contest_table.h"
#include "experiments/runner/repeat_run.h"
#include "experiments/runner/side_by_side.h"
#include "experiments/runner/taken_parts.h"
#include "experiments/spring_training/trained_springs.h"
#include "reference/door/contest_files.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

/// So many more parts than jobs, that none waits long for the last.
constexpr std::size_t kPartsAJob = 4;

class Runner {
 public:
  Runner(const Plan& plan, const Registry& registry, const RunOptions& options, Progress& progress)
      : plan_(plan),
        registry_(registry),
        options_(options),
        progress_(progress),
        threads_(options.threads.value_or(plan.run.threads)),
        folder_(options.folder, options.resume),
        cases_(build_cases(plan, registry)),
        timed_(find_timed(plan, cases_)),
        ledger_(plan, cases_),
        choice_{options.case_id, options.only, options.part},
        selected_(choose_cases(plan, cases_, choice_)) {
    contest_ = make_contest({plan_, registry_, folder_, threads_, options.stop_flag, progress_});
  }

  RunResult run() {
    try {
      prepare();
    } catch (const RunInterrupted&) {
      result_.interrupted = true;
      return result_;
    }
    if (options_.prepare_only) {
      result_.interrupted = !train_springs() || !contest_->record_inputs({}, [](const json&) {});
      return result_;
    }
    if (options_.retry_failed) set_failures_aside();
    RecordFile records(folder_.paths().records());
    ledger_.load(folder_.paths().records());
    take_parts(records);
    result_.interrupted = !train_springs();
    if (!result_.interrupted) record_inputs(records);
    if (!result_.interrupted && options_.jobs > 1) run_parts(records);
    if (!result_.interrupted) run_rounds(records);
    ledger_.state_repeats(provenance_);
    write_provenance();
    summarise();
    return result_;
  }

 private:
  const PlanContestant& contestant_of(const Case& c) const { return plan_.contestants[c.contestant]; }

  /// Fills the cache with the inputs of several scenes side by side, before they are taken from there one
  /// after the other. Only those of a new run of all cases that takes no times: what a simplifier took is
  /// one. Throws: RunInterrupted.
  void prepare_beside() {
    const bool is_timed = std::find(timed_.begin(), timed_.end(), true) != timed_.end();
    if (options_.jobs < 2 || plan_.scenes.size() < 2 || is_timed || !choice_.is_all() ||
        options_.prepare_only)
      return;
    progress_.say("inputs of " + std::to_string(plan_.scenes.size()) + " scenes, " +
                  std::to_string(options_.jobs) + " at a time");
    const fs::path place = fs::absolute(folder_.fresh_scratch());
    const SideBySide setting{plan_.file, place, threads_, options_.jobs, options_.stop_flag};
    if (!prepare_side_by_side(plan_.subjects, setting)) throw RunInterrupted();
  }

  /// Plan, inputs and provenance: made, or taken up and compared.
  void prepare() {
    const json now = build_provenance(plan_, registry_, threads_);
    node_ = node_kind(now);
    const auto then = folder_.earlier_provenance();
    if (then) {
      std::string changes;
      for (const std::string& change : find_changes(moved_here(*then, now), now)) changes += "; " + change;
      if (!changes.empty()) {
        throw InputError(options_.folder.string() + ": this run cannot be continued" + changes);
      }
    } else {
      std::error_code error;
      fs::copy_file(plan_.file, folder_.paths().plan(), fs::copy_options::overwrite_existing, error);
      if (error)
        throw InputError(folder_.paths().plan().string(), 0, "a file that can be written", error.message());
    }
    progress_.say("run " + options_.folder.string());
    if (!then) prepare_beside();
    std::vector<const Case*> wanted;
    for (const std::size_t index : selected_) wanted.push_back(&cases_[index]);
    json known = then.value_or(now);
    known.update(contest_->prepare(wanted, then.value_or(json())));
    known["cases"] = json::array();  // all of them: what is missing from the records can be told
    for (const Case& c : cases_) known["cases"].push_back(c.id);
    ledger_.state_repeats(known);
    if (!known.contains("sittings")) known["sittings"] = json::array();
    sitting_ = known["sittings"].size();
    known["sittings"].push_back(describe_sitting(now));
    const json chosen = describe_choice(choice_);
    if (!chosen.is_null()) known["sittings"].back()["chosen"] = chosen;
    provenance_ = std::move(known);
    write_provenance();
  }

  void write_provenance() const {
    write_file_atomically(folder_.paths().provenance(), provenance_.dump(2) + "\n");
  }

  /// Trains what the plan's contestants take (`train`), or takes it from the cache; the provenance keeps the
  /// report. Returns false if it was interrupted.
  bool train_springs() {
    std::map<std::size_t, TrainedSprings> trained;
    try {
      for (const std::size_t index : selected_) {
        const std::size_t who = cases_[index].contestant;
        const PlanContestant& contestant = plan_.contestants[who];
        if (contestant.train.empty() || trained.count(who) > 0) continue;
        progress_.say("training " + contestant.label + " by " + contestant.train.filename().string());
        trained[who] = train_cached(contestant.train, {registry_, fs::absolute(folder_.fresh_scratch()),
                                                       progress_, threads_, options_.stop_flag});
      }
    } catch (const RunInterrupted&) {
      return false;
    }
    if (trained.empty()) return true;
    for (Case& c : cases_) {
      const auto own = trained.find(c.contestant);
      if (own == trained.end()) continue;
      c.options["springs"] = own->second.springs.string();
      c.options["moduli"] = own->second.moduli.string();
    }
    for (const auto& [who, springs] : trained)
      provenance_["trained"][plan_.contestants[who].label] = {{"springs_hash", hash_file(springs.springs)},
                                                              {"report", springs.report}};
    write_provenance();
    return true;
  }

  /// Repeats of selected cases and inputs without an answer to judge are to be run anew.
  void set_failures_aside() {
    std::set<std::string> chosen;
    std::set<std::string> all;
    for (const std::size_t index : selected_) chosen.insert(cases_[index].id);
    for (const Case& c : cases_) all.insert(c.id);
    const auto is_taken = [&](const json& record) {
      const std::string id = record.at("case").get<std::string>();
      return is_failure(record) && (chosen.count(id) > 0 || all.count(id) == 0);
    };
    const RunPaths& paths = folder_.paths();
    const std::size_t taken = set_aside(paths.records(), paths.retried(), is_taken);
    progress_.say(std::to_string(taken) + " failed repeats are run anew");
    provenance_["sittings"].back()["retried"] = taken;
    write_provenance();
  }

  /// Takes repeats from folders of other runs: those of the options, and what a run side by side left here.
  void take_parts(RecordFile& records) {
    const std::vector<fs::path> left = list_parts(folder_.paths().parts());
    if (options_.take.empty() && left.empty()) {
      fs::remove_all(folder_.paths().parts());  // half ones of a start that was killed
      return;
    }
    PartTaker taker = make_taker();
    for (const fs::path& given : options_.take) {
      for (const fs::path& part : find_parts(given)) take(taker, part, records);
    }
    for (const fs::path& part : left) take(taker, part, records);
    fs::remove_all(folder_.paths().parts());
    ledger_.load(folder_.paths().records());
  }

  PartTaker make_taker() {
    std::map<std::string, fs::path> kept;
    for (const Case& c : cases_) kept[c.id] = contest_->kept_output(c);
    return {folder_.paths(), std::move(kept), reference::contest_files(plan_.contest).beside_file,
            provenance_, [this] { write_provenance(); }};
  }

  void take(PartTaker& taker, const fs::path& part, RecordFile& records) {
    result_.records_added += taker.take(part, records);
  }

  /// Runs cases that are not timed, and need none that is, side by side.
  void run_parts(RecordFile& records) {
    const std::vector<bool> free = find_free(cases_, timed_);
    std::vector<bool> due(cases_.size(), false);
    for (const std::size_t index : selected_) due[index] = free[index] && ledger_.has_due(index);
    const auto parts = split_cases(cases_, due, kPartsAJob * static_cast<std::size_t>(options_.jobs));
    if (parts.empty()) return;
    const SideBySide setting{plan_.file, folder_.paths().parts(), threads_, options_.jobs,
                             options_.stop_flag};
    PartTaker taker = make_taker();
    progress_.start(parts.size());
    std::size_t done = 0;
    result_.interrupted = !run_side_by_side(parts, setting, [&](const fs::path& part) {
      take(taker, part, records);
      progress_.reach(++done, -1.0);
    });
    fs::remove_all(folder_.paths().parts());
    ledger_.load(folder_.paths().records());
  }

  void record_inputs(RecordFile& records) {
    const bool finished = contest_->record_inputs(ledger_.recorded_inputs(), [&](json record) {
      record["sitting"] = sitting_;
      records.append(record);
      ledger_.note_input(record);
      ++result_.records_added;
    });
    result_.interrupted = !finished;
  }

  void run_rounds(RecordFile& records) {
    rounds_clock_ = Stopwatch();
    RestTime rest;
    for (const std::size_t index : selected_) rest.add(ledger_.count_due(index), ledger_.state(index).wall_s);
    progress_.start(rest.repeats());
    for (int repeat = 0; repeat < ledger_.rounds() && !result_.interrupted; ++repeat) {
      run_round(repeat, records, rest);
      if (!result_.interrupted) halve(repeat + 1 - plan_.run.warmup, rest);
    }
    if (left_out_ > 0)
      progress_.say("halving: " + std::to_string(left_out_) +
                    " repeats of cases that cannot be on the frontier " +
                    "were left out (repeats_ended in provenance.json)");
  }

  /// At the end of a rung, cases that cannot be on the frontier any more get no more repeats.
  void halve(int measured, RestTime& rest) {
    for (const auto& [index, due] : ledger_.halve(measured, selected_)) {
      rest.remove(due, ledger_.state(index).wall_s);
      left_out_ += due;
    }
  }

  /// One repeat of every selected case that is due, in the order of its round.
  void run_round(int repeat, RecordFile& records, RestTime& rest) {
    const std::set<std::size_t> selected(selected_.begin(), selected_.end());
    std::vector<std::size_t> order =
        order_round(cases_, static_cast<std::uint64_t>(plan_.run.order_seed), repeat);
    std::vector<std::size_t> position(cases_.size());  // among all cases, selected or not
    for (std::size_t place = 0; place < order.size(); ++place) position[order[place]] = place;
    std::erase_if(order, [&](std::size_t index) { return selected.count(index) == 0; });
    for (const std::size_t index : order) {
      if (!ledger_.is_due(index, repeat)) continue;
      if (options_.stop_flag != nullptr && *options_.stop_flag != 0) result_.interrupted = true;
      if (result_.interrupted) return;
      progress_.show(cases_[index].id);
      auto record = run_due(index, repeat);
      if (!record) return;
      (*record)["position"] = position[index];
      records.append(*record);
      ++result_.records_added;
      rest.remove(ledger_.count_due(index), ledger_.state(index).wall_s);
      ledger_.remember(index, *record);
      rest.add(ledger_.count_due(index), ledger_.state(index).wall_s);
      progress_.step(rest.seconds(rounds_clock_.seconds() / static_cast<double>(++repeats_run_)));
    }
  }

  /// The stop with tets_of resolved; nothing if the case that it needs left no mesh.
  std::optional<Stop> resolve_stop(const Case& c) const {
    if (!c.tets_of) return c.stop;
    const auto& tets = ledger_.state(*c.tets_of).tets;
    return tets ? std::optional(Stop{StopKind::kTets, *tets, c.stop.of}) : std::nullopt;
  }

  /// The case with its stop's at_its_distance resolved; the same if there is none, or nothing to take it
  /// from.
  Case resolve_bound(const Case& c) const {
    Case resolved = c;
    if (!c.stop.at_its_distance || !ledger_.state(*c.tets_of).distance) return resolved;
    const double unit_m = c.options.at(kUnitOfDistance).get<double>();
    resolved.options[kBoundOfDistance] = unit_m * *ledger_.state(*c.tets_of).distance;
    return resolved;
  }

  /// Runs one repeat. Nothing comes back if it was interrupted.
  std::optional<json> run_due(std::size_t index, int repeat) {
    const Case c = resolve_bound(cases_[index]);
    RepeatTask task{c, repeat, ledger_.state(index), resolve_stop(c), ""};
    if (!task.stop) task.not_run = "needs the tets of " + cases_[*c.tets_of].id + ", which left no mesh";
    if (task.stop && c.stop.at_its_distance && !ledger_.state(*c.tets_of).distance)
      task.not_run = "needs the distance that " + cases_[*c.tets_of].id + " strays, which has none";
    auto record =
        run_repeat({plan_, registry_, folder_, *contest_, threads_, options_.stop_flag}, std::move(task));
    if (!record) {
      result_.interrupted = true;
      return record;
    }
    (*record)["sitting"] = sitting_;
    if (!timed_[index]) drop_times(*record, "the plan says that it is not timed");
    if (node_kind(provenance_) != node_)
      drop_times(*record, "timed on another kind of node than the repeats that were taken from elsewhere");
    return record;
  }

  void summarise() {
    result_.is_whole = !result_.interrupted;
    for (const std::size_t index : selected_) {
      const Case& c = cases_[index];
      const PlanContestant& contestant = contestant_of(c);
      result_.is_whole = result_.is_whole && !ledger_.has_due(index);
      const CaseState& state = ledger_.state(index);
      if (!state.first_failure.empty()) result_.failures[c.id] = state.first_failure;
      const std::string worst = state.worst.empty() ? "not run" : state.worst;
      ++result_.outcomes[contestant.label][worst];
      if (!contestant.required) continue;
      result_.required_rejected = result_.required_rejected || worst == "rejected";
      result_.required_failed = result_.required_failed || (worst != "accepted" && worst != "rejected");
    }
    for (const auto& [id, failure] : ledger_.failed_inputs()) {
      result_.required_rejected = true;
      result_.failures[id] = failure;
    }
  }

  const Plan& plan_;
  const Registry& registry_;
  const RunOptions& options_;
  Progress& progress_;
  int threads_;
  RunFolder folder_;
  std::vector<Case> cases_;
  std::vector<bool> timed_;  ///< by case
  CaseLedger ledger_;
  int left_out_ = 0;        ///< repeats, by halving
  Stopwatch rounds_clock_;  ///< since the first repeat of this sitting
  std::size_t repeats_run_ = 0;
  CaseChoice choice_;
  std::vector<std::size_t> selected_;
  std::unique_ptr<Contest> contest_;
  json provenance_;
  json node_;                ///< this machine, as times name it
  std::size_t sitting_ = 0;  ///< which of the run's starts and resumptions this is
  RunResult result_;
};

}  // namespace

RunResult run_plan(const Plan& plan, const Registry& registry, const RunOptions& options,
                   Progress& progress) {
  require_available(plan, registry);
  for (const fs::path& given : options.take) check_parts(given);  // before a folder is made
  Runner runner(plan, registry, options, progress);
  return runner.run();
}

}  // namespace palpate::experiments

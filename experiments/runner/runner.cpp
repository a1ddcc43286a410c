#include "experiments/runner/runner.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/files/file_hash.h"
#include "experiments/records/case_record.h"
#include "experiments/records/provenance.h"
#include "experiments/records/record_file.h"
#include "experiments/records/run_folder.h"
#include "experiments/runner/contest_table.h"
#include "experiments/spring_training/trained_springs.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

/// What earlier repeats of a case left.
struct CaseState {
  std::set<int> done;
  std::vector<json> records;
  double wall_s = -1.0;

  bool is_closed() const {
    return std::any_of(records.begin(), records.end(), [](const json& record) {
      const json& outcome = record.at("outcome");
      return outcome == "timed_out" || outcome == "bad_input" || outcome == "unavailable" ||
             outcome == "not_judged";
    });
  }
};

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
        states_(cases_.size()),
        selected_(cases_.size()) {
    contest_ = make_contest({plan_, registry_, folder_, threads_, options.stop_flag, progress_});
    std::iota(selected_.begin(), selected_.end(), std::size_t{0});
    if (!options.case_id.empty()) selected_ = select_cases(cases_, options.case_id);
  }

  RunResult run() {
    prepare();
    RecordFile records(folder_.paths().records());
    load_records();
    result_.interrupted = !train_springs();
    if (!result_.interrupted) record_inputs(records);
    if (!result_.interrupted) run_rounds(records);
    summarise();
    return result_;
  }

 private:
  const PlanContestant& contestant_of(const Case& c) const { return plan_.contestants[c.contestant]; }
  /// Repeats of a case, with its warm-up.
  int rounds_of(const Case& c) const { return plan_.run.warmup + repeats_of(plan_.run, c); }
  int rounds() const {
    int most = 0;
    for (const Case& c : cases_) most = std::max(most, rounds_of(c));
    return most;
  }

  /// Plan, inputs and provenance: made, or taken up and compared.
  void prepare() {
    const json now = build_provenance(plan_, registry_, threads_);
    const auto then = folder_.earlier_provenance();
    if (then) {
      std::string changes;
      for (const std::string& change : find_changes(*then, now)) changes += "; " + change;
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
    std::vector<const Case*> wanted;
    for (const std::size_t index : selected_) wanted.push_back(&cases_[index]);
    json known = then.value_or(now);
    known.update(contest_->prepare(wanted, then.value_or(json())));
    known["cases"] = json::array();        // all of them: what is missing from the records can be told
    known["repeats_of"] = json::object();  // cases that have another number of them
    for (const Case& c : cases_) {
      known["cases"].push_back(c.id);
      const int own = repeats_of(plan_.run, c);
      if (own != plan_.run.repeats) known["repeats_of"][c.id] = own;
    }
    if (!known.contains("sittings")) known["sittings"] = json::array();
    sitting_ = known["sittings"].size();
    known["sittings"].push_back(describe_sitting(now));
    write_file_atomically(folder_.paths().provenance(), known.dump(2) + "\n");
    provenance_ = std::move(known);
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
    } catch (const TrainingInterrupted&) {
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
    write_file_atomically(folder_.paths().provenance(), provenance_.dump(2) + "\n");
    return true;
  }

  void load_records() {
    std::map<std::string, std::size_t> index;
    for (std::size_t i = 0; i < cases_.size(); ++i) index[cases_[i].id] = i;
    for (json& record : read_records(folder_.paths().records())) {
      const std::string id = record.at("case").get<std::string>();
      const auto found = index.find(id);
      if (found != index.end()) remember(found->second, std::move(record));
      recorded_inputs_.insert(id);
    }
  }

  void remember(std::size_t index, json record) {
    CaseState& state = states_[index];
    state.done.insert(record.at("repeat").get<int>());
    if (record.value("wall_s", json()).is_number()) state.wall_s = record.at("wall_s").get<double>();
    state.records.push_back(std::move(record));
  }

  void record_inputs(RecordFile& records) {
    const bool finished = contest_->record_inputs(recorded_inputs_, [&](json record) {
      record["sitting"] = sitting_;
      records.append(record);
      ++result_.records_added;
    });
    result_.interrupted = !finished;
  }

  bool is_due(std::size_t index, int repeat) const {
    return repeat < rounds_of(cases_[index]) && states_[index].done.count(repeat) == 0 &&
           !states_[index].is_closed();
  }

  double seconds_left(int round, std::size_t place) const {
    double known = 0.0;
    std::size_t count = 0;
    for (const CaseState& state : states_) {
      if (state.wall_s < 0.0) continue;
      known += state.wall_s;
      ++count;
    }
    const double typical = count > 0 ? known / static_cast<double>(count) : 0.0;
    double left = 0.0;
    for (int r = round; r < rounds(); ++r) {
      for (std::size_t i = r == round ? place : 0; i < selected_.size(); ++i) {
        const CaseState& state = states_[selected_[i]];
        if (is_due(selected_[i], r)) left += state.wall_s >= 0.0 ? state.wall_s : typical;
      }
    }
    return left;
  }

  void run_rounds(RecordFile& records) {
    std::size_t due = 0;
    for (int repeat = 0; repeat < rounds(); ++repeat) {
      for (const std::size_t index : selected_) due += is_due(index, repeat) ? 1 : 0;
    }
    progress_.start(due);
    for (int repeat = 0; repeat < rounds(); ++repeat) {
      for (std::size_t place = 0; place < selected_.size(); ++place) {
        const std::size_t index = selected_[place];
        if (!is_due(index, repeat)) continue;
        if (options_.stop_flag != nullptr && *options_.stop_flag != 0) result_.interrupted = true;
        if (result_.interrupted) return;
        progress_.show(cases_[index].id);
        auto record = run_repeat(index, repeat);
        if (!record) return;
        records.append(*record);
        ++result_.records_added;
        remember(index, *std::move(record));
        progress_.step(seconds_left(repeat, place + 1));
      }
    }
  }

  /// The stop with tets_of resolved; nothing if the case that it needs left no mesh.
  std::optional<Stop> resolve_stop(const Case& c) const {
    if (!c.tets_of) return c.stop;
    for (const json& record : states_[*c.tets_of].records) {
      const json& judgement = record.value("judge", json());
      if (!judgement.is_object() || !judgement.value("tets", json()).is_number()) continue;
      return Stop{StopKind::kTets, judgement.at("tets").get<double>(), c.stop.of};
    }
    return std::nullopt;
  }

  /// The parameters that an earlier repeat of the case searched for; {} if there are none.
  json tuned_of(std::size_t index) const {
    for (const json& record : states_[index].records) {
      json tuned = record.value("tuned", json::object());
      if (!tuned.empty()) return tuned;
    }
    return json::object();
  }

  /// Runs one repeat. Nothing comes back if it was interrupted.
  std::optional<json> run_repeat(std::size_t index, int repeat) {
    const Case& c = cases_[index];
    const PlanContestant& contestant = contestant_of(c);
    const auto stop = resolve_stop(c);
    ContestantTask task;
    ContestantAnswer answer;
    answer.outcome = "error";
    if (!stop) {
      answer.message = "needs the tets of " + cases_[*c.tets_of].id + ", which left no mesh";
    } else {
      task.options = c.options;
      answer.message = contest_->fill_task(c, task);
    }
    if (answer.message.empty()) {
      task.method = *registry_.find(contestant.method);
      task.scratch = fs::absolute(folder_.fresh_scratch());
      task.stop = *stop;
      task.keep = contestant.keep;
      task.tuned = tuned_of(index);
      task.threads = threads_;
      task.timeout_s = plan_.run.timeout_s;
      task.memory_mib = plan_.run.memory_mib;
      task.stop_flag = options_.stop_flag;
      answer = run_contestant(task);
    }
    if (answer.outcome == "interrupted") {
      result_.interrupted = true;
      return std::nullopt;
    }
    RepeatFacts facts{plan_, c, contestant, stop.value_or(c.stop), repeat, repeat < plan_.run.warmup};
    facts.deterministic = registry_.find(contestant.method)->method->deterministic;
    facts.judge_bounds = judge_bounds(plan_, options_.stop_flag);
    json record = contest_->build_record(facts, answer, states_[index].records);
    if (record.at("outcome") == "interrupted") {
      result_.interrupted = true;
      return std::nullopt;
    }
    record["sitting"] = sitting_;
    add_file_hashes(*registry_.find(contestant.method)->method, c, record);
    keep_output(c, repeat, answer, record);
    return record;
  }

  /// A changed file is another case, whatever its name.
  static void add_file_hashes(const MethodSpec& method, const Case& c, json& record) {
    for (const OptionSpec& option : method.options) {
      if (option.type != OptionType::kFile) continue;
      const std::string file = c.options.at(option.name).get<std::string>();
      std::error_code error;
      if (!file.empty() && fs::is_regular_file(file, error)) record["files"][option.name] = hash_file(file);
    }
  }

  void keep_output(const Case& c, int repeat, const ContestantAnswer& answer, json& record) {
    const fs::path kept = contest_->kept_output(c);
    if (repeat == 0 && record.at("output_hash").is_string()) {
      std::error_code error;
      fs::create_directories(kept.parent_path(), error);
      fs::rename(answer.output, kept, error);
      if (error) throw InputError(kept.string(), 0, "a file that can be written", error.message());
    }
    record["mesh_file"] = fs::exists(kept) ? json(kept.lexically_relative(options_.folder).string()) : json();
  }

  void summarise() {
    for (const std::size_t index : selected_) {
      const Case& c = cases_[index];
      const PlanContestant& contestant = contestant_of(c);
      std::string worst;
      for (const json& record : states_[index].records) {
        const std::string outcome = record.at("outcome").get<std::string>();
        if (worst.empty()) worst = outcome;
        if (outcome == "accepted") continue;
        worst = outcome;
        if (result_.failures.count(c.id) == 0) result_.failures[c.id] = outcome + ": " + reason_of(record);
      }
      if (worst.empty()) worst = "not run";
      ++result_.outcomes[contestant.label][worst];
      if (!contestant.required) continue;
      result_.required_rejected = result_.required_rejected || worst == "rejected";
      result_.required_failed = result_.required_failed || (worst != "accepted" && worst != "rejected");
    }
    for (const json& record : read_records(folder_.paths().records())) {
      const bool is_input = record.at("contestant").is_null();
      if (!is_input || record.at("outcome") == "accepted") continue;
      const std::string id = record.at("case").get<std::string>();
      result_.required_rejected = true;
      result_.failures[id] = record.at("outcome").get<std::string>() + ": " + reason_of(record);
    }
  }

  const Plan& plan_;
  const Registry& registry_;
  const RunOptions& options_;
  Progress& progress_;
  int threads_;
  RunFolder folder_;
  std::vector<Case> cases_;
  std::vector<CaseState> states_;
  std::vector<std::size_t> selected_;
  std::unique_ptr<Contest> contest_;
  std::set<std::string> recorded_inputs_;
  json provenance_;
  std::size_t sitting_ = 0;  ///< which of the run's starts and resumptions this is
  RunResult result_;
};

}  // namespace

void require_available(const Plan& plan, const Registry& registry) {
  const auto need_method = [&](const std::string& label, const std::string& method) {
    const std::string why = registry.find(method)->contestant->unavailable();
    if (!why.empty()) throw UnavailableError(label + " (" + method + ") is unavailable: " + why);
  };
  for (const PlanContestant& contestant : plan.contestants) {
    if (contestant.required) need_method(contestant.label, contestant.method);
  }
  for (const PlanContestant& simplifier : plan.simplifiers) {
    if (simplifier.required && !simplifier.method.empty()) need_method(simplifier.label, simplifier.method);
  }
  if (plan.reference) need_method("the reference", plan.reference->method);
  const auto shapes = list_shapes();
  const auto need_shape = [&](const std::string& name, const std::optional<ShapeRequest>& request) {
    for (const ShapeInfo& shape : shapes) {
      if (request && request->name == shape.name && !shape.unavailable.empty())
        throw UnavailableError("the mesh " + name + " is unavailable: " + shape.unavailable);
    }
  };
  for (const PlanMesh& mesh : plan.meshes) need_shape(mesh.name, mesh.shape);
  for (const PlanScene& scene : plan.scenes) need_shape("of " + scene.name, scene.scene.mesh.shape);
}

RunResult run_plan(const Plan& plan, const Registry& registry, const RunOptions& options,
                   Progress& progress) {
  require_available(plan, registry);
  Runner runner(plan, registry, options, progress);
  return runner.run();
}

}  // namespace palpate::experiments

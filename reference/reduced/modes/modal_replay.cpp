#include "reference/reduced/modes/modal_replay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/motion/motion_model.h"
#include "core/mesh/geometry.h"
#include "reference/door/json_file.h"
#include "reference/door/moving_body.h"
#include "reference/door/request_options.h"
#include "reference/elastic_models/motion_files.h"
#include "reference/elastic_models/progress_file.h"
#include "reference/elastic_models/stepped_motion.h"
#include "reference/elastic_models/tick_report.h"
#include "reference/reduced/modes/modal_body.h"
#include "reference/reduced/modes/modal_cost.h"
#include "reference/reduced/modes/modal_options.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

constexpr std::int64_t kMostTimings = 100;
constexpr const char* kNoBoundNeeded = "none_needed";

struct ModalReplayOptions {
  ModalBodyOptions body;
  double time_step_s = 1e-3;
  std::int64_t timings = 0;
  ReplayOptions replay;
};

ModalReplayOptions take_modal_replay_options(const Request& request) {
  json left = request.options;
  take_mesh_vertices(left);
  ModalReplayOptions options;
  options.body = take_modal_options(left);
  options.time_step_s = take_number(left, "time_step_s", 1e-9, 1e6, options.time_step_s);
  options.timings = take_whole(left, "timings", 0, kMostTimings, 0);
  options.replay = take_replay_options(left);
  require_all_taken(left);
  return options;
}

/// What of the state is kept beside rows and frames.
struct StateFigures {
  std::string outcome = "completed";
  std::optional<double> first_inversion_s;
  std::size_t inverted = 0;
  std::size_t inverted_most = 0;
  double peak_speed_m_s = 0.0;
  double end_m = 0.0;
  std::uint64_t hash = 0;
};

class ModalReplay {
 public:
  ModalReplay(const MovingTask& task, const ModalReplayOptions& options, MotionFiles& files,
              std::filesystem::path progress)
      : mesh_(task.mesh),
        problem_(task.body.motion),
        options_(options),
        files_(files),
        progress_(std::move(progress)),
        phases_(find_phases(problem_)),
        plan_(plan_steps(problem_, options.time_step_s, kMostModalSteps)),
        body_(task.mesh, problem_, options.body.order, options.body.factor),
        all_steps_(count_steps()),
        strides_(problem_.samples, task.body.stepping.frames, all_steps_) {
    for (const LoadPhase& phase : phases_) body_.require_held(phase);
  }

  std::uint64_t all_steps() const { return all_steps_; }
  std::uint64_t most_rows() const { return all_steps_ / strides_.row + 2 + phases_.size(); }
  std::uint64_t most_frames() const { return strides_.frame == 0 ? 0 : all_steps_ / strides_.frame + 2; }

  /// Makes all modes.
  void prepare() {
    for (std::size_t k = 0; k < phases_.size(); ++k) {
      if (made_.count(phases_[k].loads) == 0)
        progress_.stage("modes of what holds the body from " + json(phases_[k].from_s).dump() + " s");
      phase_of(k);
    }
    setup_s_ = clock_.seconds();
    progress_.begin({{"time_step_s", longest_step()},
                     {"stable_step_s", nullptr},
                     {"stable_by", kNoBoundNeeded},
                     {"steps", all_steps_},
                     {"limiting", nullptr}});
  }

  void run(const volatile std::sig_atomic_t* stop_flag) {
    stop_flag_ = stop_flag;
    const std::size_t nodes = body_.space().nodes();
    dynamics::NodeState state{std::vector<Vec3>(nodes), std::vector<Vec3>(nodes)};
    for (std::size_t k = 0; k < phases_.size() && is_running(); ++k) {
      dynamics::ModalPhase& moving = phase_of(k);
      left_out_ = std::max(left_out_, moving.start(state, phases_[k].from_s));
      if (options_.timings > 0) starts_.push_back(state);
      if (k == 0) look(moving, phases_[k], phases_[k].from_s);
      step_through(moving, k);
      if (!is_running()) look(moving, phases_[k], time_s_);
      state = moving.state();
      last_ = k;
    }
    if (figures_.outcome == "completed" && figures_.inverted > 0) figures_.outcome = "inverted";
    field_s_ = time_field(phase_of(last_), mesh_.points.size());
    if (figures_.outcome == "completed") time_again();
  }

  void report(Response& response) const {
    std::array<char, 32> hash{};
    std::snprintf(hash.data(), hash.size(), "fnv1a:%016llx", static_cast<unsigned long long>(figures_.hash));
    response.kernel_s = stepping_s_;
    response.report = {
        {"outcome", figures_.outcome},
        {"kind", "replay"},
        {"method", kModalModel},
        {"engine", "modes"},
        {"integrator", kExponential},
        {"precision", "double"},
        {"elements", options_.body.order == 2 ? "p2" : "p1"},
        {"modes", options_.body.modal.modes},
        {"steps", steps_},
        {"steps_planned", all_steps_},
        {"steps_unsolved", 0},
        {"time_step_s", longest_step()},
        {"stable_step_s", nullptr},
        {"stable_by", kNoBoundNeeded},
        {"stability_margin", nullptr},
        {"simulated_s", time_s_},
        {"kernel_s", stepping_s_},
        {"kernel_samples_s", timed_s_},
        {"field_s", field_s_},
        {"setup_s", setup_s_},
        {"real_time_factor", number_or_null(time_s_ / stepping_s_)},
        {"holdings", made_.size()},
        {"left_out_at_phases", left_out_},
        {"unknowns", 3 * body_.space().nodes()},
        {"mode_bytes", std::size_t{24} * body_.space().nodes() * options_.body.modal.modes * made_.size()},
        {"max_displacement_m", files_.max_displacement_m()},
        {"end_displacement_m", number_or_null(figures_.end_m)},
        {"peak_speed_m_s", figures_.peak_speed_m_s},
        {"inverted_tets", figures_.inverted},
        {"inverted_tets_most", figures_.inverted_most},
        {"first_inversion_s", figures_.first_inversion_s ? json(*figures_.first_inversion_s) : json(nullptr)},
        {"state_is_finite", figures_.outcome != "diverged"},
        {"state_hash", hash.data()},
        {"frames_written", files_.frame_count()},
        {"threads", 1},
        {"vertices", mesh_.points.size()},
        {"tets", mesh_.tets.size()}};
  }

 private:
  std::uint64_t count_steps() const {
    std::uint64_t all = 0;
    for (const PhaseSteps& phase : plan_.phases) all += phase.steps;
    return all;
  }

  double longest_step() const {
    double most = 0.0;
    for (const PhaseSteps& phase : plan_.phases) most = std::max(most, phase.step_s);
    return most;
  }

  bool is_running() const { return figures_.outcome == "completed"; }

  /// The modes of a phase, made once for each holding.
  dynamics::ModalPhase& phase_of(std::size_t k) {
    auto found = made_.find(phases_[k].loads);
    if (found == made_.end())
      found = made_.emplace(phases_[k].loads, body_.build_phase(phases_[k], options_.body.modal)).first;
    found->second.prepare(plan_.phases[k].step_s);
    return found->second;
  }

  double end_of(std::size_t k, std::uint64_t step) const {
    return step == plan_.phases[k].steps
               ? phases_[k].to_s
               : phases_[k].from_s + static_cast<double>(step) * plan_.phases[k].step_s;
  }

  void step_through(dynamics::ModalPhase& moving, std::size_t k) {
    for (std::uint64_t step = 1; step <= plan_.phases[k].steps && is_running(); ++step) {
      time_s_ = end_of(k, step);
      const Stopwatch stepping;
      moving.advance(plan_.phases[k].step_s, time_s_);
      stepping_s_ += stepping.seconds();
      ++steps_;
      progress_.reach(steps_);
      if (steps_ % strides_.row == 0 || steps_ == all_steps_) look(moving, phases_[k], time_s_);
      if (steps_ == all_steps_ || !is_running()) break;
      if (stop_flag_ != nullptr && *stop_flag_ != 0) figures_.outcome = "interrupted";
      if (options_.replay.stop_after_s > 0.0 && clock_.seconds() > options_.replay.stop_after_s)
        figures_.outcome = "timed_out";
    }
  }

  /// All steps once more, without looking at them.
  void time_again() {
    for (std::int64_t sample = 0; sample < options_.timings; ++sample) {
      double seconds = 0.0;
      for (std::size_t k = 0; k < phases_.size(); ++k) {
        dynamics::ModalPhase& moving = phase_of(k);
        moving.start(starts_[k], phases_[k].from_s);
        const Stopwatch stepping;
        for (std::uint64_t step = 1; step <= plan_.phases[k].steps; ++step)
          moving.advance(plan_.phases[k].step_s, end_of(k, step));
        seconds += stepping.seconds();
      }
      timed_s_.push_back(seconds);
    }
  }

  /// A row, and a frame where it is due.
  void look(const dynamics::ModalPhase& moving, const LoadPhase& phase, double time_s) {
    if (looked_s_ == time_s) return;
    looked_s_ = time_s;
    const dynamics::ModalMeasure now = moving.measure();
    const dynamics::NodeState state = moving.state_of_first(mesh_.points.size());
    MotionRow row{time_s, now.kinetic_j, now.elastic_j, now.load_j, 0.0, 0, 0.0, {}, state.displacement_m};
    add_volume(row);
    for (const Vec3& v : state.velocity_m_s)
      row.largest_speed_m_s = std::max(row.largest_speed_m_s, length(v));
    for (const std::size_t tool : files_.tools()) {
      const auto at = std::find(phase.loads.begin(), phase.loads.end(), tool);
      row.tool_n.push_back(at == phase.loads.end()
                               ? Vec3{}
                               : now.group_force_n[static_cast<std::size_t>(at - phase.loads.begin()) + 1]);
    }
    figures_.end_m = 0.0;
    for (const Vec3& u : state.displacement_m) figures_.end_m = std::max(figures_.end_m, length(u));
    // std::max leaves a NaN out; a sum does not.
    double sum = row.kinetic_j + row.elastic_j + row.load_j;
    for (const Vec3& u : state.displacement_m) sum += u.x + u.y + u.z;
    if (!std::isfinite(sum)) {
      figures_.outcome = "diverged";
      return;
    }
    figures_.peak_speed_m_s = std::max(figures_.peak_speed_m_s, row.largest_speed_m_s);
    figures_.inverted = row.inverted_tets;
    figures_.inverted_most = std::max(figures_.inverted_most, row.inverted_tets);
    if (row.inverted_tets > 0 && !figures_.first_inversion_s) figures_.first_inversion_s = time_s;
    figures_.hash = dynamics::hash_state({time_s, state.displacement_m, state.velocity_m_s});
    files_.add_row(row);
    const bool is_due = steps_ >= next_frame_ || steps_ == all_steps_ || !is_running();
    if (strides_.frame == 0 || !is_due) return;
    files_.add_frame(time_s, state.displacement_m);
    next_frame_ += strides_.frame;
  }

  void add_volume(MotionRow& row) const {
    const auto at = [&](Index v) { return mesh_.points[v] + row.displacement_m[v]; };
    for (const Tet& t : mesh_.tets) {
      const double volume_m3 = signed_volume(at(t[0]), at(t[1]), at(t[2]), at(t[3]));
      row.volume_m3 += volume_m3;
      if (!(volume_m3 > 0.0)) ++row.inverted_tets;
    }
  }

  Stopwatch clock_;
  const TetMesh& mesh_;
  const MotionProblem& problem_;
  const ModalReplayOptions& options_;
  MotionFiles& files_;
  ProgressFile progress_;
  std::vector<LoadPhase> phases_;
  StepPlan plan_;
  ModalBody body_;
  std::uint64_t all_steps_;
  Strides strides_;
  std::map<std::vector<std::size_t>, dynamics::ModalPhase> made_;
  const volatile std::sig_atomic_t* stop_flag_ = nullptr;
  std::vector<dynamics::NodeState> starts_;  ///< of the phases
  std::uint64_t steps_ = 0;
  std::uint64_t next_frame_ = 0;
  std::size_t last_ = 0;  ///< phase
  double setup_s_ = 0.0;
  double stepping_s_ = 0.0;
  double field_s_ = 0.0;
  std::vector<double> timed_s_;
  double time_s_ = 0.0;
  double looked_s_ = -1.0;
  double left_out_ = 0.0;
  StateFigures figures_;
};

}  // namespace

Response run_modal_replay(const Request& request,
                          const std::function<const volatile std::sig_atomic_t*()>& catch_stop) {
  const Stopwatch clock;
  const ModalReplayOptions options = take_modal_replay_options(request);
  MovingTask task = read_moving_task(request);
  if (options.replay.frames > 0) task.body.stepping.frames = options.replay.frames;
  Response response;
  const StrainSize strain = task.body.motion.body.strain;
  if (task.body.model.method == kModalModel) {
    refuse_large(strain, kModalModel);
  } else {
    note_large(strain, request.method, response);
  }
  MotionFiles files(request.folder, task.body.motion, task.mesh);
  // Beside the answer, where a folder says that somebody waits for it.
  ModalReplay replay(
      task, options, files,
      request.folder.empty() ? std::filesystem::path() : request.output.parent_path() / "progress.json");
  if (options.replay.setup_only) {
    response.kernel_s = clock.seconds();
    response.report = {
        {"outcome", "set_up"}, {"time_step_s", options.time_step_s}, {"steps_planned", replay.all_steps()}};
    return response;
  }
  if (!request.folder.empty())
    clear_folder(request.folder, task.mesh, files, replay.most_rows(), replay.most_frames(),
                 options.replay.most_output_bytes);
  replay.prepare();
  replay.run(catch_stop ? catch_stop() : nullptr);
  replay.report(response);
  files.finish();
  write_file_atomically(request.output, describe_replay(files, !request.folder.empty()).dump() + "\n");
  return response;
}

}  // namespace palpate::reference

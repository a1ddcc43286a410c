#include "reference/reduced/tick_run.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/reduced/compliance_answer.h"
#include "reference/door/moving_body.h"
#include "reference/door/request_options.h"
#include "reference/elastic_models/tick_report.h"
#include "reference/linear_systems/factor.h"

namespace palpate::reference {
namespace {

using dynamics::HeldBody;
using nlohmann::json;

struct TickRunOptions {
  TickLoop loop;
  dynamics::ComplianceOptions table;
  bool single = true;
  std::string factor;
  bool moves_skin = false;  ///< each tick also moves the skin, for a picture
};

TickRunOptions take_tick_options(const Request& request) {
  json left = request.options;
  TickRunOptions options;
  options.loop = take_tick_loop(left);
  options.table.element_order = take_choice(left, "elements", {"p2", "p1"}) == 0 ? 2 : 1;
  options.single = take_choice(left, "precision", {"single", "double"}) == 0;
  const std::vector<std::string> factors{"auto", "cholmod", "eigen"};
  options.factor = factors[take_choice(left, "factor", factors)];
  options.moves_skin = take_option<bool>(left, "skin", &json::is_boolean, "true or false", false);
  take_mesh_vertices(left);
  require_all_taken(left);
  return options;
}

/// Adds a load to a problem, with `share` of what acts and of how far it moves.
void add_part(const BoundaryProblem& part, double share, BoundaryProblem& into) {
  into.gravity_m_s2 = into.gravity_m_s2 + share * part.gravity_m_s2;
  for (HeldFaces held : part.held) {
    held.by_m = share * held.by_m;
    into.held.push_back(std::move(held));
  }
  for (ElasticSupport support : part.supports) {
    support.by_m = share * support.by_m;
    into.supports.push_back(std::move(support));
  }
  for (Traction traction : part.tractions) {
    traction.traction_pa = share * traction.traction_pa;
    traction.pressure_pa *= share;
    into.tractions.push_back(std::move(traction));
  }
  for (NodalForce force : part.nodal_forces) {
    force.force_n = share * force.force_n;
    into.nodal_forces.push_back(force);
  }
}

/// The body with all its loads, each at its share.
BoundaryProblem build_problem(const MotionProblem& motion, const std::vector<double>& shares) {
  BoundaryProblem problem = motion.body;
  problem.strain = StrainSize::kSmall;
  for (std::size_t k = 0; k < motion.loads.size(); ++k) add_part(motion.loads[k].part, shares[k], problem);
  return problem;
}

std::set<Index> vertices_of(const BoundaryProblem& problem) {
  std::set<Index> out;
  const auto add = [&](const std::vector<Triangle>& faces) {
    for (const Triangle& face : faces) out.insert(face.begin(), face.end());
  };
  for (const ElasticSupport& support : problem.supports) add(support.patch.faces);
  for (const HeldFaces& held : problem.held) add(held.faces);
  return out;
}

/// Places in the table's list of nodes of the tool's vertices.
std::vector<std::size_t> find_tool_nodes(const MotionProblem& motion, std::size_t tool,
                                         const std::vector<Index>& nodes) {
  const std::set<Index> touched = vertices_of(motion.loads[tool].part);
  BoundaryProblem others = motion.body;
  for (std::size_t k = 0; k < motion.loads.size(); ++k) {
    if (k != tool) add_part(motion.loads[k].part, 1.0, others);
  }
  for (const Index v : vertices_of(others)) {
    if (touched.count(v) > 0)
      throw InputError("loads", 0, "a tool that touches nothing else that is held",
                       "vertex " + std::to_string(v) + " in both");
  }
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (touched.count(nodes[k]) > 0) out.push_back(k);
  }
  return out;
}

/// A load of the skin that follows the profiles: what is still, and what each load's whole share adds. All
/// that react() reads is linear in the shares.
class ProfiledLoad {
 public:
  ProfiledLoad(const HeldBody& held, const MotionProblem& motion) : motion_(&motion) {
    std::vector<double> shares(motion.loads.size(), 0.0);
    still_ = held.prepare(build_problem(motion, shares));
    now_ = held.prepare(build_problem(motion, shares));
    std::set<std::size_t> loaded(still_->loaded.begin(), still_->loaded.end());
    for (std::size_t k = 0; k < shares.size(); ++k) {
      shares[k] = 1.0;
      whole_.push_back(held.prepare(build_problem(motion, shares)));
      shares[k] = 0.0;
      loaded.insert(whole_.back()->loaded.begin(), whole_.back()->loaded.end());
    }
    now_->loaded.assign(loaded.begin(), loaded.end());
  }

  /// The load at a time; no memory is asked for.
  HeldBody::SkinLoad& at(double time_s) {
    now_->external_n = still_->external_n;
    now_->holding_m = still_->holding_m;
    now_->resultant = still_->resultant;
    for (std::size_t k = 0; k < whole_.size(); ++k) {
      const double share = value_at(motion_->loads[k].profile, time_s).share;
      add(share, whole_[k]->external_n, still_->external_n, now_->external_n);
      add(share, whole_[k]->holding_m, still_->holding_m, now_->holding_m);
      add(share, whole_[k]->resultant, still_->resultant, now_->resultant);
    }
    return *now_;
  }

 private:
  template <typename Numbers>
  static void add(double share, const Numbers& whole, const Numbers& still, Numbers& into) {
    for (std::size_t i = 0; i < into.size(); ++i) into[i] += share * (whole[i] - still[i]);
  }

  const MotionProblem* motion_;
  std::unique_ptr<HeldBody::SkinLoad> still_;
  std::unique_ptr<HeldBody::SkinLoad> now_;
  std::vector<std::unique_ptr<HeldBody::SkinLoad>> whole_;
};

Vec3 force_on(const HeldBody::SkinLoad& load, const std::vector<std::size_t>& nodes) {
  Vec3 sum;
  for (const std::size_t k : nodes) {
    sum = sum + Vec3{load.force_n[3 * k] - load.external_n[3 * k],
                     load.force_n[3 * k + 1] - load.external_n[3 * k + 1],
                     load.force_n[3 * k + 2] - load.external_n[3 * k + 2]};
  }
  return sum;
}

}  // namespace

Response run_compliance_ticks(const Request& request) {
  if (request.method != "reduced.ticks") throw InputError("method", 0, "reduced.ticks", request.method);
  TickRunOptions options = take_tick_options(request);
  const MovingTask task = read_moving_task(request);
  const MotionProblem& motion = task.body.motion;
  const std::size_t tool = find_only_tool(motion);
  Response response;
  if (motion.body.strain == StrainSize::kLarge)
    response.notes.emplace_back(
        "reduced.ticks is linear: large strains and rotations are taken for small ones");

  const Stopwatch making;
  options.table.poisson_ratio = motion.body.material.poisson_ratio;
  dynamics::ComplianceSetup setup;
  dynamics::ComplianceTable table =
      build_compliance_table(task.mesh, options.table, choose_factor(options.factor), setup);
  if (options.single) table = to_single(table);
  const double identify_s = making.seconds();
  const HeldBody held(table, task.mesh, build_problem(motion, std::vector<double>(motion.loads.size(), 0.0)));
  const std::vector<std::size_t> nodes = find_tool_nodes(motion, tool, table.nodes.vertices);
  ProfiledLoad load(held, motion);
  const double prepare_s = making.seconds() - identify_s;

  const std::uint64_t all = options.loop.warm_ticks + options.loop.ticks;
  std::vector<Vec3> force_n(all);
  TickClock clock(options.loop);
  clock.start();
  for (std::uint64_t k = 0; k < all; ++k) {
    HeldBody::SkinLoad& now = load.at(static_cast<double>(k + 1) * options.loop.tick_s);
    held.react(now);
    if (options.moves_skin) held.move_skin(now);
    force_n[k] = force_on(now, nodes);
    clock.end_tick();
  }
  const std::vector<double> seconds = clock.seconds();
  response.kernel_s = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  response.report = {{"outcome", "completed"},
                     {"kind", "ticks"},
                     {"steps_per_tick", 1},
                     {"tick_s", options.loop.tick_s},
                     {"identify_s", identify_s},
                     {"prepare_s", prepare_s},
                     {"setup_s", identify_s + prepare_s},
                     {"first_tick_s", clock.seconds_of(0)},
                     {"precision", options.single ? "single" : "double"},
                     {"skin_table_bytes", table.skin_bytes()},
                     {"skin_nodes", table.nodes.size()},
                     {"touched_components", held.touched()},
                     {"engine_threads", 1},
                     {"vertices", task.mesh.points.size()}};
  add_tick_times(seconds, options.loop.tick_s, response.report);
  write_file_atomically(request.output,
                        describe_tick_forces(force_n, options.loop.tick_s, false).dump() + "\n");
  return response;
}

}  // namespace palpate::reference

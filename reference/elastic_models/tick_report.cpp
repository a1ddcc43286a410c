#include "reference/elastic_models/tick_report.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "reference/door/request_options.h"

namespace palpate::reference {

using nlohmann::json;

namespace {

constexpr double kBucketsADecade = 20.0;
constexpr std::size_t kMostSamples = 1000;
constexpr std::int64_t kMostMeshVertices = 536'870'912;

}  // namespace

TickLoop take_tick_loop(json& options) {
  TickLoop out;
  out.tick_s = take_number(options, "tick_s", 1e-5, 1.0, out.tick_s);
  out.ticks = static_cast<std::uint64_t>(take_whole(options, "ticks", 100, 100'000'000, 2000));
  out.warm_ticks = out.ticks / 10;
  out.paced = take_option<bool>(options, "paced", &json::is_boolean, "true or false", false);
  return out;
}

void take_mesh_vertices(json& options) {
  take_whole(options, "vertices", 0, kMostMeshVertices, 0);
}

TickClock::TickClock(const TickLoop& loop)
    : loop_(loop),
      period_(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(loop.tick_s))),
      begin_(loop.warm_ticks + loop.ticks + 1),
      end_(loop.warm_ticks + loop.ticks) {}

void TickClock::start() {
  begin_[0] = Clock::now();
}

void TickClock::end_tick() {
  end_[done_] = Clock::now();
  begin_[done_ + 1] = end_[done_];
  const Clock::time_point due = begin_[done_] + period_;
  if (loop_.paced && end_[done_] < due) {
    std::this_thread::sleep_until(due);
    begin_[done_ + 1] = due;
  }
  ++done_;
}

double TickClock::seconds_of_running() const {
  return std::chrono::duration<double>(Clock::now() - begin_[done_]).count();
}

double TickClock::seconds_of(std::uint64_t tick) const {
  return std::chrono::duration<double>(end_[tick] - begin_[tick]).count();
}

std::vector<double> TickClock::seconds() const {
  std::vector<double> out;
  for (std::uint64_t k = loop_.warm_ticks; k < done_; ++k) out.push_back(seconds_of(k));
  return out;
}

TickTimes describe_ticks(std::vector<double> seconds, double deadline_s) {
  require(!seconds.empty(), "at least one tick");
  std::sort(seconds.begin(), seconds.end());
  const auto count = static_cast<double>(seconds.size());
  const auto percentile = [&](double percent) {
    const auto place = static_cast<std::size_t>(std::ceil(percent / 100.0 * count - 1e-9));
    return seconds[std::min(seconds.size(), std::max<std::size_t>(place, 1)) - 1];
  };
  TickTimes out;
  out.p50_s = percentile(50.0);
  out.p99_s = percentile(99.0);
  out.p99_9_s = percentile(99.9);
  out.worst_s = seconds.back();
  out.mean_s = std::accumulate(seconds.begin(), seconds.end(), 0.0) / count;
  out.missed = static_cast<std::uint64_t>(seconds.end() -
                                          std::upper_bound(seconds.begin(), seconds.end(), deadline_s));
  const auto bucket = [](double s) { return static_cast<int>(std::floor(kBucketsADecade * std::log10(s))); };
  const int first = bucket(std::max(seconds.front(), 1e-9));
  const int last = bucket(std::max(seconds.back(), 1e-9));
  out.buckets.resize(static_cast<std::size_t>(last - first) + 1);
  for (int k = first; k <= last; ++k) out.bucket_ends_s.push_back(std::pow(10.0, (k + 1) / kBucketsADecade));
  for (const double s : seconds) ++out.buckets[static_cast<std::size_t>(bucket(std::max(s, 1e-9)) - first)];
  return out;
}

void add_tick_times(const std::vector<double>& seconds, double tick_s, json& report) {
  const TickTimes times = describe_ticks(seconds, tick_s);
  report["ticks"] = seconds.size();
  report["tick_p50_s"] = times.p50_s;
  report["tick_p99_s"] = times.p99_s;
  report["tick_p99_9_s"] = times.p99_9_s;
  report["tick_worst_s"] = times.worst_s;
  report["tick_mean_s"] = times.mean_s;
  report["ticks_missed"] = times.missed;
  report["bucket_ends_s"] = times.bucket_ends_s;
  report["buckets"] = times.buckets;
}

json describe_tick_forces(std::span<const Vec3> force_n, double tick_s, bool ended_early) {
  json written{{"schema", "palpate/engine/1"},
               {"kind", "ticks"},
               {"columns", {"time_s", "fx_n", "fy_n", "fz_n"}},
               {"rows", json::array()},
               {"held_forces_n", json::array()}};
  const std::size_t stride = std::max<std::size_t>(1, force_n.size() / kMostSamples);
  for (std::size_t k = 0; k < force_n.size(); k += stride)
    written["rows"].push_back(
        {static_cast<double>(k + 1) * tick_s, force_n[k].x, force_n[k].y, force_n[k].z});
  if (ended_early || force_n.empty()) return written;
  const std::size_t held = std::max<std::size_t>(1, force_n.size() / 10);
  for (std::size_t k = force_n.size() - held; k < force_n.size(); ++k)
    written["held_forces_n"].push_back({force_n[k].x, force_n[k].y, force_n[k].z});
  return written;
}

std::size_t find_only_tool(const MotionProblem& problem) {
  std::vector<std::size_t> tools;
  for (std::size_t k = 0; k < problem.loads.size(); ++k) {
    if (problem.loads[k].from_s > 0.0 || problem.loads[k].until_s)
      throw InputError("load " + std::to_string(k + 1), 0, "a load that is there all the time",
                       "one that comes or goes");
    if (problem.loads[k].is_tool()) tools.push_back(k);
  }
  if (tools.size() != 1) throw InputError("loads", 0, "one tool (displace)", std::to_string(tools.size()));
  return tools.front();
}

}  // namespace palpate::reference

#include "reference/engine/tick_times.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <thread>

#include "core/base/error.h"
#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/mesh/geometry.h"

namespace palpate::reference {
namespace {

constexpr double kEscapeRatio = 1000.0;
constexpr double kBucketsADecade = 20.0;

template <typename Real>
TickRun run(const dynamics::MotionModel& model, const TickOptions& options) {
  using Clock = std::chrono::steady_clock;
  const BoundingBox box = bounding_box(model.elastic.rest);
  const Vec3 size = box.high - box.low;
  dynamics::PlainOptions own;
  own.threads = options.threads;
  own.escape_m = kEscapeRatio * std::max({size.x, size.y, size.z, 1e-3});
  dynamics::PlainEngine<Real> engine(model, own);
  const std::uint64_t all = options.warm_ticks + options.ticks;
  std::vector<Clock::time_point> begin(all + 1);
  std::vector<Clock::time_point> end(all);
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options.tick_s));
  TickRun out;
  out.force_n.resize(all);
  std::uint64_t done = 0;
  begin[0] = Clock::now();
  const auto report = engine.step(options.tick_s / static_cast<double>(options.steps_per_tick),
                                  all * options.steps_per_tick, [&](std::uint64_t step) {
                                    if (step % options.steps_per_tick != 0) return;
                                    out.force_n[done] = engine.group_forces()[options.tool];
                                    end[done] = Clock::now();
                                    begin[done + 1] = end[done];
                                    const Clock::time_point due = begin[done] + period;
                                    if (options.paced && end[done] < due) {
                                      std::this_thread::sleep_until(due);
                                      begin[done + 1] = due;
                                    }
                                    ++done;
                                  });
  out.diverged = report.diverged;
  if (out.diverged) out.diverged_s = std::chrono::duration<double>(Clock::now() - begin[done]).count();
  out.force_n.resize(done);
  for (std::uint64_t k = options.warm_ticks; k < done; ++k)
    out.seconds.push_back(std::chrono::duration<double>(end[k] - begin[k]).count());
  out.state = engine.state();
  return out;
}

}  // namespace

TickRun run_ticks(const dynamics::MotionModel& model, const TickOptions& options) {
  require(options.ticks > 0 && options.steps_per_tick > 0 && options.tool < model.loads.size(),
          "ticks, steps and a tool");
  return options.single_precision ? run<float>(model, options) : run<double>(model, options);
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

}  // namespace palpate::reference

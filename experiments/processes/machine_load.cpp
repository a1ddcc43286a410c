#include "experiments/processes/machine_load.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace palpate::experiments {
namespace {

double usage_seconds(int who) {
  rusage usage{};
  ::getrusage(who, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Of this process and of its children that were waited for.
double own_seconds() {
  return usage_seconds(RUSAGE_SELF) + usage_seconds(RUSAGE_CHILDREN);
}

std::optional<ProcessorTicks> read_processor_ticks() {
  std::ifstream file("/proc/stat");
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  return parse_processor_ticks(line);
}

}  // namespace

std::optional<ProcessorTicks> parse_processor_ticks(const std::string& text) {
  std::istringstream words(text);
  std::string name;
  words >> name;
  if (name != "cpu") return std::nullopt;
  constexpr std::size_t kFields = 8;  // guests, behind them, are in the users' time already
  constexpr std::size_t kIdle = 3;
  constexpr std::size_t kWaiting = 4;
  ProcessorTicks ticks;
  for (std::size_t i = 0; i < kFields; ++i) {
    double value = 0.0;
    if (!(words >> value) || !(value >= 0.0)) return std::nullopt;
    ticks.all += value;
    if (i != kIdle && i != kWaiting) ticks.busy += value;
  }
  return ticks;
}

LoadMeter::LoadMeter() : ticks_(read_processor_ticks()), own_s_(own_seconds()) {
  double load = 0.0;
  if (::getloadavg(&load, 1) == 1) load_1min_ = load;
}

MachineLoad LoadMeter::read() const {
  MachineLoad load;
  load.load_1min = load_1min_;
  const auto now = read_processor_ticks();
  const auto per_second = static_cast<double>(::sysconf(_SC_CLK_TCK));
  if (!ticks_ || !now || !(per_second > 0.0)) return load;
  load.processor_s = (now->all - ticks_->all) / per_second;
  load.others_s = (now->busy - ticks_->busy) / per_second - (own_seconds() - own_s_);
  return load;
}

int usable_processors() {
  cpu_set_t usable;
  CPU_ZERO(&usable);
  if (::sched_getaffinity(0, sizeof usable, &usable) != 0) return 1;
  return std::max(1, CPU_COUNT(&usable));
}

}  // namespace palpate::experiments

// How much of the machine there is for this process, how busy it is, and how much of it others take.
#pragma once

#include <optional>
#include <string>

namespace palpate::experiments {

/// The load of the machine before and during a piece of work.
struct MachineLoad {
  std::optional<double> load_1min;    ///< processes that ran or waited, over the minute before it began
  std::optional<double> processor_s;  ///< that passed on all processors while it went on
  /// What others than this process and its children took of them. The system counts in ticks of 10 ms, so
  /// that one figure is good to some ticks, and a sum over repeats to better; it may be below zero by as
  /// much.
  std::optional<double> others_s;
};

/// Processor time as the system counts it, over all processors, in ticks.
struct ProcessorTicks {
  double all = 0.0;
  double busy = 0.0;  ///< all but idle and waiting for disks
};

/// Reads the first line of /proc/stat, "cpu user nice system idle iowait irq softirq steal ...".
/// Returns: nothing for another text.
std::optional<ProcessorTicks> parse_processor_ticks(const std::string& text);

/// The processors that this process may run on (its affinity), at least 1.
int usable_processors();

/// Notes the state of the machine when it is made, and says what has changed since.
class LoadMeter {
 public:
  LoadMeter();

  /// The load since. Children count as this process's own once they were waited for.
  MachineLoad read() const;

 private:
  std::optional<double> load_1min_;
  std::optional<ProcessorTicks> ticks_;
  double own_s_ = 0.0;
};

}  // namespace palpate::experiments

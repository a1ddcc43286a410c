#include "reference/simplifier_support/size_search.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"

namespace palpate::reference {
namespace {

constexpr double kAim = 0.002;
constexpr double kEnough = 0.005;
constexpr int kFineTries = 8;
constexpr int kMostTries = 20;
constexpr int kMostFailures = 3;
constexpr double kLargestStep = 0.7;  // in log size: a factor of 2
constexpr double kJump = 1e-3;        // a bracket as narrow as that holds a jump of the count
constexpr double kScanStep = 5e-4;
constexpr int kMostScans = 10;
constexpr double kUnanswered = 1e-3;  // change of the log count over a largest step

/// A try in logarithms: x of the size, y of the count over the target.
struct Sample {
  double x;
  double y;
};

/// Where to look next.
class SizeChooser {
 public:
  explicit SizeChooser(double first_size) : x_(std::log(first_size)) {}

  double x() const { return x_; }

  void add(double y) {
    if (fine_ && coarse_ && std::fabs(coarse_->x - fine_->x) < kJump) {
      scan();
      return;
    }
    const Sample now{x_, y};
    std::optional<Sample>& end = y > 0.0 ? fine_ : coarse_;
    if (!end || (y > 0.0 ? x_ > end->x : x_ < end->x)) end = now;
    if (previous_) {
      const double step = std::fabs(now.x - previous_->x);
      const bool fell = std::fabs(now.y - previous_->y) > kUnanswered;
      answers_ = y < 0.0 || step < 0.99 * kLargestStep || fell;  // a finer size adds tets sooner or later
    }
    x_ = fine_ && coarse_ ? between() : outward(now);
    previous_ = now;
  }

  /// Leaves a size at which nothing could be made.
  void step_aside(int failures) { x_ += failures % 2 == 1 ? 0.01 * failures : -0.01 * failures; }

  bool is_exhausted() const { return !answers_ || scans_ > kMostScans; }

 private:
  /// Around the jump, by turns on either side: counts that jump there jump elsewhere too, and may land
  /// nearer.
  void scan() {
    ++scans_;
    const int distance = (scans_ + 1) / 2;
    const double away = kScanStep * distance;
    x_ = 0.5 * (fine_->x + coarse_->x) + (scans_ % 2 == 1 ? away : -away);
  }

  /// Between the ends: the secant's root, by turns the middle, so that both ends move.
  double between() {
    bisect_ = !bisect_;
    const double middle = 0.5 * (fine_->x + coarse_->x);
    const double slope = (coarse_->y - fine_->y) / (coarse_->x - fine_->x);
    if (!bisect_ || !(slope < 0.0)) {
      const double root = fine_->x - fine_->y / slope;
      const double low = std::min(fine_->x, coarse_->x);
      const double high = std::max(fine_->x, coarse_->x);
      const double margin = 0.02 * (high - low);
      if (slope < 0.0) return std::clamp(root, low + margin, high - margin);
    }
    return middle;
  }

  /// Towards the target, by the slope so far; a little further, to enclose it.
  double outward(const Sample& now) const {
    double slope = -3.0;
    if (previous_ && now.x != previous_->x) {
      slope = std::clamp((now.y - previous_->y) / (now.x - previous_->x), -6.0, -0.5);
    }
    const double step = -1.02 * now.y / slope;
    return now.x + std::clamp(step, -kLargestStep, kLargestStep);
  }

  double x_;
  bool bisect_ = true;
  bool answers_ = true;
  int scans_ = 0;
  std::optional<Sample> fine_;    ///< the coarsest size that left too many tets
  std::optional<Sample> coarse_;  ///< the finest size that left too few
  std::optional<Sample> previous_;
};

}  // namespace

double count_mismatch(std::uint64_t tets, std::uint64_t target) {
  return (static_cast<double>(tets) - static_cast<double>(target)) / static_cast<double>(target);
}

FoundSize search_size(const SizedMesher& mesher, double first_size, std::uint64_t target) {
  require(first_size > 0.0 && std::isfinite(first_size) && target > 0, "search_size: nothing to search for");
  FoundSize best;
  SizeChooser chooser(first_size);
  double best_error = INFINITY;
  int failures = 0;
  for (int i = 0; i < kMostTries && !chooser.is_exhausted(); ++i) {
    const double size = std::exp(chooser.x());
    TimedMesh result;
    ++best.tries;
    try {
      result = mesher(size);
      failures = 0;
    } catch (const InputError&) {
      throw;
    } catch (const std::runtime_error&) {
      if (++failures == kMostFailures) throw;
      chooser.step_aside(failures);
      continue;
    }
    const std::size_t tets = result.mesh.tets.size();
    const double error = std::fabs(count_mismatch(tets, target));
    if (error < best_error) {
      best_error = error;
      best.size = size;
      best.result = std::move(result);
    }
    if (best_error <= (i + 1 < kFineTries ? kAim : kEnough)) break;
    chooser.add(std::log(std::max(1.0, static_cast<double>(tets)) / static_cast<double>(target)));
  }
  if (!std::isfinite(best_error)) throw std::runtime_error("no edge length gave a mesh");
  return best;
}

}  // namespace palpate::reference

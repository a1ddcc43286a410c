#include "experiments/plan_reader/sweep.h"

#include <algorithm>
#include <set>

#include "experiments/scene_reader/scene.h"
#include "experiments/scene_reader/shape_fields.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

constexpr std::int64_t kLargestCount = std::int64_t{1} << 40;

/// A value of an axis that is no option, checked.
void check_axis_value(const SweepAxis& axis, const YamlValue& value) {
  if (axis.is_stop()) read_stop_value(axis.stop_kind(), value);
  if (axis.name == "poisson_ratio") check_poisson_ratio(value, value.number());
  if (axis.name == "vertices") value.integer(4, kMostVertices);
}

}  // namespace

std::vector<SweepAxis> read_sweep(const YamlValue& value, const std::vector<std::string>& axes) {
  std::vector<SweepAxis> sweep;
  bool has_stop = false;
  for (const auto& [key, list] : value.entries()) {
    SweepAxis axis;
    axis.name = key;
    if (!axis.is_option()) {
      if (std::find(axes.begin(), axes.end(), key) == axes.end()) {
        auto known = axes;
        known.emplace_back("option.NAME");
        list.fail("unknown sweep \"" + key + "\"" + nearest_hint(key, known));
      }
      if (axis.is_stop() && has_stop) list.fail("a sweep takes one kind of stop, not two");
      has_stop = has_stop || axis.is_stop();
    }
    std::set<std::string> seen;
    for (const YamlValue& item : list.items()) {
      if (!seen.insert(item.text()).second) item.fail_expected("values that differ");
      if (!axis.is_option()) check_axis_value(axis, item);
      const nlohmann::json number = item.json();
      if (std::find(axis.values.begin(), axis.values.end(), number) != axis.values.end())
        item.fail_expected("values that differ");
      axis.values.push_back(number);
      axis.texts.push_back({item.text(), item.file() + ":" + std::to_string(item.line())});
    }
    if (axis.values.empty()) list.fail_expected("at least one value");
    sweep.push_back(std::move(axis));
  }
  return sweep;
}

double read_stop_value(StopKind kind, const YamlValue& value) {
  if (kind == StopKind::kRatio) {
    const double ratio = value.number();
    if (ratio < 0.0 || ratio >= 1.0) {
      value.fail_expected("a share of the tets to remove, from 0 to less than 1");
    }
    return ratio;
  }
  return static_cast<double>(value.integer(kind == StopKind::kTets ? 1 : 0, kLargestCount));
}

StopKind SweepAxis::stop_kind() const {
  if (name == "fusions") return StopKind::kFusions;
  return name == "tets" ? StopKind::kTets : StopKind::kRatio;
}

}  // namespace palpate::experiments

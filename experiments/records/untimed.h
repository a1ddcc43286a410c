// Records whose times say nothing: cases that ran side by side, or on unlike machines.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace palpate::experiments {

/// Sets every figure of a clock that the record has to null (is_measured_anew of judging/measure.h, but for
/// memory; the processor's time and the load of the machine too), and says why in "null_reasons".
void drop_times(nlohmann::json& record, const std::string& reason);

}  // namespace palpate::experiments

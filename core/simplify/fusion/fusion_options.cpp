#include "core/simplify/fusion/fusion_options.h"

#include <string>

#include "core/base/error.h"

namespace palpate::simplify {

void validate_options(const SimplifyOptions& options) {
  if (!(options.drop >= 0.0 && options.drop <= 1.0)) {
    throw InputError("drop", 0, "a share from 0 to 1", std::to_string(options.drop));
  }
  if (options.last_level < 1)
    throw InputError("last_level", 0, "1 or more", std::to_string(options.last_level));
  if (options.threads < 1) throw InputError("threads", 0, "1 or more", std::to_string(options.threads));
  const StopRule& stop = options.stop;
  if (stop.ratio && !(*stop.ratio >= 0.0 && *stop.ratio < 1.0)) {
    throw InputError("ratio", 0, "a share from 0 up to, not including, 1", std::to_string(*stop.ratio));
  }
  if (stop.tets && *stop.tets == 0) throw InputError("tets", 0, "1 or more", "0");
}

}  // namespace palpate::simplify

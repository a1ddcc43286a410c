// Answers of contestants that a run needs but does not measure: references, simplified meshes. Kept below the
// build folder.
#pragma once

#include "experiments/contestant_run.h"

namespace palpate::experiments {

/// Runs the contestant, or takes the answer that an earlier run kept: the same method and options, the same
/// bytes of mesh, problem and program. Only an answer that is "ok" is kept. Its output lies in the cache (for
/// the caller to read, not to move), or in the task's scratch folder where the cache cannot be written; its
/// times are those of the run that made it. `was_kept` tells whether it was there.
ContestantAnswer run_cached(const ContestantTask& task, bool& was_kept);

}  // namespace palpate::experiments

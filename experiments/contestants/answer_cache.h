// Answers of contestants that a run needs but does not measure: references, simplified meshes. Kept below the
// build folder.
#pragma once

#include <filesystem>
#include <span>

#include "experiments/contestants/contestant_run.h"

namespace palpate::experiments {

/// Runs the contestant, or takes the answer that an earlier run kept: the same method and options, the same
/// bytes of mesh, problem and program. Only an answer that is "ok" is kept. Its output lies in the cache (for
/// the caller to read, not to move), or in the task's scratch folder where the cache cannot be written; its
/// times are those of the run that made it. `was_kept` tells whether it was there.
///
/// `further` are problems of the same task but for their loads, which will be asked for next: a method with
/// the option "further" solves those that are not kept in the same process, with the same factors, and their
/// answers are kept too, each as if it had been asked for by itself.
ContestantAnswer run_cached(const ContestantTask& task, bool& was_kept,
                            std::span<const std::filesystem::path> further = {});

}  // namespace palpate::experiments

// The contest simplify: meshes in, meshes out, held against their inputs.
#pragma once

#include "experiments/contests/contest.h"

namespace palpate::experiments {

const ContestKind& simplify_contest();

}  // namespace palpate::experiments

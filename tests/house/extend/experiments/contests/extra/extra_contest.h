// The contest extra: meshes in, meshes out, their tetrahedra counted.
#pragma once

#include "experiments/contests/contest.h"

namespace palpate::experiments {

const ContestKind& extra_contest();

}  // namespace palpate::experiments

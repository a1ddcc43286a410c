// The contest deform: problems in, displacements out, held against a converged reference.
#pragma once

#include "experiments/contests/contest.h"

namespace palpate::experiments {

const ContestKind& deform_contest();

}  // namespace palpate::experiments

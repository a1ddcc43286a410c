// The contest verify: problems with a known answer in, displacements out, held against that answer.
#pragma once

#include "experiments/contests/contest.h"

namespace palpate::experiments {

const ContestKind& verify_contest();

}  // namespace palpate::experiments

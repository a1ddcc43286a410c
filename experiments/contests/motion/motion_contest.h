// The contest motion: dynamic scenes in, histories and frequencies out, held against finite elements.
#pragma once

#include "experiments/contests/contest.h"

namespace palpate::experiments {

const ContestKind& motion_contest();

}  // namespace palpate::experiments

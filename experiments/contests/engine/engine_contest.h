// The contest engine: dynamic scenes in, motions of our own engine out, with what they took and came to.
#pragma once

#include "experiments/contests/contest.h"

namespace palpate::experiments {

const ContestKind& engine_contest();

}  // namespace palpate::experiments

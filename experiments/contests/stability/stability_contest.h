// The contest stability: bodies driven to extremes. Whatever becomes of a body is a result; what is judged is
// that there is one, in numbers, and that small motions have the longest stable step that was predicted.
#pragma once

#include "experiments/contests/contest.h"

namespace palpate::experiments {

const ContestKind& stability_contest();

}  // namespace palpate::experiments

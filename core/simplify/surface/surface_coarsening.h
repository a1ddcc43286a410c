// How a run of simplify_surface gets coarser: skin and inside by turns, and the skin evened out.
#pragma once

#include <cstdint>

#include "core/simplify/surface/surface_flip.h"
#include "core/simplify/surface/surface_run.h"

namespace palpate::simplify {

/// Which way to the count: straight, or the skin as coarse as the bound permits first, whatever the count is.
enum class Way : std::uint8_t { kStraight, kFarthest };

/// Down to a little more than the target: the rest is left to simplify_refined. No collapse is made once
/// there are no more than `enough` tets. In the end the lengths of the skin's edges are evened out.
void coarsen_to(SurfaceRun& run, double target, std::uint64_t enough, Way way);

/// Until the boundary gets no coarser.
void coarsen_to_limit(SurfaceRun& run);

/// Down to the count itself, with tets scored as at `aim`. If the inside does not get there, the skin gives
/// way further than planned.
void press_on(SurfaceRun& run, std::uint64_t target, double aim);

/// A collapse takes some five tets at once, so that the last one may end that far below the target. Splits of
/// the skin's longest edges lead back to `fewest` or more, and not beyond the target.
void make_up_for_last(SurfaceRun& run, std::uint64_t fewest, std::uint64_t target);

/// What flips the run's boundary edges, for what it is scored by.
BoundaryFlipper flipper_of(SurfaceRun& run);

/// One pass of flips in the skin, if the options permit them.
void flip_boundary(SurfaceRun& run, BoundaryFlipper& flipper);

/// Moves in the skin, if the options permit them: for the best shapes, or to mend the worst.
void move_boundary(SurfaceRun& run);

}  // namespace palpate::simplify

"""Peers at equal distance: whose skin strays no farther from the input's than that of the answer they are held against."""

from shared.records import median


def distance_of(group):
    """How far the skin has moved at most, as the judge found (the upper end of its bracket), in the mesh's unit; None if unknown."""
    return median(group.figures("judge", "surface_distance_upper")) if group else None


def strays_farther(peer, own):
    """Whether a peer's skin is farther from the input's than that of `own`; what is not known counts as farther."""
    theirs, ours = distance_of(peer), distance_of(own)
    return theirs is None or ours is None or theirs > ours


def stray_text(group):
    distance = distance_of(group)
    return "no distance" if distance is None else f"strays {distance:.3g}"

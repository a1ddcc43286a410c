"""Which answers may be compared: a mesh that lost less looks better, so comparisons hold only at equal count.

The reference of a label is the claim's `better` on the same mesh and sweep point, or, in a plan without a claim, the label
that its stop names (`tets_of`). An answer is at equal count if its tetrahedra are within 1% of the reference's. One fusion
removes about 20 of 8000 tetrahedra, so two methods that stop at the same count can end up to 0.3% apart.

A plan with the key `equal_count` sets the share itself, and a label that names no other is held against the count that its
stop asks for.
"""

from shared.records import figure, median

TOLERANCE = 0.01


def tets_of(group):
    """Median number of tetrahedra over the accepted cases, or None."""
    return median(group.figures("judge", "tets")) if group else None


def tolerance_of(run):
    """The share within which counts are equal: the plan's, else 1%."""
    share = figure(run.plan_data, "equal_count")
    return TOLERANCE if share is None else share


def is_equal(tets, reference_tets, tolerance=TOLERANCE):
    return None not in (tets, reference_tets) and abs(tets - reference_tets) <= tolerance * reference_tets


def equal_cases(group, reference_tets, tolerance=TOLERANCE):
    """The accepted cases of a group that are at equal count."""
    return [case for case in group.cases() if is_equal(figure(case, "judge", "tets"), reference_tets, tolerance)]


def asked_tets(record):
    """The number of tetrahedra that a record's stop asks for, or None if it asks for none."""
    stop = record.get("stop") if isinstance(record.get("stop"), dict) else {}
    value, start = figure(stop, "value"), figure(record, "mesh", "tets")
    if stop.get("kind") == "ratio" and None not in (value, start):
        return start * (1 - value)
    return value if stop.get("kind") == "tets" else None


def reference_of(run, claim, group):
    """The group that another is compared with, or None: it is the reference itself, or has none."""
    stop = group.records[0].get("stop") if group.records else None
    label = claim.better if claim else (stop.get("of") if isinstance(stop, dict) else None)
    same = run.find(group.mesh, label) if label and label != group.label else []
    return next((other for other in same if other.sweep == group.sweep), same[0] if same else None)


def reference_tets_of(run, claim, group):
    """The count that a group's answers are held against, or None."""
    tets = tets_of(reference_of(run, claim, group))
    if tets is None and "equal_count" in run.plan_data and group.records:
        return asked_tets(group.records[0])
    return tets


def is_at_equal_count(run, claim, group):
    """Whether the median count of a group is the one that it is held against; single answers may be off."""
    reference_tets = reference_tets_of(run, claim, group)
    return reference_tets is None or is_equal(tets_of(group), reference_tets, tolerance_of(run))


def is_early(case, tolerance=TOLERANCE):
    """Whether an answer ended at its limit, short of the stop that it was given. One that searched for a parameter did not."""
    if case.get("searched"):
        return False
    stop = case.get("stop") if isinstance(case.get("stop"), dict) else {}
    value, tets = figure(stop, "value"), figure(case, "judge", "tets")
    if stop.get("kind") == "fusions":
        fusions = figure(case, "report", "fusions")
        return None not in (fusions, value) and fusions < value
    asked = asked_tets(case)
    return None not in (asked, tets) and tets > asked * (1 + tolerance)


def describe(group, cases, what):
    """"stopped early: 7,630 tets", or of how many seeds or different outputs that holds."""
    if len(group.cases()) > 1:
        several = "seeds" if len({str(case.get("seed")) for case in group.cases()}) > 1 else "outputs"
        return f"{what}: {len(cases)} of {len(group.cases())} {several}"
    return f"{what}: {figure(cases[0], 'judge', 'tets'):,.0f} tets"


def count_note(run, claim, group):
    """What stands beside a label whose figures are not to be compared, or ended early; else ""."""
    reference_tets, tolerance = reference_tets_of(run, claim, group), tolerance_of(run)
    cases = [case for case in group.cases() if figure(case, "judge", "tets") is not None]
    if reference_tets is None:
        early = [case for case in cases if is_early(case, tolerance)]
        return describe(group, early, "stopped early") if early else ""
    off = [case for case in cases if not is_equal(figure(case, "judge", "tets"), reference_tets, tolerance)]
    if not off:
        return ""
    early = [case for case in off if is_early(case, tolerance)]
    if early:
        return describe(group, early, "stopped early")
    to_limit = all(isinstance(case.get("stop"), dict) and case["stop"].get("kind") == "limit" for case in off)
    return describe(group, off, "at its limit" if to_limit else "other count")


def add_count_notes(run, claim):
    """Fills `count_note` of every group: tables and charts show it."""
    for group in run.groups:
        group.count_note = count_note(run, claim, group)

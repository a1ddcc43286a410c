"""Holds a run against the claim of its plan, by one rule for all plans.

On each mesh, with b and t the medians over seeds of the claim's measure for its labels `better` and `than`, where higher is better
if the published `better` is above the published `than`, and k the number of the n seeds of its label `spread` (the same method in
random orders) that are at least as good as b:

  reproduces               b is better than t, by at least half of the published difference, and better than random orders:
                           (k + 1) / (n + 1) is at most 5%
  reproduces in sign only  the same, but the difference is less than half of the published one
  does not reproduce       b is no better than t, or by less than the last digit that is shown; or more than 5% of all random orders are
                           at least as good, for certain: the lower end of Clopper and Pearson's 95% interval of that share, from
                           k of n, is above 5%
  open                     neither: too few seeds (19 are the least that can show it), or a share that is near 5%; or t has several
                           values, and the interval of its median (intervals.py) holds b
  cannot be decided        there is no accepted answer of `better` or `than`, or none of `spread` where the claim has one;
                           or those of `than` or `spread` are not at equal count (equal_count.py: within 1% of the
                           tetrahedra of `better`). Seeds of `spread` at another count are left out, which is said.

(k + 1) / (n + 1) is the chance that an order drawn from the random ones would rank so high among n others: an exact permutation
test. More seeds make the rule sharper and not harder: an order that is no better than random passes in at most 5% whatever n is,
one that all but a few random orders fall behind passes the more surely the more of them are run. (Before, b had to be above the
best of all seeds: a bar that rises with every seed.)

If nothing is published, the claim is that `better` is higher, and "reproduces" needs no least difference. Over all meshes the
claim does what it does on the weakest of them, because it is made for all: "reproduces" or "reproduces in sign only" only if each
mesh does at least that; one that is open or cannot be decided leaves the whole so, unless another does not reproduce. The ranks over
all meshes together, and their chance (intervals.rank_chance), are shown beside it and decide nothing. (Equal count came to the rule
after the first runs, the ranks after that; neither changed a verdict.)
"""

import statistics
from dataclasses import dataclass
from typing import Optional

from shared.equal_count import equal_cases, is_equal, tets_of, tolerance_of
from shared.intervals import is_share_above, rank_chance, share_interval, span_of
from shared.measure_text import DIGITS
from shared.records import figure, median, present
from shared.tables import align, outcome_text, write_atomically, write_csv

REPRODUCES = "reproduces"
SIGN_ONLY = "reproduces in sign only"
DOES_NOT = "does not reproduce"
OPEN = "open"
UNDECIDED = "cannot be decided"
TIE = "a tie, the difference is below the last digit that is shown"
LEAST_SHARE = 0.5  # of the published difference
RANDOM_SHARE = 0.05  # of the random orders may be at least as good


@dataclass
class Claim:
    text: str
    source: str
    measure: str
    better: str
    than: str
    spread: str
    published_better: Optional[float]
    published_than: Optional[float]
    required: bool = False

    @property
    def published_difference(self):
        if self.published_better is None or self.published_than is None:
            return None
        return self.published_better - self.published_than

    @property
    def sign(self):
        """+1 if the published side is the higher one (or nothing is published), -1 if the lower."""
        return -1 if (self.published_difference or 0) < 0 else 1

    def text_of(self, value, form=""):
        """A figure of the measure, or with the form "+" a difference, as it is shown."""
        digits = DIGITS.get(self.measure)
        return f"{value:{form}.4g}" if digits is None else f"{value:{form}.{digits}f}"

    def signed(self, value):
        return self.text_of(value, "+") + (f" {self.unit}" if self.unit else "")

    def is_tie(self, one, other):
        """Whether two figures differ by less than the last digit that is shown."""
        digits = DIGITS.get(self.measure)
        return one == other if digits is None else round(abs(one - other), digits) == 0

    @property
    def unit(self):
        """What stands behind a difference of the measure."""
        return "points" if self.measure.startswith("percent") else ""


@dataclass
class MeshVerdict:
    mesh: str
    sweep: str
    input_value: Optional[float]
    better: Optional[float]
    than: Optional[float]
    spread: list
    verdict: str
    reason: str
    better_tets: Optional[float] = None
    than_tets: Optional[float] = None
    left_out: int = 0  # seeds of the spread at another count
    as_good: int = 0  # seeds of the spread that are at least as good as `better`

    @property
    def difference(self):
        return None if self.better is None or self.than is None else self.better - self.than


def read_claim(plan_data):
    """The plan's claim, or None if it has none that names a measure and two labels."""
    claim = plan_data.get("claim")
    if not isinstance(claim, dict) or not all(isinstance(claim.get(key), str) for key in ("measure", "better", "than")):
        return None
    published = claim.get("published") if isinstance(claim.get("published"), dict) else {}
    return Claim(str(claim.get("text") or ""), str(claim.get("source") or ""), claim["measure"], claim["better"],
                 claim["than"], str(claim.get("spread") or ""), figure(published, "better"), figure(published, "than"),
                 claim.get("required") is True)


def values_of(group, measure, cases=None):
    """A measure of each accepted case (or of the given ones): of the judge, or else of the record itself."""
    cases = group.cases() if cases is None else cases
    values = present(figure(case, "judge", measure) for case in cases)
    return values or present(figure(case, measure) for case in cases)


def count_as_good(claim, better, spread):
    """How many values of the spread are at least as good as `better`."""
    return sum(claim.sign * value >= claim.sign * better for value in spread)


def rank_state(as_good, seeds):
    """How `better` stands among the random orders: REPRODUCES (better than they are), DOES_NOT or OPEN."""
    if rank_chance([(as_good, seeds)]) <= RANDOM_SHARE:
        return REPRODUCES
    return DOES_NOT if is_share_above(as_good, seeds, RANDOM_SHARE) else OPEN


def least_difference(claim, better, than):
    """By how much `better` is better than the median of `than`, at least and at most: its values have an interval if they differ."""
    low, high = span_of(than)
    return (better - high, better - low) if claim.sign > 0 else (low - better, high - better)


def decide(claim, better, than, spread):
    """The verdict on one mesh from the median of `better` and the values of the others, and why it is open."""
    if claim.is_tie(better, median(than)):
        return DOES_NOT, TIE
    least, most = least_difference(claim, better, than)
    ranked = rank_state(count_as_good(claim, better, spread), len(spread)) if spread else REPRODUCES
    if most <= 0 or ranked == DOES_NOT:
        return DOES_NOT, ""
    if least <= 0:
        return OPEN, f"{claim.than} scatters by more than the difference"
    if ranked == OPEN:
        return OPEN, f"{len(spread)} seeds cannot tell whether more than 5% of all random orders are at least as good"
    published = claim.published_difference
    is_large = published is None or least >= LEAST_SHARE * abs(published)
    return (REPRODUCES if is_large else SIGN_ONLY), ""


def judge_mesh(run, claim, mesh, sweep):
    """The verdict on one mesh at one point of the sweep."""

    def group_of(label):
        found = [group for group in run.find(mesh, label) if group.sweep == sweep]
        return found[0] if found else None

    groups = {label: group_of(label) for label in (claim.better, claim.than, claim.spread) if label}
    values = {label: values_of(group, claim.measure) if group else [] for label, group in groups.items()}
    record = run.inputs.get(mesh, {})
    input_value = figure(record, "judge", claim.measure)
    better, than = median(values[claim.better]), median(values[claim.than])
    spread = values.get(claim.spread, [])
    missing = [label for label in groups if not values[label]]
    if missing:
        label = missing[0]
        why = outcome_text(groups[label]) if groups[label] else "it was not run"
        why = why if why != "accepted" else f"without {claim.measure}"
        return MeshVerdict(mesh, sweep, input_value, better, than, spread, UNDECIDED,
                           f"no accepted answer of {label} ({why})")
    better_tets, than_tets = tets_of(groups[claim.better]), tets_of(groups[claim.than])
    spread_cases = equal_cases(groups[claim.spread], better_tets, tolerance_of(run)) if claim.spread else []
    spread = values_of(groups[claim.spread], claim.measure, spread_cases) if claim.spread else []
    left_out = len(groups[claim.spread].cases()) - len(spread_cases) if claim.spread else 0
    outcome, reason = decide(claim, better, values[claim.than], spread)
    if not is_equal(than_tets, better_tets, tolerance_of(run)):
        outcome, reason = UNDECIDED, unequal_text(claim.better, better_tets, claim.than, than_tets)
    elif claim.spread and not spread:
        outcome = UNDECIDED
        reason = unequal_text(claim.better, better_tets, claim.spread, tets_of(groups[claim.spread]))
    return MeshVerdict(mesh, sweep, input_value, better, than, spread, outcome, reason, better_tets, than_tets, left_out,
                       count_as_good(claim, better, spread))


def unequal_text(better, better_tets, other, other_tets):
    counts = ["no" if tets is None else f"{tets:,.0f}" for tets in (better_tets, other_tets)]
    return f"not at equal count, {better} has {counts[0]} tetrahedra and {other} {counts[1]}"


def judge_run(run, claim):
    """The verdicts of all meshes, at each point of the sweep that the two labels have."""
    verdicts = []
    for mesh in run.meshes():
        sweeps = dict.fromkeys(group.sweep for group in run.of_mesh(mesh) if group.label in (claim.better, claim.than))
        verdicts += [judge_mesh(run, claim, mesh, sweep) for sweep in sweeps]
    return verdicts


def overall(verdicts):
    """One verdict for all meshes: the weakest."""
    found = {verdict.verdict for verdict in verdicts}
    for outcome in (DOES_NOT, UNDECIDED, OPEN, SIGN_ONLY, REPRODUCES):
        if outcome in found:
            return outcome
    return UNDECIDED


# --- In words -----------------------------------------------------------------------------------------------------------


def spread_text(claim, values):
    if len(values) < 2:
        return "".join(map(claim.text_of, values))
    return (f"{claim.text_of(statistics.fmean(values))} +- {claim.text_of(statistics.stdev(values))} (mean, sd), "
            f"{claim.text_of(min(values))} to {claim.text_of(max(values))} over {len(values)} seeds")


def mesh_sentence(claim, verdict):
    """One sentence on one mesh."""
    name = f"{verdict.mesh} ({verdict.sweep})" if verdict.sweep else verdict.mesh
    if verdict.verdict == UNDECIDED:
        return f"{name}: {UNDECIDED}: {verdict.reason}."
    left = ["" if tets is None else f" ({tets:.0f} tets)" for tets in (verdict.better_tets, verdict.than_tets)]
    text = (f"{name}: {claim.better} {claim.text_of(verdict.better)}{left[0]}, {claim.than} {claim.text_of(verdict.than)}{left[1]}: "
            f"{claim.signed(verdict.difference)}")
    if claim.spread:
        text += f"; {claim.spread} {spread_text(claim, verdict.spread)}"
        text += f" ({verdict.left_out} at another count left out)" if verdict.left_out else ""
        text += f", {verdict.as_good} of them at least as good ({ranks_text([verdict])})"
    return f"{text}. {verdict.verdict.capitalize()}{': ' if verdict.reason else ''}{verdict.reason}."


def ranks_text(verdicts):
    """The chance of such ranks, and the share of random orders that are at least as good, with its interval."""
    seen, seeds = sum(verdict.as_good for verdict in verdicts), sum(len(verdict.spread) for verdict in verdicts)
    low, high = share_interval(seen, seeds)
    chance = rank_chance([(verdict.as_good, len(verdict.spread)) for verdict in verdicts])
    return f"{100 * low:.1f}% to {100 * high:.1f}% of all; rank test p = {chance:.2g}"


def overall_sentence(claim, verdicts):
    """The verdict on the claim, in one sentence or two."""
    decided = [verdict for verdict in verdicts if verdict.verdict != UNDECIDED]
    if not decided:
        return "The claim cannot be decided: no mesh has accepted answers of both sides at equal count."
    counts = {}
    for verdict in decided:
        counts[verdict.verdict] = counts.get(verdict.verdict, 0) + 1
    said = ", ".join(f"{'is ' if outcome == OPEN else ''}{outcome} on {count}" for outcome, count in counts.items())
    published = ""
    if claim.published_difference is not None:
        published = (f"Published: {claim.text_of(claim.published_better)} against {claim.text_of(claim.published_than)} "
                     f"({claim.signed(claim.published_difference)}). ")
    differences = [verdict.difference for verdict in decided]
    measured = (f"Measured: {claim.signed(min(differences))} to {claim.signed(max(differences))} over "
                f"{len(decided)} {'mesh' if len(decided) == 1 else 'meshes'}; the claim {said}. ")
    ranked = [verdict for verdict in decided if verdict.spread]
    if len(ranked) > 1:
        seen, seeds = sum(verdict.as_good for verdict in ranked), sum(len(verdict.spread) for verdict in ranked)
        measured += f"Of {claim.spread}, {seen} of {seeds} are at least as good as {claim.better} ({ranks_text(ranked)}). "
    left = f"{len(verdicts) - len(decided)} cannot be decided. " if len(decided) < len(verdicts) else ""
    return f"{published}{measured}{left}Verdict: the claim {'is ' if overall(verdicts) == OPEN else ''}{overall(verdicts)}."


def verdict_text(claim, verdicts):
    """The whole verdict as lines of plain words."""
    lines = []
    if claim.text:
        lines.append(f"Claim: {claim.text}" + (f" ({claim.source})" if claim.source else ""))
    lines.append(f"Measure: {claim.measure}, {claim.better} against {claim.than}"
                 + (f", with the spread of {claim.spread}" if claim.spread else "") + ".")
    lines += ["  " + mesh_sentence(claim, verdict) for verdict in verdicts]
    lines.append(overall_sentence(claim, verdicts))
    return "\n".join(lines)


def failed_requirements(claim, verdicts):
    """A sentence if the claim has `required: true` and does not reproduce on each mesh, in size too."""
    if claim and claim.required and overall(verdicts) != REPRODUCES:
        yield f"the claim that {claim.better} beats {claim.than}: it {'is ' if overall(verdicts) == OPEN else ''}{overall(verdicts)}"


def write_verdict(claim, verdicts, folder):
    """Writes verdict.csv and verdict.txt."""
    header = ["mesh", "sweep", "measure", "input", "better_label", "better", "than_label", "than", "better_tets", "than_tets", "difference",
              "spread_label", "spread_n", "spread_mean", "spread_sd", "spread_min", "spread_max", "at_least_as_good",
              "share_low", "share_high", "rank_chance", "published_better",
              "published_than", "published_difference", "verdict", "reason"]
    rows = []
    for verdict in verdicts:
        spread = verdict.spread
        ranks = [verdict.as_good, *share_interval(verdict.as_good, len(spread)),
                 rank_chance([(verdict.as_good, len(spread))])] if spread else [None] * 4
        rows.append([verdict.mesh, verdict.sweep, claim.measure, verdict.input_value, claim.better, verdict.better,
                     claim.than, verdict.than, verdict.better_tets, verdict.than_tets, verdict.difference, claim.spread, len(spread),
                     statistics.fmean(spread) if spread else None, statistics.stdev(spread) if len(spread) > 1 else None,
                     min(spread, default=None), max(spread, default=None), *ranks, claim.published_better, claim.published_than,
                     claim.published_difference, verdict.verdict, verdict.reason])
    write_csv(folder / "verdict.csv", header, rows)
    write_atomically(folder / "verdict.txt", verdict_text(claim, verdicts) + "\n")


# --- Variants: what else the plan varies --------------------------------------------------------------------------------


def against(run, group, label, measure):
    """The difference of a group from a label on the same mesh, over the cases at equal count; None if there are none."""
    same = run.find(group.mesh, label)
    base = next((other for other in same if other.sweep == group.sweep), same[0] if same else None)
    if base is None:
        return None
    value, reference = median(values_of(group, measure, equal_cases(group, tets_of(base), tolerance_of(run)))), median(values_of(base, measure))
    return None if value is None or reference is None else value - reference


def variant_rows(run, claim):
    """Of each label beside the claim's three: its difference from `better` and from `than`, mesh by mesh."""
    for mesh in run.meshes():
        for group in run.of_mesh(mesh):
            if group.label in (claim.better, claim.than, claim.spread):
                continue
            yield [mesh, group.label, group.sweep, outcome_text(group), tets_of(group), group.count_note, claim.measure,
                   median(values_of(group, claim.measure)),
                   *(against(run, group, label, claim.measure) for label in (claim.better, claim.than))]


def write_variants(run, claim, folder):
    """Writes variants.csv if the plan has labels beside the claim's; returns whether it did."""
    rows = list(variant_rows(run, claim))
    if rows:
        write_csv(folder / "variants.csv",
                  ["mesh", "label", "sweep", "outcome", "tets", "note", "measure", "value", f"minus_{claim.better}",
                   f"minus_{claim.than}"], rows)
    return bool(rows)


def variant_summary(run, claim):
    """A column a mesh: what each variant changes against the claim's `better`; the largest change first.

    A variant at another count shows its count in place of a change, and is not ranked by it.
    """
    table = {}
    for mesh, label, sweep, outcome, _, note, _, _, change, _ in variant_rows(run, claim):
        name = f"{label} ({sweep})" if sweep else label
        text = note if change is None and note else outcome
        table.setdefault(name, {})[mesh] = (change, text if change is None else claim.text_of(change, "+"))
    if not table:
        return ""

    def size(item):
        changes = [abs(change) for change, _ in item[1].values() if change is not None]
        return -max(changes) if changes else 1.0

    rows = [[name, *(cells.get(mesh, (None, ""))[1] for mesh in run.meshes())]
            for name, cells in sorted(table.items(), key=size)]
    return align(["variant", *run.meshes()], rows)

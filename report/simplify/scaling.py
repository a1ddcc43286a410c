"""How time and memory grow with the mesh: a power law for each label, with its interval.

For a label with median times t_i on input meshes of n_i tetrahedra (at least 3 of them, none twice), log t = a + b log n is
fitted by least squares; b is the slope. Its 95% interval is b +- t(0.975; k - 2) s_b, with s_b^2 = RSS / (k - 2) / sum (x_i -
mean)^2: it says how well a straight line fits these k sizes, not how much a repeat scatters. Sizes that timed out, ran out of
memory or were rejected are no part of the fit; they are kept as rows and drawn as open marks, those that timed out at the
limit.
"""

import math
from dataclasses import dataclass, field

from shared.records import figure, median, present
from shared.tables import align, first_reason, outcome_text, seconds_text, timing_of, write_csv

SHARE = 0.975


@dataclass
class Fit:
    slope: float
    low: object  # None for fewer than 3 points
    high: object
    intercept: float  # natural logarithms
    points: int

    def at(self, x):
        return math.exp(self.intercept + self.slope * math.log(x))


@dataclass
class Size:
    """A label on one mesh."""

    mesh: str
    tets: float
    seconds: object  # median kernel time of the accepted answers, or None
    memory: object  # greatest resident memory, bytes
    removed_per_s: object
    limit_s: object = None  # where it timed out
    note: str = ""


@dataclass
class Series:
    name: str
    label: str
    sizes: list = field(default_factory=list)
    time: object = None
    memory: object = None


def student_cdf(t, freedom):
    """P(T <= t) of Student's distribution with a whole number of degrees of freedom, by the finite sums of Abramowitz and
    Stegun 26.7.3 and 26.7.4."""
    angle = math.atan2(t, math.sqrt(freedom))
    cosine_sq, term, total = math.cos(angle) ** 2, 1.0, 0.0
    if freedom % 2:
        for k in range(1, (freedom - 1) // 2 + 1):
            total += term
            term *= cosine_sq * 2 * k / (2 * k + 1)
        share = 2 / math.pi * (angle + math.sin(angle) * math.cos(angle) * total)
    else:
        for k in range(1, freedom // 2 + 1):
            total += term
            term *= cosine_sq * (2 * k - 1) / (2 * k)
        share = math.sin(angle) * total
    return 0.5 + 0.5 * share


def student_quantile(share, freedom):
    """The t with P(T <= t) = share, 0.5 < share < 1, by halving."""
    low, high = 0.0, 1.0
    while student_cdf(high, freedom) < share:
        high *= 2
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if student_cdf(middle, freedom) < share else (low, middle)
    return (low + high) / 2


def fit_power(xs, ys):
    """The power law through positive values, or None if there are fewer than two different x."""
    pairs = [(math.log(x), math.log(y)) for x, y in zip(xs, ys)]
    if len({x for x, _ in pairs}) < 2:
        return None
    count = len(pairs)
    mean_x, mean_y = (sum(column) / count for column in zip(*pairs))
    spread = sum((x - mean_x) ** 2 for x, _ in pairs)
    slope = sum((x - mean_x) * (y - mean_y) for x, y in pairs) / spread
    intercept = mean_y - slope * mean_x
    if count < 3:
        return Fit(slope, None, None, intercept, count)
    rest = sum((y - intercept - slope * x) ** 2 for x, y in pairs)
    half = student_quantile(SHARE, count - 2) * math.sqrt(rest / (count - 2) / spread)
    return Fit(slope, slope - half, slope + half, intercept, count)


def size_of(run, group):
    tets = figure(group.records[0], "mesh", "tets")
    timing = timing_of(group)
    if timing and timing["kernel_median_s"] > 0:
        outcome = outcome_text(group)
        note = "; ".join(text for text in ("" if outcome == "accepted" else outcome, group.count_note) if text)
        return Size(group.mesh, tets, timing["kernel_median_s"], timing["peak_rss_max_bytes"], timing["tets_removed_per_s"],
                    note=note)
    timed_out = any(record.get("outcome") == "timed_out" for record in group.records)
    limit = figure(run.provenance, "timeout_s") if timed_out else None
    if timed_out and limit is None:
        limit = median(present(figure(record, "wall_s") for record in group.records))
    return Size(group.mesh, tets, None, None, None, limit, first_reason(group) or "no time")


def read_series(run):
    """One series a label and point of the sweep, sizes ascending."""
    series = {}
    several = len({group.sweep for group in run.groups}) > 1
    for group in run.groups:
        if group.records and figure(group.records[0], "mesh", "tets"):
            name = group.name if several else group.label
            series.setdefault(name, Series(name, group.label)).sizes.append(size_of(run, group))
    for entry in series.values():
        entry.sizes.sort(key=lambda size: size.tets)
        timed = [size for size in entry.sizes if size.seconds]
        entry.time = fit_power([size.tets for size in timed], [size.seconds for size in timed])
        heavy = [size for size in timed if size.memory]
        entry.memory = fit_power([size.tets for size in heavy], [size.memory for size in heavy])
    return list(series.values())


def slope_text(fit):
    if fit is None:
        return ""
    return f"{fit.slope:.2f}" + ("" if fit.low is None else f" [{fit.low:.2f}, {fit.high:.2f}]")


def bytes_per_tet(size):
    return None if size.memory is None else size.memory / size.tets


def scaling_text(series):
    """A line a label: slopes, and what it reached on the largest mesh that it finished."""
    rows = []
    for entry in series:
        last = next((size for size in reversed(entry.sizes) if size.seconds), None)
        failed = "; ".join(f"{size.mesh}: {size.note}" for size in entry.sizes if size.note)
        cells = [""] * 4 if last is None else [
            f"{last.tets:,.0f}", seconds_text(last.seconds), "" if last.removed_per_s is None else f"{last.removed_per_s:,.0f}",
            "" if last.memory is None else f"{bytes_per_tet(last):,.0f}"]
        rows.append([entry.name, str(sum(bool(size.seconds) for size in entry.sizes)), slope_text(entry.time),
                     *cells, failed])
    header = ["label", "sizes", "slope of time", "largest, tets", "kernel", "tets removed/s", "bytes/tet", "note"]
    return ("Growth with the mesh: time ~ tets^slope, least squares on logarithms [95% interval of the fit]\n\n"
            + align(header, rows))


def write_scaling(series, folder):
    """Writes scaling.csv (a row a label and mesh) and scaling_fits.csv (a row a label); returns their names."""
    rows = [[entry.name, size.mesh, size.tets, size.seconds, size.memory, bytes_per_tet(size), size.removed_per_s, size.limit_s,
             size.note] for entry in series for size in entry.sizes]
    write_csv(folder / "scaling.csv", ["label", "mesh", "tets", "kernel_median_s", "peak_rss_max_bytes", "bytes_per_tet",
                                       "tets_removed_per_s", "timed_out_at_s", "note"], rows)
    fits = []
    for entry in series:
        for what, fit in (("kernel_s", entry.time), ("peak_rss_bytes", entry.memory)):
            if fit:
                fits.append([entry.name, what, fit.points, fit.slope, fit.low, fit.high, math.exp(fit.intercept)])
    write_csv(folder / "scaling_fits.csv",
              ["label", "measure", "sizes", "slope", "slope_low", "slope_high", "value_at_one_tet"], fits)
    return {"scaling.csv", "scaling_fits.csv"}

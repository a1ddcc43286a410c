"""A contest of the engine: scenes replayed, bodies at rest, and ticks of a haptic loop, as tables and a summary.

A mesh holds the deadline by the median, by the 99th or the 99.9th percentile, or with no tick missed; the largest mesh is the
last one before the first that does not.
"""

from dataclasses import dataclass

from shared.records import figure
from shared.run_file import is_number
from shared.tables import first_reason, pad_columns, seconds_text, write_atomically, write_csv

KINDS = ("replay", "rest", "ticks")  # of an answer, as the judge names it
COARSE = "~"
TICK_NOTE = ("\n\nleft over: the largest share of the forces out of balance in a step, of methods that iterate, where it was measured; set-up: from the "
             "task to the first tick, which is none of those that are timed; memory: of the whole process, set-up included")
FORCE_NOTE = ("\n\nreference: the pad's force by finite elements; its change: by their last refinement (none: one level alone); "
              f"{COARSE} less than five times that, or that is not known: the reference cannot tell.")
HOLDS = [("median", "tick_p50_s"), ("99%", "tick_p99_s"), ("99.9%", "tick_p99_9_s"), ("none missed", "tick_worst_s")]


@dataclass
class Case:
    """One case: its first record that was judged, or the last one."""

    scene: str
    label: str
    method: str
    record: dict
    note: str

    def number(self, name):
        """A figure of the judge, or else what the contestant reports of itself."""
        judged = figure(self.record, "judge", name)
        return figure(self.record, "reported", name) if judged is None else judged

    def told(self, name):
        """What the method reports, whatever its type."""
        report = self.record.get("report")
        return report.get(name) if isinstance(report, dict) else None

    def option(self, name):
        options = self.record.get("options")
        return options.get(name) if isinstance(options, dict) else None

    def chosen(self, name):
        """An option, or what the method says of it where it has no such option."""
        value = self.option(name)
        return self.told(name) if value is None else value

    @property
    def is_accepted(self):
        return self.record.get("outcome") == "accepted"

    @property
    def threads(self):
        found = self.chosen("engine_threads")
        return found if is_number(found) else None

    @property
    def vertices(self):
        return figure(self.record, "mesh", "vertices")


@dataclass
class Findings:
    replays: list
    rests: list
    ticks: list
    silent: list  # cases of methods that never answered


def kinds_of_methods(run):
    """{method: one of KINDS}, from what any of its answers was."""
    found = {}
    for group in run.groups:
        for record in group.records:
            for block in ("judge", "report"):
                kind = (record.get(block) or {}).get("kind") if isinstance(record.get(block), dict) else None
                if kind in KINDS:
                    found.setdefault(group.contestant, kind)
    return found


def read_cases(run):
    """The cases of a run, by the kind of their answers, in the plan's order."""
    found = Findings([], [], [], [])
    lists = {"replay": found.replays, "rest": found.rests, "ticks": found.ticks}
    kinds = kinds_of_methods(run)
    for group in run.groups:
        records = [record for record in group.records if not record.get("warmup")]
        judged = [record for record in records if isinstance(record.get("judge"), dict)]
        if not records or group.contestant is None:
            continue
        note = "" if set(group.outcomes()) == {"accepted"} else first_reason(group)
        case = Case(group.mesh, group.label, group.contestant, (judged or records)[-1], note)
        lists.get(kinds.get(group.contestant), found.silent).append(case)
    found.ticks.sort(key=lambda case: (case.scene, case.label, str(case.chosen("precision")), case.threads or 0,
                                       case.vertices or 0))
    return found


def number_text(value, form=".3g", factor=1.0, unit=""):
    return "" if value is None else f"{factor * value:{form}}{unit}"


def time_text(value):
    """Seconds, or minutes, hours and days where they are many."""
    if value is None:
        return ""
    for unit, size in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if value >= 2 * size:
            return f"{value / size:.3g} {unit}"
    return f"{value:.3g} s"


def tick_text(value):
    return "" if value is None else f"{1e6 * value:.1f} us" if value < 1e-4 else f"{1e3 * value:.3f} ms"


def memory_text(case):
    return number_text(figure(case.record, "peak_rss_bytes"), ".0f", 1e-6, " MB")


def returns_of(case):
    judge = case.record.get("judge")
    found = judge.get("returns") if isinstance(judge, dict) else None
    return [each for each in found if isinstance(each, dict)] if isinstance(found, list) else []


def replay_lines(cases):
    lines = [["scene", "label", "vertices", "engine", "integrator", "step", "margin", "peak speed", "cut", "inverted", "left over", "simulated/wall",
              "one step a 5 ms tick", "set-up", "memory", ""]]
    for case in cases:
        lines.append([case.scene, case.label, number_text(case.vertices, ",.0f"), str(case.told("engine") or ""), str(case.told("integrator") or ""),
                      seconds_text(figure(case.record, "report", "time_step_s")),
                      number_text(case.number("stability_margin"), ".3f"), number_text(case.number("peak_speed_m_s"), ".3g", unit=" m/s"),
                      number_text(case.number("speeds_cut"), ",.0f"), number_text(case.number("inverted_tets_most"), ".0f"),
                      number_text(case.number("residual_worst"), ".2g"),
                      number_text(case.number("real_time_factor"), ".3g"), number_text(case.number("tick_real_time_factor"), ".3g"),
                      time_text(case.number("setup_s")), memory_text(case), case.note])
    return lines


def return_lines(cases):
    lines = [["scene", "label", "vertices", "return", "let go at", "until", "then", "left", "left of it", "half after", "a twentieth after", ""]]
    for case in cases:
        for number, each in enumerate(returns_of(case), start=1):
            value = lambda name: figure(each, name)
            lines.append([case.scene, case.label, number_text(case.vertices, ",.0f"), str(number), number_text(value("released_s"), ".3g", unit=" s"),
                          number_text(value("end_s"), ".3g", unit=" s"), number_text(value("released_m"), ".3f", 1000, " mm"),
                          number_text(value("left_m"), ".3g", 1000, " mm"), number_text(value("error"), ".3g", 100, "%"),
                          number_text(value("half_s"), ".3g", unit=" s") or "not yet",
                          number_text(value("twentieth_s"), ".3g", unit=" s") or "not yet", ""])
    return lines


def rest_lines(cases):
    lines = [["scene", "label", "vertices", "stable step", "step", "margin", "slowest decay", "watched at one step a tick", ""]]
    for case in cases:
        decay, step = case.number("slowest_decay_s"), figure(case.record, "report", "time_step_s")
        watched = None if decay is None or not step else decay * 5e-3 / step
        lines.append([case.scene, case.label, number_text(case.vertices, ",.0f"), seconds_text(case.number("stable_step_s")),
                      seconds_text(step), number_text(case.number("stability_margin"), ".3f"), time_text(decay), time_text(watched),
                      case.note])
    return lines


def tick_lines(cases):
    lines = [["scene", "label", "precision", "threads", "vertices", "steps", "p50", "p99", "p99.9", "worst", "missed", "of", "left over", "force",
              "reference", "its change", "off by", "set-up", "first tick", "memory", ""]]
    for case in cases:
        times = [tick_text(case.number(name)) for _, name in HOLDS]
        lines.append([case.scene, case.label, str(case.chosen("precision")), str(case.threads), number_text(case.vertices, ",.0f"),
                      number_text(case.number("steps_per_tick"), ".0f"), *times, number_text(case.number("ticks_missed"), ",.0f"),
                      number_text(case.number("ticks"), ",.0f"), number_text(case.number("residual_worst"), ".2g"),
                      number_text(case.number("held_force_size_n"), ".4f", unit=" N"),
                      number_text(case.number("reference_force_size_n"), ".4f", unit=" N"),
                      number_text(case.number("reference_force_change"), ".2f", 100, "%"), force_error_text(case),
                      time_text(case.number("setup_s")), tick_text(case.number("first_tick_s")), memory_text(case), case.note])
    return lines


def silent_lines(cases):
    return [["scene", "label", ""]] + [[case.scene, case.label, case.note] for case in cases]


def force_error_text(case):
    """The error of the force, marked where the reference cannot tell it."""
    judge = case.record.get("judge") if isinstance(case.record.get("judge"), dict) else {}
    mark = COARSE if judge.get("reference_too_coarse", True) else ""
    return number_text(case.number("force_error"), ".2f", 100, "%" + mark)


def largest_meshes(cases):
    """{(scene, label, precision, threads): {how: vertices or None}}: the last mesh before the first that misses the deadline."""
    found = {}
    for case in cases:
        key = (case.scene, case.label, str(case.chosen("precision")), case.threads)
        deadline = figure(case.record, "report", "tick_s")
        row = found.setdefault(key, {how: [None, True] for how, _ in HOLDS})
        for how, name in HOLDS:
            value = case.number(name)
            holds = value is not None and deadline is not None and value <= deadline
            row[how][1] = row[how][1] and holds
            if row[how][1]:
                row[how][0] = case.vertices
    return {key: {how: vertices for how, (vertices, _) in row.items()} for key, row in found.items()}


def largest_lines(largest):
    lines = [["scene", "label", "precision", "threads", *(how for how, _ in HOLDS), ""]]
    for (scene, label, precision, threads), row in largest.items():
        lines.append([scene, label, precision, str(threads), *(number_text(row[how], ",.0f") or "none" for how, _ in HOLDS), ""])
    return lines


def engine_text(found):
    parts = []
    if found.replays:
        parts.append("Replayed (cut: vertices times steps whose speed was cut to the limit; left over: the largest share of the forces out of balance in a step, of "
                     "integrators that iterate, where measured; set-up: model, loads and bound; memory: of the whole process)\n\n" + pad_columns(replay_lines(found.replays)))
    if any(returns_of(case) for case in found.replays):
        parts.append("Returns to rest (largest displacement of any vertex)\n\n" + pad_columns(return_lines(found.replays)))
    if found.rests:
        parts.append("At rest (the slowest decay falls to 1/e; watched: with one step each 5 ms, as the thesis's timer has it)\n\n" +
                     pad_columns(rest_lines(found.rests)))
    if found.ticks:
        text = "Ticks of a haptic loop\n\n" + pad_columns(tick_lines(found.ticks)) + TICK_NOTE
        if any(case.number("force_error") is not None for case in found.ticks):
            text += FORCE_NOTE
        parts.append(text)
        parts.append("Vertices of the largest mesh that holds the deadline\n\n" + pad_columns(largest_lines(largest_meshes(found.ticks))))
    if found.silent:
        parts.append("Methods that never answered\n\n" + pad_columns(silent_lines(found.silent)))
    return "\n\n".join(parts) if parts else "no records"


def write_table(folder, name, lines):
    write_csv(folder / name, lines[0][:-1] + ["note"], lines[1:])
    return name


def write_tables(found, folder):
    """Writes engine.txt and a CSV for each table; returns their names."""
    folder.mkdir(parents=True, exist_ok=True)
    write_atomically(folder / "engine.txt", engine_text(found) + "\n")
    names = {"engine.txt"}
    if found.replays:
        names |= {write_table(folder, "replays.csv", replay_lines(found.replays)),
                  write_table(folder, "returns.csv", return_lines(found.replays))}
    if found.rests:
        names.add(write_table(folder, "rest.csv", rest_lines(found.rests)))
    if found.silent:
        names.add(write_table(folder, "silent.csv", silent_lines(found.silent)))
    if found.ticks:
        names |= {write_table(folder, "ticks.csv", tick_lines(found.ticks)),
                  write_table(folder, "largest.csv", largest_lines(largest_meshes(found.ticks)))}
    return names

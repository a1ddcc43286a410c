"""One side of a comparison: a run folder, or a file of Google Benchmark with its repetitions.

A side has cases by name; a case has the values of each measure, one a repeat, the load at each repeat, and what tells whether its figures may be
held against another's: its answers, its input, its options.
"""

import json
import pathlib
from dataclasses import dataclass, field

from shared import load, records
from shared.run_file import read_object

TIMES = ("kernel_s", "wall_s", "user_s", "peak_rss_bytes")  # of the process: another number in every repeat
BENCHMARK_TIMES = ("real_time", "cpu_time")
SECONDS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


@dataclass(frozen=True)
class Measure:
    """A figure of a record by its place; `is_clock` if it says nothing of the answer itself."""

    name: str
    keys: tuple
    unit: str = ""
    is_clock: bool = False


@dataclass
class Case:
    name: str
    values: dict = field(default_factory=dict)  # measure -> figures
    answers: set = field(default_factory=set)  # hashes
    inputs: set = field(default_factory=set)
    options: str = ""
    outcomes: dict = field(default_factory=dict)
    loads: list = field(default_factory=list)

    @property
    def refused(self):
        """Why it has no figures that count: "2 rejected"; empty if it has."""
        bad = [f"{count} {outcome}" for outcome, count in self.outcomes.items() if outcome != "accepted"]
        return "" if "accepted" in self.outcomes else ", ".join(bad)


@dataclass
class Side:
    place: pathlib.Path
    is_run: bool
    title: str
    facts: dict  # name -> text, or a dict of such
    cases: dict
    notes: list
    load: str


def parse_measure(text, is_run):
    """NAME, or NAME:POINTER:UNIT:KIND as the program gives it, KIND being "clock" or empty."""
    parts = text.split(":")
    if len(parts) == 4 and is_run:
        keys = tuple(key.replace("~1", "/").replace("~0", "~") for key in parts[1].strip("/").split("/"))
        return Measure(parts[0], keys, parts[2], parts[3] == "clock")
    name = parts[0]
    times = TIMES if is_run else BENCHMARK_TIMES
    unit = "s" if name.endswith("_s") or name in BENCHMARK_TIMES else "bytes" if name.endswith("_bytes") else ""
    return Measure(name, (name,), unit, name in times or not is_run)


def default_measures(is_run):
    return [parse_measure(name, is_run) for name in (("kernel_s", "wall_s") if is_run else BENCHMARK_TIMES)]


# --- Runs ---------------------------------------------------------------------------------------------------------------


def identity_of(record):
    """What was asked of a case: its input, and its options with its stop."""
    mesh, scene = record.get("mesh"), record.get("scene")
    given = [mesh.get("hash") if isinstance(mesh, dict) else mesh, scene.get("problem_hash") if isinstance(scene, dict) else None]
    options = {"contestant": record.get("contestant"), "options": record.get("options"), "stop": record.get("stop"), "keep": record.get("keep") or [], "files": record.get("files") or {}}
    return json.dumps(given), json.dumps(options, sort_keys=True)


def add_record(case, record, measures):
    outcome = str(record.get("outcome"))
    case.outcomes[outcome] = case.outcomes.get(outcome, 0) + 1
    given, options = identity_of(record)
    case.inputs.add(given)
    case.options = case.options or options
    if outcome != "accepted":
        return
    case.loads.append(load.load_of(record))
    if isinstance(record.get("output_hash"), str):
        case.answers.add(record["output_hash"])
    for measure in measures:
        value = records.figure(record, *measure.keys)
        # A repeat that searched for its parameters has the search in the figures of its process.
        searched = record.get("searched") and measure.name in TIMES and measure.name != "kernel_s"
        if value is not None and not searched:
            case.values.setdefault(measure.name, []).append(value)


def sitting_commits(provenance):
    """The commits of all starts and resumptions, each once."""
    sittings = provenance.get("sittings")
    sittings = sittings if isinstance(sittings, list) and sittings else [provenance]
    texts = [f"{one.get('commit', 'unknown')}{' (changed)' if one.get('dirty') else ''}" for one in sittings if isinstance(one, dict)]
    return ", then ".join(dict.fromkeys(texts))


def chosen_text(provenance):
    """What a run was cut down to, if all its starts were."""
    sittings = provenance.get("sittings")
    chosen = [one.get("chosen") for one in sittings or [] if isinstance(one, dict)]
    if not chosen or not all(chosen):
        return "all cases"
    return "; ".join(dict.fromkeys(" ".join([*(one.get("only") or []), *([one["case"]] if one.get("case") else [])]) for one in chosen))


RUN_FACTS = ("plan_hash", "compiler", "flags", "build_type", "system", "processor", "processors", "memory", "threads", "repeats", "warmup",
             "until_width", "libraries", "programs", "files")


def run_facts(provenance):
    facts = {"commit": sitting_commits(provenance)}
    for name in RUN_FACTS:
        value = provenance.get(name)
        facts[name] = {key: str(one) for key, one in value.items()} if isinstance(value, dict) else "none" if value is None else str(value)
    facts["chosen"] = chosen_text(provenance)
    return facts


def read_run_side(folder, measures):
    notes = []
    lines = records.read_lines(folder / "records.jsonl", notes)
    provenance = records.read_provenance(folder)
    if not provenance:
        notes.append("provenance.json is missing: nothing says where its figures come from")
    cases = {}
    for record in lines:
        if record["label"] in (records.INPUT_LABEL, records.REFERENCE_LABEL) or record.get("warmup"):
            continue
        name = str(record.get("case"))
        add_record(cases.setdefault(name, Case(name)), record, measures)
    measured = [one for case in cases.values() for one in case.loads]
    at_start = provenance.get("load")
    text = load.load_text(measured) or (f"{at_start[0]:.2f} at its start" if isinstance(at_start, list) and at_start else "not known")
    plan = str(lines[0].get("plan", "")) if lines else ""
    return Side(folder, True, f"{folder} (plan {plan}, commit {sitting_commits(provenance)})", run_facts(provenance), cases, notes, text)


# --- Files of Google Benchmark ------------------------------------------------------------------------------------------


def benchmark_value(entry, name):
    value = records.figure(entry, name)
    if value is None or name not in BENCHMARK_TIMES:
        return value
    return value * SECONDS[entry["time_unit"]]


def benchmark_facts(context):
    facts = {name: str(context.get(name, "none")) for name in
             ("executable", "library_build_type", "num_cpus", "mhz_per_cpu", "cpu_scaling_enabled")}
    facts["caches"] = json.dumps(context.get("caches"), sort_keys=True)
    return facts


def read_benchmark_side(path, measures):
    data = read_object(path)
    entries, context = data.get("benchmarks"), data.get("context")
    if not isinstance(entries, list) or not isinstance(context, dict):
        raise records.BadRun(f"{path}: expected a file of Google Benchmark (--benchmark_out_format=json), found no \"context\" and \"benchmarks\"")
    cases, aggregates = {}, 0
    for place, entry in enumerate(entries):
        if not isinstance(entry, dict) or not isinstance(entry.get("name"), str):
            raise records.BadRun(f"{path}: benchmark {place}: expected an object with a name")
        if entry.get("run_type") == "aggregate":
            aggregates += 1
            continue
        if entry.get("time_unit", "ns") not in SECONDS:
            raise records.BadRun(f"{path}: {entry['name']}: time_unit: expected {', '.join(SECONDS)}, found {entry.get('time_unit')}")
        entry.setdefault("time_unit", "ns")
        name = str(entry.get("run_name", entry["name"]))
        case = cases.setdefault(name, Case(name))
        outcome = "error" if entry.get("error_occurred") else "accepted"
        case.outcomes[outcome] = case.outcomes.get(outcome, 0) + 1
        for measure in measures if outcome == "accepted" else []:
            value = benchmark_value(entry, measure.name)
            if value is not None:
                case.values.setdefault(measure.name, []).append(value)
    if not cases and aggregates:
        raise records.BadRun(f"{path}: expected single repetitions, found aggregates alone: run with --benchmark_repetitions=9 and without "
                             "--benchmark_report_aggregates_only")
    averages = context.get("load_avg")
    text = f"{averages[0]:.2f} at its start" if isinstance(averages, list) and averages else "not known"
    return Side(path, False, f"{path} (Google Benchmark)", benchmark_facts(context), cases, [], text)


def is_run_folder(place):
    return (place / "records.jsonl").is_file()


def read_sides(places, texts):
    """Both sides with their measures. Throws BadRun."""
    for place in places:
        if not is_run_folder(place) and not place.is_file():
            raise records.BadRun(f"{place}: expected a run folder (with records.jsonl) or a file of Google Benchmark, found neither")
    kinds = [is_run_folder(place) for place in places]
    if kinds[0] != kinds[1]:
        raise records.BadRun(f"{places[0]} and {places[1]}: expected two runs or two files of Google Benchmark, found one of each")
    measures = [parse_measure(text, kinds[0]) for text in texts] or default_measures(kinds[0])
    read = read_run_side if kinds[0] else read_benchmark_side
    return [read(place, measures) for place in places], measures

"""Reads a run folder: records.jsonl and provenance.json, as the runner left them. Nothing else is read.

A record is one repeat of one case. Records of the same mesh, label and sweep point form a group; within it, a case is a
seed, and a case's repeats differ in their times alone.
"""

import json
import math
import pathlib
import statistics
from dataclasses import dataclass, field

INPUT_LABEL = "input"
REFERENCE_LABEL = "reference"  # of a contest of displacements: what the answers are judged by
BUCKETS = 10
PLAN_KEYS = ("question", "claim", "meshes", "contestants", "measure", "equal_count", "comparisons", "charts",
             "contest", "scenes", "scene_sets", "targets", "cases", "reference", "beside", "frontier", "simplify")  # what of the plan the provenance repeats


RECORD, PROVENANCE = "palpate/record/1", "palpate/provenance/1"  # docs/schemas.md


class BadRun(Exception):
    """The folder is no run folder, or a file in it is not what it has to be: one line, with the place."""


@dataclass
class Group:
    """All records of one mesh, label and sweep point, in the order of the plan's cases, round by round."""

    mesh: str
    label: str
    sweep: str
    contestant: str
    records: list = field(default_factory=list)
    count_note: str = ""  # why its figures are not at equal count (equal_count.py)

    def accepted(self):
        """Accepted answers, warm-up left out."""
        return [record for record in self.records if record.get("outcome") == "accepted" and not record.get("warmup")]

    def cases(self):
        """The first accepted answer of each seed and output: what is judged is the same in every repeat, but for methods
        that do not promise the same output twice."""
        return distinct(self.accepted())

    def judged(self):
        """Accepted answers as `cases` has them; if there are none, those that were judged and rejected."""
        rejected = [record for record in self.records if record.get("outcome") == "rejected" and not record.get("warmup")]
        return self.cases() or distinct(rejected)

    def figures(self, *keys):
        """A figure of each accepted case, by its path; cases that lack it are left out."""
        return present(figure(record, *keys) for record in self.cases())

    def outcomes(self):
        """How often each outcome occurred, warm-up left out."""
        counts = {}
        for record in self.records:
            if not record.get("warmup"):
                outcome = str(record.get("outcome"))
                counts[outcome] = counts.get(outcome, 0) + 1
        return counts

    @property
    def name(self):
        return f"{self.label} ({self.sweep})" if self.sweep else self.label


def distinct(records):
    """The first record of each seed and output."""
    first = {}
    for record in records:
        first.setdefault(json.dumps([record.get("seed"), record.get("output_hash")]), record)
    return list(first.values())


@dataclass
class Run:
    folder: pathlib.Path
    plan: str
    plan_data: dict
    provenance: dict
    groups: list
    inputs: dict
    notes: list
    references: list = field(default_factory=list)  # their records, in the order of the file

    @property
    def judges_displacements(self):
        """Whether it is a contest of displacements."""
        return self.plan_data.get("contest") == "deform" or bool(self.references)

    def meshes(self):
        """Names of the meshes, in the order of the plan, else of the file."""
        return list(dict.fromkeys([*self.inputs, *(group.mesh for group in self.groups)]))

    def of_mesh(self, mesh):
        return [group for group in self.groups if group.mesh == mesh]

    def find(self, mesh, label):
        """The groups of a label on a mesh, one for each point of the sweep."""
        return [group for group in self.of_mesh(mesh) if group.label == label]

    def group_names(self):
        """Labels with their sweep points, in order, over all meshes."""
        return list(dict.fromkeys(group.name for group in self.groups))


def figure(record, *keys):
    """A number in a record by its path, or None if it is absent, null or no finite number."""
    value = record
    for key in keys:
        if not isinstance(value, dict):
            return None
        value = value.get(key)
    if isinstance(value, bool):
        return float(value)
    return value if isinstance(value, (int, float)) and math.isfinite(value) else None


def histogram(record):
    """The ten buckets of a judged mesh, or None."""
    judge = record.get("judge")
    buckets = judge.get("histogram") if isinstance(judge, dict) else None
    if isinstance(buckets, list) and len(buckets) == BUCKETS and all(isinstance(n, (int, float)) for n in buckets):
        return buckets
    return None


def present(values):
    return [value for value in values if value is not None]


def quantile(values, share):
    """The quantile of the sorted values at `share` in [0, 1], linear between neighbours."""
    ordered = sorted(values)
    place = share * (len(ordered) - 1)
    low = math.floor(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (place - low) * (ordered[high] - ordered[low])


def median(values):
    """The median, or None of nothing."""
    return statistics.median(values) if values else None


def json_fault(error):
    """What is wrong with a text that is no JSON, in one line."""
    return "lists or objects too deep within one another" if isinstance(error, RecursionError) else str(error)


def read_json(path):
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadRun(f"{path}: cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:
        raise BadRun(f"{path}: expected JSON, found {json_fault(error)}") from error
    if not isinstance(data, dict):
        raise BadRun(f"{path}: expected one JSON object")
    return data


def check_schema(data, expected, where):
    """Throws BadRun for a file of another version: its keys may mean something else."""
    if data.get("schema") != expected:
        raise BadRun(f"{where}: schema: expected {expected}, found {json.dumps(data.get('schema'))[:80]}")


def read_provenance(folder):
    """The provenance of a run; {} if it has none. Throws BadRun."""
    path = folder / "provenance.json"
    if not path.exists():
        return {}
    provenance = read_json(path)
    check_schema(provenance, PROVENANCE, path)
    return provenance


def read_lines(path, notes):
    """The records of a file. A last line that was cut off by a kill is left out, and noted."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise BadRun(f"{path}: cannot be read ({error.strerror}); is this a run folder?") from error
    except UnicodeDecodeError as error:
        raise BadRun(f"{path}: expected UTF-8 text") from error
    lines = text.split("\n")
    found = []
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        try:
            record = json.loads(line)
        except (ValueError, RecursionError) as error:
            if number == len(lines):
                notes.append("the last record was cut off and is left out: resume the run")
                continue
            raise BadRun(f"{path}:{number}: expected a JSON object, found {json_fault(error)}") from error
        if not isinstance(record, dict) or not isinstance(record.get("label"), str):
            raise BadRun(f"{path}:{number}: expected a record with a label")
        check_schema(record, RECORD, f"{path}:{number}")
        found.append(record)
    return found


def in_planned_order(lines, provenance):
    """Records round by round, each in the order of the plan's cases: rounds are run in a random order, which no table may show.
    What is no case of the plan (inputs, references) comes first; without a list of cases the order stays."""
    cases = provenance.get("cases")
    if not isinstance(cases, list):
        return lines
    places = {case: place for place, case in enumerate(cases) if isinstance(case, str)}

    def key(record):
        repeat = record.get("repeat")
        place = places.get(record.get("case"), -1)
        return (repeat if place >= 0 and isinstance(repeat, int) else -1, place)
    return sorted(lines, key=key)


def mesh_name(record):
    mesh = record.get("mesh")
    name = mesh.get("name") if isinstance(mesh, dict) else mesh
    return str(name)


def sweep_text(record):
    sweep = record.get("sweep")
    if not isinstance(sweep, dict) or not sweep:
        return ""
    return ", ".join(f"{key} {value}" for key, value in sweep.items())


def read_run(folder):
    """Reads a run folder. Throws BadRun."""
    folder = pathlib.Path(folder)
    if not folder.is_dir():
        raise BadRun(f"{folder}: no such run folder")
    notes = []
    lines = read_lines(folder / "records.jsonl", notes)
    provenance = read_provenance(folder)
    if not provenance:
        notes.append("provenance.json is missing: the plan's claim and its order are not known")
    plan_data = provenance.get("plan_data")
    if not isinstance(plan_data, dict):
        plan_data = {key: provenance[key] for key in PLAN_KEYS if key in provenance}
    groups, inputs, references = {}, {}, []
    for record in in_planned_order(lines, provenance):
        mesh = mesh_name(record)
        if record["label"] == INPUT_LABEL:
            inputs.setdefault(mesh, record)
            continue
        if record["label"] == REFERENCE_LABEL:
            references.append(record)
            continue
        key = (mesh, record["label"], sweep_text(record))
        if key not in groups:
            groups[key] = Group(*key, contestant=str(record.get("contestant", "")))
        groups[key].records.append(record)
    ordered = sort_as_planned(list(groups.values()), plan_data)
    plan = str(lines[0].get("plan", folder.name)) if lines else folder.name
    return Run(folder, plan, plan_data, provenance, ordered, inputs, notes, references)


def sort_as_planned(groups, plan_data):
    """Groups in the plan's order of meshes and labels; what it does not name keeps its place at the end."""

    def places(key, *names):
        entries = plan_data.get(key)
        entries = entries if isinstance(entries, list) else []
        order = {}
        for entry in entries:
            for name in names:
                if isinstance(entry, dict) and isinstance(entry.get(name), str):
                    order.setdefault(entry[name], len(order))
                    break
            else:
                if isinstance(entry, str):
                    order.setdefault(entry, len(order))
        return order

    meshes = places("meshes", "name") | places("scenes", "name") | places("cases", "case")
    labels = places("contestants", "label", "name", "method")
    for group in groups:
        meshes.setdefault(group.mesh, len(meshes))
        labels.setdefault(group.label, len(labels))
    return sorted(groups, key=lambda group: (meshes[group.mesh], labels[group.label]))

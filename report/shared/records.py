"""Reads a run folder: records.jsonl and provenance.json, as the runner left them. Nothing else is read.

A record is one repeat of one case. Records of the same mesh, label and sweep point form a group; within it, a case is a
seed, and a case's repeats differ in their times alone.
"""

import json
import math
import pathlib
import statistics
from array import array
from dataclasses import dataclass, field, replace

from shared.compact_record import Record, RecordPacker, check_forms
from shared.run_file import BadRun, NoNumber, are_numbers, is_number, json_fault, open_file, read_object

INPUT_LABEL = "input"
REFERENCE_LABEL = "reference"  # of a contest of displacements: what the answers are judged by
BUCKETS = 10
MOST_LINE_BYTES = 64 * 2**20  # of a record, as the runner has it
PLAN_KEYS = ("question", "claim", "meshes", "contestants", "measure", "equal_count", "comparisons", "charts",
             "contest", "scenes", "scene_sets", "targets", "cases", "reference", "beside", "frontier", "simplify")  # what of the plan the provenance repeats


RECORD, PROVENANCE = "palpate/record/1", "palpate/provenance/1"  # docs/schemas.md


@dataclass
class Group:
    """All records of one mesh, label and sweep point, in the order of the plan's cases, round by round."""

    mesh: str
    label: str
    sweep: str
    contestant: str
    records: list = field(default_factory=list)
    count_note: str = ""  # why its figures are not at equal count (equal_count.py)
    known: dict = field(default_factory=dict, repr=False, compare=False)  # what was worked out before, and of how many records

    def once(self, key, work):
        """What `work` returns; worked out again only if records were added since."""
        found = self.known.get(key)
        if found is None or found[0] != len(self.records):
            found = self.known[key] = (len(self.records), work())
        return found[1]

    def accepted(self):
        """Accepted answers, warm-up left out."""
        return self.once("accepted", lambda: [record for record in self.records if record.get("outcome") == "accepted" and not record.get("warmup")])

    def cases(self):
        """The first accepted answer of each seed and output: what is judged is the same in every repeat, but for methods
        that do not promise the same output twice."""
        return self.once("cases", lambda: distinct(self.accepted()))

    def judged(self):
        """Accepted answers as `cases` has them; if there are none, those that were judged and rejected."""
        rejected = [record for record in self.records if record.get("outcome") == "rejected" and not record.get("warmup")]
        return self.cases() or distinct(rejected)

    def figures(self, *keys):
        """A figure of each accepted case, by its path; cases that lack it are left out."""
        return list(self.once(keys, lambda: dense(present(figure(record, *keys) for record in self.cases()))))

    def shares(self):
        """Of each accepted case that has one, its histogram in percent of all tetrahedra."""
        return self.once("shares", lambda: present(shares_of(record) for record in self.cases()))

    def outcomes(self):
        """How often each outcome occurred, warm-up left out."""
        return dict(self.once("outcomes", self.count_outcomes))

    def count_outcomes(self):
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
        first.setdefault((json_mark(record.get("seed")), json_mark(record.get("output_hash"))), record)
    return list(first.values())


def json_mark(value):
    """What two values have in common if JSON writes them alike."""
    return value if value is None or type(value) in (str, int) else (json.dumps(value),)


def dense(values):
    """The values in eight bytes each where they are of one kind."""
    kinds = set(map(type, values))
    if kinds == {float}:
        return array("d", values)
    if kinds == {int} and max(map(abs, values)) < 2**63:
        return array("q", values)
    return values


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
    known: dict = field(default_factory=dict, repr=False, compare=False)  # what was looked up before, and of how many groups

    def note(self, text):
        """Adds a note that is not there yet: tables, charts and page read the same files. Paths in it are those inside the folder."""
        for folder in (self.folder.resolve(), self.folder):
            text = text.replace(f"{folder}/", "")
        if text not in self.notes:
            self.notes.append(text)

    @property
    def judges_displacements(self):
        """Whether it is a contest of displacements."""
        return self.plan_data.get("contest") == "deform" or bool(self.references)

    def meshes(self):
        """Names of the meshes, in the order of the plan, else of the file."""
        return list(dict.fromkeys([*self.inputs, *(group.mesh for group in self.groups)]))

    def of_mesh(self, mesh):
        count, found = self.known.get("of_mesh", (-1, {}))
        if count != len(self.groups):
            found = {}
            for group in self.groups:
                found.setdefault(group.mesh, []).append(group)
            self.known["of_mesh"] = (len(self.groups), found)
        return list(found.get(mesh, []))

    def of_first_meshes(self, most):
        """The run with so many of its meshes at most; the run itself if it has no more."""
        meshes = self.meshes()
        if len(meshes) <= most:
            return self
        chosen = set(meshes[:most])
        return replace(self, groups=[group for group in self.groups if group.mesh in chosen], known={},
                       inputs={mesh: record for mesh, record in self.inputs.items() if mesh in chosen})

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
        if type(value) is not Record and not isinstance(value, dict):
            return None
        value = value.get(key)
    if is_number(value):
        return value
    return float(value) if type(value) is bool else None


def histogram(record):
    """The ten buckets of a judged mesh, or None."""
    judge = record.get("judge")
    buckets = judge.get("histogram") if isinstance(judge, dict) else None
    if isinstance(buckets, list) and len(buckets) == BUCKETS and are_numbers(buckets):
        return buckets
    return None


def shares_of(record):
    """The histogram in percent of all tetrahedra, or None."""
    buckets = histogram(record) if record else None
    whole = sum(buckets) if buckets else 0
    return [100.0 * count / whole for count in buckets] if whole else None


def figures_of(records, key):
    """`figure` of each record by a key of its own, without those that lack it."""
    return [value for value in (record.get(key) for record in records) if is_number(value)]


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


def check_schema(data, expected, where):
    """Throws BadRun for a file of another version: its keys may mean something else."""
    if data.get("schema") != expected:
        raise BadRun(f"{where}: schema: expected {expected}, found {json.dumps(data.get('schema'))[:80]}")


def read_provenance(folder):
    """The provenance of a run; {} if it has none. Throws BadRun."""
    path = folder / "provenance.json"
    if not path.exists():
        return {}
    provenance = read_object(path)
    check_schema(provenance, PROVENANCE, path)
    return provenance


def read_lines(path, notes):
    """The records of a file, as each_record gives them."""
    return list(each_record(path, notes))


def each_record(path, notes):
    """The records of a file, one after the other, so that it may be larger than the memory. A last line that was cut off by a kill is left
    out, and noted. Each repeat of a case stands there once: runs that are resumed or take parts leave out what has its record."""
    packer, repeats = RecordPacker(), {}
    try:
        with open_file(path) as lines:
            for number, line in enumerate(iter(lambda: lines.readline(MOST_LINE_BYTES + 1), b""), start=1):
                if len(line) > MOST_LINE_BYTES:
                    raise BadRun(f"{path}:{number}: expected a record of at most {MOST_LINE_BYTES:,} bytes, found more")
                record = read_line(path, number, line, packer, notes)
                if record is None:
                    continue
                known = repeats.setdefault(record["case"], set())
                if record["repeat"] in known:
                    raise BadRun(f"{path}:{number}: expected each repeat of a case once, found repeat {record['repeat']} of {record['case'][:200]} again")
                known.add(record["repeat"])
                yield record
    except OSError as error:
        raise BadRun(f"{path}: cannot be read ({error.strerror})") from error


def read_line(path, number, line, packer, notes):
    """The record in a line, or None of an empty one and of a last one that was cut off."""
    if not line.strip():
        return None
    try:
        record = packer.read(line)
    except UnicodeDecodeError as error:
        raise BadRun(f"{path}: expected UTF-8 text") from error
    except NoNumber as error:
        raise BadRun(f"{path}:{number}: {error}") from error
    except (ValueError, RecursionError) as error:
        if not line.endswith(b"\n"):
            notes.append("the last record was cut off and is left out: resume the run")
            return None
        raise BadRun(f"{path}:{number}: expected a JSON object, found {json_fault(error)}") from error
    if not isinstance(record, Record):
        raise BadRun(f"{path}:{number}: expected a record with a label")
    where = f"{path}:{number}"
    check_schema(record, RECORD, where)
    check_forms(record, where)
    return record


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

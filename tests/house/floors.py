"""Enforces the floor plan of ARCHITECTURE.md from the #include lines, and prints it.

    floors.py ROOT          reads the sources below ROOT; prints each violation; exits with 1 if there is any
    floors.py ROOT --plan   prints the plan as ARCHITECTURE.md shows it

The house has wings (core/mesh, core/judge, reference, experiments, ...), a wing has rooms, a room is one folder. Lower never
includes higher: core/base < core/mesh < core/{simplify,springs,dynamics,judge} < {live,reference} < experiments, and inside a wing its
rooms in the order of PLAN. Wings of the third floor never include each other, and the judge sees core/base and
core/mesh/tet_mesh.h alone. In reference the door and what models and simplifiers share come first; a contestant's folder includes no other
one. A contest's room includes no other contest's. No file includes, over others, itself. A room has at most MOST_FILES sources and
a README.md whose first paragraph says what is in it. Nothing but tests includes tests. The report is Python that reads files: its
rooms import report/shared and themselves. The pages are TypeScript that imports nothing of other wings; page/view imports no other page.
What a sanitized build leaves out is left out by a constant, not by the preprocessor: it is compiled in every build, and so the one that
is built at night alone cannot break unseen.
"""

import collections
import pathlib
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
PAGE_IMPORT = re.compile(r"""(?:from|import)\s*\(?\s*["'](\.[^"']*)["']""")
IMPORT = re.compile(r"^\s*(?:from\s+([\w.]+)\s+import|import\s+([\w.]+))", re.MULTILINE)
OUR_FOLDERS = ("core", "live", "reference", "experiments", "tests", "report", "cmake")
MOST_FILES = 17
# The rooms of each wing from the bottom up; "." is the wing's own folder, "*" any room with the rooms inside it.
PLAN = {
    "core/base": ["."],
    "core/mesh": [".", "io", "subdivision", "shapes"],
    "core/simplify": ["quality", "sizing", "cover", "fusion", "star_kernel", "tet_operations", "skin_guard", "refined", "surface"],
    "core/springs": ["solvers", "network", "lattice", "identification", "training"],
    "core/dynamics": ["linear_algebra", "elasticity", "finite_elements", "statics", "motion", "spring_engine", "tet_engine",
                      "position_kernel", "integrators", "time_loop", "stability", "reduced", "enriched", "pod"],
    "core/judge": ["mesh", "linear_elements", "surface", "displacement", "motion"],
    "live": ["body", "interface"],
    "reference": ["door", "linear_systems", "elastic_models", "simplifier_support", "*"],
    "experiments": ["text", "files", "processes/child", "processes", "registry", "contestants", "judging", "meshes", "scene_reader", "grading", "scene_writer",
                    "spring_training", "plan_reader", "records", "rounds", "contests", "contests/*", "runner", "gates", "trials", "fit/candidates", "fit", "envelope", "campaign",
                    "live", "commands", "commands/live", "commands/campaign", "commands/scenes", "."],
    "report": ["shared", "*", "."],
    "page": ["view", "*"],
}
FLOOR = {"core/base": 0, "core/mesh": 1, "core/simplify": 2, "core/springs": 2, "core/dynamics": 2, "core/judge": 2,
         "live": 3, "reference": 3, "experiments": 4, "report": 5, "page": 5, "tests": 6}
JUDGE_MAY_SEE = "core/mesh/tet_mesh.h"
SANITIZED = re.compile(r"^\s*#.*\bPALPATE_SANITIZED\b", re.MULTILINE)
# The constant, and an attribute that the sanitizers do not bear.
SANITIZED_MAY_SEE = ("experiments/processes/child/sanitizers.h", "core/simplify/quality/batch_quality.cpp")


class Place:
    """Where a file is: its wing, the step of its room in the wing's plan, and what "*" stands for there."""

    def __init__(self, path):
        folder = pathlib.PurePosixPath(path).parent.as_posix()
        self.wing = next((wing for wing in FLOOR if folder == wing or folder.startswith(wing + "/")), None)
        self.floor = FLOOR.get(self.wing)
        self.step = self.own = None
        if self.wing not in PLAN:
            return
        room = folder[len(self.wing) + 1:] or "."
        for step, name in enumerate(PLAN[self.wing]):
            start = name[:-1]
            if room == name or (name.endswith("*") and room.startswith(start) and room not in PLAN[self.wing] and room != "."):
                self.step = step
                self.own = room[len(start):].split("/")[0] if name.endswith("*") else ""
                return


def why_forbidden(source, target):
    """Why `source` must not include `target` (both relative to the root), or an empty string."""
    here, there = Place(source), Place(target)
    if there.wing is None or here.wing is None or here.wing == "tests":
        return ""
    if there.wing == "tests":
        return "nothing sees tests"
    if here.step is None or there.step is None:
        return "a folder that is no room of the plan"
    if here.floor < there.floor:
        return f"floor {here.floor} must not see floor {there.floor}"
    if here.wing == "core/judge" and there.wing == "core/mesh" and target != JUDGE_MAY_SEE:
        return f"the judge sees core/base and {JUDGE_MAY_SEE} alone"
    if here.wing != there.wing:
        return "siblings never include each other" if here.floor == there.floor else ""
    if here.step < there.step:
        return "a lower room must not see a higher one of its wing"
    if here.step == there.step and here.own != there.own:
        return "siblings never include each other"
    return ""


def resolve(root, source, name):
    """An include as a path relative to the root: written from the root, or beside the file, or none of ours."""
    if (root / name).is_file() or name.split("/")[0] in OUR_FOLDERS:
        return name
    beside = (root / source).parent / name
    if beside.is_file():
        return beside.resolve().relative_to(root.resolve()).as_posix()
    return None


def list_sources(root):
    for folder in ("core", "live", "reference", "experiments", "tests"):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in (".h", ".cpp") and path.is_file():
                yield path.relative_to(root).as_posix()


def find_cycles(includes):
    """One line for each cycle of `includes`, from a header or source without its ending to those that it includes."""
    found, state = [], {}

    def visit(name, trail):
        state[name] = "open"
        for below in sorted(includes.get(name, ())):
            if state.get(below) == "open":
                found.append(f"{name}: a circle: {' > '.join([*trail[trail.index(below):], below])}")
            elif below not in state:
                visit(below, [*trail, below])
        state[name] = "done"

    for name in sorted(includes):
        if name not in state:
            visit(name, [name])
    return found


def check_rooms(root, sources):
    """Rooms with too many files, without a place in the plan or without a README."""
    found = []
    counts = collections.Counter(pathlib.PurePosixPath(source).parent.as_posix() for source in sources)
    for folder, files in sorted(counts.items()):
        place = Place(folder + "/a.h")
        if place.wing == "tests":
            continue
        if place.step is None:
            found.append(f"{folder}: a folder that is no room of the plan")
            continue
        if files > MOST_FILES:
            found.append(f"{folder}: {files} sources, at most {MOST_FILES} fit into a room")
        if not (root / folder / "README.md").is_file():
            found.append(f"{folder}: no README.md says what is in it")
    return found


def check_report(root):
    found = []
    rooms = {path.name for path in (root / "report").glob("*") if path.is_dir()}
    for path in sorted((root / "report").rglob("*.py")):
        name = path.relative_to(root).as_posix()
        own = path.relative_to(root / "report").parts[0]
        for match in IMPORT.finditer(path.read_text(encoding="utf-8")):
            module = (match.group(1) or match.group(2)).split(".")[0]
            if module in OUR_FOLDERS and module != "report":
                found.append(f"{name}: imports {module}: the report reads files only")
            if own in rooms and module in rooms and module not in (own, "shared"):
                found.append(f"{name}: imports {module}: siblings never import each other")
    return found


def check_pages(root):
    """Violations of the pages' scripts, and their rooms without a README."""
    found = []
    for room in sorted(path.parent for path in (root / "page").glob("*/*.ts")):
        if "node_modules" not in room.parts and not (room / "README.md").is_file():
            found.append(f"{room.relative_to(root).as_posix()}: no README.md says what is in it")
    for path in sorted((root / "page").glob("*/*.ts")):
        name = path.relative_to(root).as_posix()
        for match in PAGE_IMPORT.finditer(path.read_text(encoding="utf-8")):
            target = (path.parent / match.group(1)).resolve()
            if not target.is_relative_to((root / "page").resolve()):
                found.append(f"{name}: imports {match.group(1)}: a page imports nothing of other wings")
            elif path.parent.name == "view" and target.parent.name != "view":
                found.append(f"{name}: imports {match.group(1)}: the view is below the pages")
    return list(dict.fromkeys(found))


def check_sources(root):
    """All violations below `root`, one line each."""
    found, sources, includes = [], list(list_sources(root)), {}
    for source in sources:
        text = (root / source).read_text(encoding="utf-8")
        stem = source.rsplit(".", 1)[0]
        if SANITIZED.search(text) and source not in SANITIZED_MAY_SEE:
            found.append(f"{source}: asks for PALPATE_SANITIZED: ask for kIsSanitized ({SANITIZED_MAY_SEE[0]})")
        for match in INCLUDE.finditer(text):
            target = resolve(root, source, match.group(1))
            if not target:
                continue
            if stem != target.rsplit(".", 1)[0]:
                includes.setdefault(stem, set()).add(target.rsplit(".", 1)[0])
            reason = why_forbidden(source, target)
            if reason:
                line = text.count("\n", 0, match.start(1)) + 1
                found.append(f"{source}:{line}: includes {target}: {reason}")
    return found + find_cycles(includes) + check_rooms(root, sources) + check_report(root) + check_pages(root)


def plan_lines():
    """The plan as a table of Markdown, wing by wing."""
    lines = ["| floor | wing | rooms, from the bottom up |", "|---|---|---|"]
    for wing, rooms in PLAN.items():
        shown = ", ".join("one a contestant" if (wing, room) == ("reference", "*") else
                          "one a page" if (wing, room) == ("page", "*") else
                          "one a contest" if room.endswith("*") else room for room in rooms if room != ".")
        lines.append(f"| {FLOOR[wing]} | `{wing}` | {shown or 'one'} |")
    return lines


def check_architecture(root):
    """The lines of the plan that ARCHITECTURE.md lacks."""
    path = root / "ARCHITECTURE.md"
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    return [f"ARCHITECTURE.md: expected the line {line}" for line in plan_lines() if path.is_file() and line not in text]


def main():
    root = pathlib.Path(sys.argv[1])
    if sys.argv[2:] == ["--plan"]:
        print("\n".join(plan_lines()))
        return 0
    found = check_sources(root) + check_architecture(root)
    print("\n".join(found) if found else "every include stays on its floor or goes down")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

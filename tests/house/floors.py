"""Enforces the floors of ARCHITECTURE.md from the #include lines.

    floors.py ROOT        reads the tracked sources below ROOT; prints each violation; exits with 1 if there is any

Lower never includes higher: core/base < core/mesh < core/{simplify,springs,dynamics,judge} < reference/<one> <
experiments. Folders of the third floor never include each other, and the judge sees core/base and
core/mesh/tet_mesh.h alone. A folder of reference includes no other one, except for the door (reference/*.h). Nothing
but tests includes tests. The report is Python that reads files: it imports its own modules and no others of ours.
"""

import pathlib
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
IMPORT = re.compile(r"^\s*(?:from\s+([\w.]+)\s+import|import\s+([\w.]+))", re.MULTILINE)
OUR_FOLDERS = ("core", "reference", "experiments", "tests", "report", "cmake")
CORE_FLOORS = {"base": 0, "mesh": 1, "simplify": 2, "springs": 2, "dynamics": 2, "judge": 2}
JUDGE_MAY_SEE = "core/mesh/tet_mesh.h"


def place(path):
    """The floor of a file and the room on it: (2, "judge"), (3, "tetfusion"); None for a file that is not ours."""
    parts = pathlib.PurePosixPath(path).parts
    if parts[0] == "core":
        return (CORE_FLOORS.get(parts[1], -1), parts[1]) if len(parts) > 2 else (-1, "core")
    if parts[0] == "reference":
        return (3, parts[1] if len(parts) > 2 else "door")
    if parts[0] == "experiments":
        return (4, "experiments")
    if parts[0] == "report":
        return (5, "report")
    if parts[0] == "tests":
        return (6, "tests")
    return None


def why_forbidden(source, target):
    """Why `source` must not include `target` (both relative to the root), or an empty string."""
    here, there = place(source), place(target)
    if there is None or here is None or here[1] == "tests":
        return ""
    if -1 in (here[0], there[0]):
        return "a folder of core that has no floor"
    if there[1] == "tests":
        return "nothing sees tests"
    if here[0] < there[0]:
        return f"floor {here[0]} must not see floor {there[0]}"
    if here[1] == "judge" and there[1] == "mesh" and target != JUDGE_MAY_SEE:
        return f"the judge sees core/base and {JUDGE_MAY_SEE} alone"
    if here[0] == there[0] and here[1] != there[1] and not (here[0] == 3 and there[1] == "door"):
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


def check_sources(root):
    """All violations below `root`, one line each."""
    found = []
    for folder in ("core", "reference", "experiments", "tests"):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".h", ".cpp") or not path.is_file():
                continue
            source = path.relative_to(root).as_posix()
            for match in INCLUDE.finditer(path.read_text(encoding="utf-8")):
                target = resolve(root, source, match.group(1))
                reason = why_forbidden(source, target) if target else ""
                if reason:
                    line = path.read_text(encoding="utf-8").count("\n", 0, match.start(1)) + 1
                    found.append(f"{source}:{line}: includes {target}: {reason}")
    for path in sorted((root / "report").rglob("*.py")):
        for match in IMPORT.finditer(path.read_text(encoding="utf-8")):
            module = (match.group(1) or match.group(2)).split(".")[0]
            if module in OUR_FOLDERS and module != "report":
                found.append(f"{path.relative_to(root).as_posix()}: imports {module}: the report reads files only")
    return found


def main():
    found = check_sources(pathlib.Path(sys.argv[1]))
    print("\n".join(found) if found else "every include stays on its floor or goes down")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

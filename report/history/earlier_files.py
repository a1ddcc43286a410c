"""What an earlier history has left in a folder, which a new one takes the place of. What is somebody else's stays."""

import os
import re

from shared.run_file import BadRun, kind_of, open_file
from shared.whole_file import has_file

TABLES = {"history.csv": b"plan,case,measure,unit,started_at,", "steps.csv": b"plan,case,measure,unit,before,"}  # and how they begin
CHART = re.compile(r"step_\d\d+_.+(?<!\.part)\.(svg|png)")
CHART_MARK = b"<dc:title>palpate</dc:title>"  # of the SVG that lies beside each PNG, and is written before it
MARK_BYTES = 2**16  # how far into a chart it may stand


def require_own(path, is_own):
    if not is_own:
        raise BadRun(f"{path}: expected what an earlier history has written, which may go, found another file of that name")


def start_of(path, most):
    with open_file(path) as file:
        return file.read(most)


def earlier_charts(folder):
    """The charts of an earlier history, each PNG before its SVG. Raises: BadRun for one of such a name that is none."""
    if not os.path.lexists(folder):
        return []
    if folder.is_symlink() or not folder.is_dir():
        raise BadRun(f"{folder}: expected a folder, found {'a file' if folder.is_file() else kind_of(os.lstat(folder).st_mode)}")
    found = sorted(path for path in folder.iterdir() if CHART.fullmatch(path.name))
    for path in found:
        drawn = path.with_suffix(".svg")
        is_drawn = has_file(drawn)
        require_own(drawn if is_drawn else path, is_drawn and has_file(path) and CHART_MARK in start_of(drawn, MARK_BYTES))
    return found


def require_replaceable(folder):
    """Raises: BadRun if a file of the folder that a history would write or remove is none that a history has written."""
    for name, start in TABLES.items():
        if has_file(folder / name):
            require_own(folder / name, start_of(folder / name, len(start)) == start)
    earlier_charts(folder / "charts")

#!/usr/bin/env python3
"""Figures over many runs, and the steps in them; `palpate history` starts it.

    make_history.py --measures FILE [--out FOLDER] [--measure NAME] [--json] DIR...

FILE holds the measures as a JSON list of {name, unit, better, key, anew}; DIRs are run folders, or folders of runs. Exit codes: 0
done; 2 a folder is none, a record is broken, or FOLDER has somebody else's file where one would go; 3 matplotlib is missing, a file could
not be written, or a fault of its own.
"""

import argparse
import json
import pathlib
import sys

from history import earlier_files, history
from shared.exit_codes import guarded
from shared.run_file import BadRun, read_json
from shared.terminal import say

MOST_CHARTS = 24


def write_all(found, folder):
    """Tables and charts; returns what there is to say of them."""
    earlier_files.require_replaceable(folder)
    folder.mkdir(parents=True, exist_ok=True)
    history.write_history(found, folder)
    charts = folder / "charts"
    for old in earlier_files.earlier_charts(charts):
        old.unlink()
    if not found.found():
        return [f"Written: {folder}"]
    from history import history_charts  # needs matplotlib
    _, left_out = history_charts.draw_charts(found, charts, MOST_CHARTS)
    more = [f"note: {left_out} series with smaller steps have no chart; --measure chooses"] if left_out else []
    return [*more, f"Written: {folder}"]


def make_history(options):
    if options.out:
        earlier_files.require_replaceable(pathlib.Path(options.out))
    measures = read_json(options.measures)
    found = history.read_history(options.folders, measures, options.measure)
    if not found.runs:
        raise BadRun(found.notes[0] if found.notes else "expected runs, found none")
    try:
        said = write_all(found, pathlib.Path(options.out)) if options.out else []
    except ImportError as error:
        print(f"no charts: {error} (packages.txt: python3-matplotlib)", file=sys.stderr)
        return 3
    if options.json:
        print(json.dumps(history.describe(found), indent=2))
    else:
        say("\n".join([history.history_text(found), *said]))
    return 0


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="make_history.py", description="Figures over many runs, and the steps in them.")
    parser.add_argument("--measures", required=True)
    parser.add_argument("--out")
    parser.add_argument("--measure")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("folders", metavar="DIR", nargs="+")
    options = parser.parse_args(arguments)
    return guarded(lambda: make_history(options))


if __name__ == "__main__":
    sys.exit(main())

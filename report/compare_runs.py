#!/usr/bin/env python3
"""Two runs, or two files of Google Benchmark, against each other, case by case.

    compare_runs.py A B [--measure NAME[:POINTER:UNIT:KIND]]... [--json] [--fail-above R]

A and B are run folders, or files of `--benchmark_out_format=json` with repetitions. Exit codes: 0 compared; 1 --fail-above is given and the
interval of some ratio lies wholly above it; 2 the input is no such folder or file, they have no case in common, or nothing can be decided by
--fail-above; 3 a fault of its own.
"""

import argparse
import json
import math
import pathlib
import sys

from compare import comparison_text, pairs, sides
from shared import records
from shared.exit_codes import guarded
from shared.terminal import say


def compare(options):
    """Prints the comparison; returns the exit code. Throws BadRun."""
    places = [pathlib.Path(place) for place in (options.a, options.b)]
    (a, b), measures = sides.read_sides(places, options.measure)
    comparison = pairs.compare_sides(a, b, measures)
    if options.json:
        print(json.dumps(comparison_text.comparison_json(comparison, options.fail_above), indent=2, allow_nan=False))
    else:
        say(comparison_text.comparison_text(comparison, options.fail_above))
    if options.fail_above is None:
        return 0
    if pairs.decided(comparison)[0] == 0:
        raise records.BadRun("--fail-above: none of the pairs can be decided (see the warnings)")
    return 1 if pairs.pairs_above(comparison, options.fail_above) else 0


def positive(text):
    value = float(text)
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"expected a number above 0, found {text}")
    return value


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="compare_runs.py", description="Two runs against each other, case by case.")
    parser.add_argument("a", metavar="A")
    parser.add_argument("b", metavar="B")
    parser.add_argument("--measure", action="append", default=[], metavar="NAME")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--fail-above", type=positive, metavar="R")
    options = parser.parse_args(arguments)
    return guarded(lambda: compare(options))


if __name__ == "__main__":
    sys.exit(main())

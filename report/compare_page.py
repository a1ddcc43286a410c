#!/usr/bin/env python3
"""A page that holds several runs against a first one, case by case.

    compare_page.py RUN RUN... -o FILE [--scripts DIR]

Prints the comparisons as compare_runs.py does. Exit codes: 0 done; 2 no run, no case in common, or FILE is no place for a page; 3 the page
could not be written, or a fault of its own.
"""

import argparse
import pathlib
import sys

from compare import comparison_page, comparison_text, pairs, sides
from page import write_page
from shared.exit_codes import guarded


def compare(options):
    page = write_page.output_place(options.output)
    comparisons = []
    for place in options.runs[1:]:
        (a, b), measures = sides.read_sides([options.runs[0], place], [])
        comparisons.append(pairs.compare_sides(a, b, measures))
    for place, comparison in enumerate(comparisons):
        print(("\n" if place else "") + comparison_text.comparison_text(comparison))
    title = " and ".join([comparison_page.name_of(comparisons[0].a), ", ".join(comparison_page.name_of(comparison.b) for comparison in comparisons)])
    write_page.write_parts(comparison_page.page_parts(comparisons), f"How do these runs differ: {title}?", page, options.scripts)
    return 0


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="compare_page.py", description="A page that holds several runs against a first one.")
    parser.add_argument("runs", metavar="RUN", nargs="+", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="FILE", required=True)
    parser.add_argument("--scripts", metavar="DIR", help="where the build left the page's scripts")
    options = parser.parse_args(arguments)
    if len(options.runs) < 2:
        parser.error("at least two runs are compared")
    return guarded(lambda: compare(options), fault="report: cannot write ")


if __name__ == "__main__":
    sys.exit(main())

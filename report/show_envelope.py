#!/usr/bin/env python3
"""The chart of an envelope.

    show_envelope.py FOLDER

Reads FOLDER/envelope.json (palpate/envelope/1), writes FOLDER/envelope.svg and envelope.png. Exit codes: 0 done; 2 a file that cannot
be read; 3 matplotlib is missing, or a fault of its own.
"""

import pathlib
import sys

from shared.exit_codes import guarded
from shared.run_file import BadRun, read_object


def main(arguments):
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    folder = pathlib.Path(arguments[0])
    try:
        from envelope import envelope_chart
    except ImportError as error:
        print(f"matplotlib is missing (the package python3-matplotlib has it): {error}", file=sys.stderr)
        return 3

    def draw():
        envelope = read_object(folder / "envelope.json")
        if envelope.get("schema") != "palpate/envelope/1" or not envelope.get("axes"):
            raise BadRun(f"{folder}/envelope.json: an envelope with axes was expected")
        envelope_chart.draw_envelope(envelope, folder)
        return 0

    return guarded(draw)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

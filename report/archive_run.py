#!/usr/bin/env python3
"""Packs a run for good, or unpacks it.

    archive_run.py RUN FOLDER             FOLDER (new or empty) gets archive.json, plan.yaml, provenance.json, records.jsonl.xz
    archive_run.py --unpack ARCHIVE FOLDER    FOLDER becomes a run folder again

Exit codes: 0 done; 2 no run, no archive, a broken record, or something in FOLDER; 3 a file could not be written, or a fault of its own.
"""

import argparse
import sys

from archive import archive
from shared.exit_codes import guarded


def pack_or_unpack(options):
    if options.unpack:
        archive.unpack(options.source, options.folder)
    else:
        note = archive.pack(options.source, options.folder)
        print(f"{note['records']:,} records of {note['plan']}, {note['bytes']:,} bytes")
    return 0


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="archive_run.py", description="Packs a run for good, or unpacks it.")
    parser.add_argument("source", metavar="RUN")
    parser.add_argument("folder", metavar="FOLDER")
    parser.add_argument("--unpack", action="store_true", help="RUN is an archive, FOLDER becomes a run folder")
    options = parser.parse_args(arguments)
    return guarded(lambda: pack_or_unpack(options), fault="")


if __name__ == "__main__":
    sys.exit(main())

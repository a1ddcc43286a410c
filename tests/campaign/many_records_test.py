"""A run of a million records: its report, its gate and its resumption keep within 2 GB, count every record, and leave a page that can be opened.

    /usr/bin/python3 -B tests/campaign/many_records_test.py PALPATE [RECORDS]

PALPATE is the program. The folder takes some 3.5 GB below TMPDIR. Nothing is timed here: docs/scaling.md says what it takes, and how that was measured.
"""

import csv
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from many_records import LABELS, fail_first, make_run

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else ""
RECORDS = int(sys.argv[2]) if len(sys.argv) > 2 else 1_000_000
ROOT = pathlib.Path(__file__).resolve().parents[2]
MESHES, REPEATS = 8, 10
MOST_BYTES = 2 * 10**9  # of memory
MOST_PAGE_BYTES = 8_000_000


def contents(records):
    """How many accepted records of inputs there are and how many of answers, and a sum over what the answers say, in any order and however a number is spelled."""
    inputs, answers, total = 0, 0, 0
    with open(records, encoding="utf-8") as lines:
        for line in lines:
            record = json.loads(line)
            if record["contestant"]:
                answers += 1
                total += int.from_bytes(hashlib.blake2b(json.dumps(record, sort_keys=True).encode(), digest_size=16).digest(), "big")
            else:
                inputs += record["outcome"] == "accepted"
    return inputs, answers, total


class ManyRecords(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = cls.enterClassContext(tempfile.TemporaryDirectory(prefix="palpate-many-"))
        cls.run_folder = pathlib.Path(folder) / "many"
        cls.count = make_run(PROGRAM, cls.run_folder, RECORDS, REPEATS, MESHES)

    def palpate(self, *words):
        """Runs it; returns the most memory that it or one of its children had, in bytes."""
        with tempfile.TemporaryFile() as output:
            running = subprocess.Popen([PROGRAM, *map(str, words)], stdout=output, stderr=subprocess.STDOUT)
            _, status, usage = os.wait4(running.pid, 0)
            running.returncode = os.waitstatus_to_exitcode(status)
            output.seek(0)
            self.assertEqual(running.returncode, 0, output.read()[-3000:].decode(errors="replace"))
        return 1024 * usage.ru_maxrss

    def column(self, table, name):
        with open(self.run_folder / "tables" / table, encoding="utf-8", newline="") as stream:
            return [row[name] for row in csv.DictReader(stream)]

    def test_the_report_counts_every_record_within_two_gigabytes(self):
        self.assertGreaterEqual(self.count, RECORDS)
        memory = self.palpate("report", self.run_folder)
        print(f"report of {self.count} records: {memory / 1e6:.0f} MB")
        self.assertLess(memory, MOST_BYTES)
        answers = self.count - MESHES
        self.assertEqual(sum(map(int, self.column("timing.csv", "n"))), answers)
        self.assertEqual(sum(int(n) for n, label in zip(self.column("quality.csv", "cases"), self.column("quality.csv", "label")) if label in LABELS),
                         answers // REPEATS)
        page = self.run_folder / "report.html"
        self.assertLess(page.stat().st_size, MOST_PAGE_BYTES)
        self.assertIn(f"{self.count:,} in records.jsonl", page.read_text(encoding="utf-8"))
        done = subprocess.run(["node", ROOT / "tests" / "page" / "open_page.mjs", ROOT, page], capture_output=True, text=True, check=False)
        print(done.stdout)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_it_is_taken_up_again_within_two_gigabytes_and_nothing_is_run(self):
        records = self.run_folder / "records.jsonl"
        before = records.stat()
        memory = self.palpate("run", self.run_folder.with_suffix(".yaml"), "--out", self.run_folder, "--resume", "--no-report")
        print(f"resumption of {self.count} records: {memory / 1e6:.0f} MB")
        self.assertLess(memory, MOST_BYTES)
        self.assertEqual(records.stat().st_size, before.st_size)

    def test_it_is_held_against_accepted_figures_within_two_gigabytes(self):
        accepted = self.run_folder.with_name("accepted.json")
        memory = max(self.palpate("gate", self.run_folder, "--accepted", accepted, *more) for more in (("--update",), ("--all",)))
        print(f"gate of {self.count} records: {memory / 1e6:.0f} MB")
        self.assertLess(memory, MOST_BYTES)
        cases = (self.count - MESHES) // REPEATS
        figures = json.loads(accepted.read_text(encoding="utf-8"))["figures"]
        self.assertEqual(len(figures), MESHES + 3 * cases, "an input has its figure; a case has its outcome and its output as well")

    def test_what_failed_is_run_anew_within_two_gigabytes(self):
        records = self.run_folder / "records.jsonl"
        before = contents(records)
        fail_first(records)
        memory = self.palpate("run", self.run_folder.with_suffix(".yaml"), "--out", self.run_folder, "--resume", "--retry-failed", "--no-report")
        print(f"retried in {self.count} records: {memory / 1e6:.0f} MB")
        self.assertLess(memory, MOST_BYTES)
        self.assertEqual(len((self.run_folder / "retried.jsonl").read_bytes().splitlines()), 1)
        self.assertEqual(contents(records), before, "it has its record again, and every other says what it said")


if __name__ == "__main__":
    sys.exit(unittest.main(argv=sys.argv[:1]))

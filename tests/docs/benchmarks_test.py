#!/usr/bin/env python3
"""Each table that a benchmark's script prints of the rows in results/benchmarks is on its page, to the letter.

    benchmarks_test.py
"""

import pathlib
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DYNAMICS = ROOT / "tests" / "dynamics"
PRINTED = (
    (DYNAMICS / "spring_engine" / "speed_table.py", "wall", "speed.json", "docs/engine_speed.md"),
    (DYNAMICS / "tet_engine" / "tets_table.py", "wall", "tets.json", "docs/engine_speed.md"),
    (DYNAMICS / "position_kernel" / "sweep_table.py", "cpu", "sweep.json", "docs/integrators.md"),
)


def tables_of(text):
    """The tables in it, each as one text; empty lines and others come between."""
    blocks = "\n".join(line if line.startswith("|") else "" for line in text.splitlines()).split("\n\n")
    return [block.strip("\n") for block in blocks if block.strip("\n")]


class Benchmarks(unittest.TestCase):
    def test_pages_have_the_tables_of_the_kept_rows(self):
        for script, clock, rows, page in PRINTED:
            words = [sys.executable, "-B", script, "--clock", clock, "--read", ROOT / "results" / "benchmarks" / rows]
            done = subprocess.run(words, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            tables = tables_of(done.stdout)
            self.assertTrue(tables, script)
            written = (ROOT / page).read_text(encoding="utf-8")
            for table in tables:
                self.assertIn(table, written, f"{page}: its table is not the one of results/benchmarks/{rows}")

    def test_rows_name_no_machine(self):
        for path in (ROOT / "results" / "benchmarks").iterdir():
            text = path.read_text(encoding="utf-8")
            for word in ("host_name", "executable"):
                self.assertNotIn(word, text, path)


if __name__ == "__main__":
    unittest.main()

"""What the tests of the report share: a run folder of their own, and the report's answer to it."""

import contextlib
import csv
import io
import os
import pathlib
import sys
import tempfile
import unittest
import unittest.mock

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "report")]
import make_report


class ReportTest(unittest.TestCase):
    columns = 1000  # of the terminal: wide enough that nothing is folded (terminal_test.py has the narrow ones)

    def setUp(self):
        wide = unittest.mock.patch.dict(os.environ, {"COLUMNS": str(self.columns)})
        wide.start()
        self.addCleanup(wide.stop)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name) / "run"

    def report(self, *arguments):
        """Exit code, standard output and standard error of make_report."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = make_report.main([str(self.folder), *arguments])
        return code, out.getvalue(), err.getvalue()

    def table(self, name):
        with open(self.folder / "tables" / name, encoding="utf-8", newline="") as stream:
            return list(csv.DictReader(stream))

    def charts(self):
        return {path.name: path.read_bytes() for path in (self.folder / "charts").iterdir()}

"""Every figure that results/published/figures.yaml lists is on its page, and comes out of the archived records again; docs/methods.md does as a whole.

An entry:

    - page: README.md
      says: "by 1.8 to 3.3 points"                  # words of the page, wherever its lines break
      run: thesis_histograms                        # folder beside the list
      figures:
        - {text: "1.8", of: verdict.csv, column: difference, where: {mesh: [kidney, bean]}, take: least, times: -1}

A figure is a column of a table that the report writes, over the rows that `where` leaves: `take` is only (one row; the default), least, greatest, median,
sum, count (of rows) or rms, of more than one row without its empty cells; `times` and `plus` go upon it; `over` is the same again, divided by. It has to be `text` to the last digit that `text` has.
"""

import contextlib
import csv
import io
import math
import pathlib
import re
import statistics
import sys
import tempfile
import unittest

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "report"), str(ROOT / "docs")]
import make_methods
import make_report
from archive import archive

PUBLISHED = ROOT / "results" / "published"
KEYS = {"text", "of", "column", "where", "take", "times", "plus", "over"}
TAKE = {"least": min, "greatest": max, "median": statistics.median, "sum": math.fsum,
        "rms": lambda values: math.sqrt(statistics.fmean(value * value for value in values))}


def rows_of(table, where):
    with open(table, encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    for column, wanted in where.items():
        wanted = wanted if isinstance(wanted, list) else [wanted]
        rows = [row for row in rows if row[column] in map(str, wanted)]
    return rows


def number(cell):
    """The number that a cell begins with; tables for people have units behind it."""
    return float(re.match(r"[+-]?[\d,.]+(?:e[+-]?\d+)?", cell)[0].replace(",", ""))


def value_of(figure, tables):
    """The figure out of the tables. Raises: AssertionError if no row is left, or several where one is meant."""
    rows = rows_of(tables / figure["of"], figure.get("where", {}))
    take = figure.get("take", "only")
    if take == "count":
        value = len(rows)
    else:
        assert rows, f"no row: {figure}"
        values = [number(row[figure["column"]]) for row in rows if take == "only" or row[figure["column"]]]
        assert values and (take != "only" or len(values) == 1), f"{len(values)} rows: {figure}"
        value = values[0] if take == "only" else TAKE[take](values)
    if "over" in figure:
        value /= value_of(figure["over"], tables)
    return value * figure.get("times", 1) + figure.get("plus", 0)


def agrees(text, value):
    """Whether the text is the value, rounded to the text's own last digit."""
    digits = text.replace(",", "")
    decimals = len(digits.partition(".")[2])
    return abs(float(digits) - value) <= 0.5 * 10**-decimals * (1 + 1e-9)


def plain(text):
    return re.sub(r"\s+", " ", text)


class Published(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.entries = yaml.safe_load((PUBLISHED / "figures.yaml").read_text(encoding="utf-8"))
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.runs = {}
        for place in sorted(path for path in PUBLISHED.iterdir() if path.is_dir()):
            run = cls.runs[place.name] = pathlib.Path(folder.name) / place.name
            archive.unpack(place, run)
            said = io.StringIO()
            with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
                code = make_report.main([str(run), "--no-charts"])
            assert code <= 1, f"{place.name}: {said.getvalue()[-2000:]}"  # 1: a peer or a target is missed, and the report says so

    def test_every_figure_is_on_its_page_and_comes_out_of_its_records(self):
        for entry in self.entries:
            page = plain((ROOT / entry["page"]).read_text(encoding="utf-8"))
            with self.subTest(page=entry["page"], says=entry["says"]):
                self.assertTrue(plain(entry["says"]) in page, "the page does not say so")
                for figure in entry["figures"]:
                    self.assertLessEqual(set(figure), KEYS)
                    self.assertRegex(entry["says"], rf"(?<![\d.]){re.escape(figure['text'])}(?![\d]|\.\d)")
                    value = value_of(figure, self.runs[entry["run"]] / "tables")
                    self.assertTrue(agrees(figure["text"], value), f"{figure['text']} is {value!r} in the records: {figure}")

    def test_every_archive_is_behind_a_figure_or_a_table(self):
        used = {entry["run"] for entry in self.entries} | set(make_methods.PLANS)
        self.assertEqual(set(self.runs) - used, set())

    def test_the_page_of_methods_is_what_its_archives_make_of_it(self):
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "methods.md"
            self.assertEqual(make_methods.main([*(str(self.runs[plan]) for plan in make_methods.PLANS), "-o", str(page)]), 0)
            self.assertEqual(page.read_text(encoding="utf-8"), (ROOT / "docs" / "methods.md").read_text(encoding="utf-8"))

    def test_no_archive_names_a_place_of_the_machine_that_it_was_made_on(self):
        for name, run in self.runs.items():
            for file in (*archive.COPIED, archive.RECORDS):
                self.assertNotRegex((run / file).read_text(encoding="utf-8"), r'"/(?:home|root|tmp|work)\b', f"{name}/{file}")

    def test_a_figure_that_is_off_by_its_last_digit_is_found(self):
        for text, value, expected in (("1.8", 1.7501, True), ("1.8", 1.749, False), ("1.8", 1.851, False), ("505", 505.4, True), ("505", 505.6, False),
                                      ("1,503", 1503.0, True), ("1,503", 1504.0, False), ("2", float("nan"), False)):
            self.assertEqual(agrees(text, value), expected, (text, value))


if __name__ == "__main__":
    unittest.main()

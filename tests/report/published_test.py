"""Every figure that results/published/figures.yaml lists is on its page, and comes out of the archived records again; so does every number of the tables
that tables.yaml lists beside it, and docs/methods.md as a whole.

An entry:

    - page: README.md
      says: "by 1.8 to 3.3 points"                  # words of the page, wherever its lines break
      run: thesis_histograms                        # folder beside the list
      figures:
        - {text: "1.8", of: verdict.csv, column: difference, where: {mesh: [kidney, bean]}, take: least, times: -1}

A figure is a column of a table that the report writes, over the rows that `where` leaves: `take` is only (one row; the default), least, greatest, median,
mean, sum, count (of rows) or rms, of more than one row without its empty cells; `times` and `plus` go upon it; `over` is the same again, divided by, with `same: true` but for what it names; `inverse: true` is one over it. It has to be
`text` to the last digit that `text` has.

In tables.yaml, every number of a table of a page:

    - page: docs/displacement.md
      after: "Force of the pads"                    # the first table behind these words
      run: displacement_error
      of: displacement_sets.csv
      first: label                                  # the column whose cell a row's first cell is, without its backticks; `label` unless given
      rows: {"springs, too": opposite}              # or is called there, if it is not; or keys of its figures, {where: {...}, numbers: [...]}.
                                                    # Where rows begin alike, their first cells with " | " between them
      columns:                                      # one a column behind the first
        - {where: {set: bars, poisson_ratio: 0.25}}
      numbers:                                      # one a number of a cell, in their order
        - {column: displacement_l2_rms, times: 100}
        - {column: displacement_l2_worst, times: 100}

A number's figure is put together from the table's keys, its row's, its column's and its `numbers` entry; `where` adds up. A row or a column has `numbers` of its own if it names them; a column is null if nothing of it is
compared. `unless` lists rows (first cells) that no record is behind. A cell may have the first of its numbers alone, or none; one of them is null if it is
not compared.
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
from rounded import NUMBER, agrees

PUBLISHED = ROOT / "results" / "published"
TABLE_KEYS = {"page", "after", "run", "of", "rows", "first", "columns", "numbers", "unless", "where", "take", "times"}  # of a whole table
KEYS = {"text", "of", "column", "where", "take", "times", "plus", "over", "inverse"}
TAKE = {"least": min, "greatest": max, "median": statistics.median, "sum": math.fsum, "mean": statistics.fmean,
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


def below(figure):
    """What a figure is divided by. `same` takes over its table, column, rows and what is taken of them."""
    over = dict(figure["over"])
    if not over.pop("same", False):
        return over
    kept = {key: figure[key] for key in ("of", "column", "take") if key in figure}
    return {**kept, **over, "where": {**figure.get("where", {}), **over.get("where", {})}}


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
        value /= value_of(below(figure), tables)
    if figure.get("inverse"):
        value = 1 / value
    return value * figure.get("times", 1) + figure.get("plus", 0)


def plain(text):
    return re.sub(r"\s+", " ", text)


def table_behind(page, words):
    """The rows of the first table behind some words, each a list of cells, without its head. Raises: AssertionError if there is none."""
    assert page.count(words) == 1, f"{page.count(words)} times on its page: {words}"
    lines = [line.lstrip() for line in page.partition(words)[2].splitlines()[1:]]  # a table may stand in a list
    begin = next((at for at, line in enumerate(lines) if line.startswith("|")), None)
    assert begin is not None, f"no table behind: {words}"
    rows = []
    for line in lines[begin + 2:]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip().strip("|").split("|")])
    assert rows, f"no rows behind: {words}"
    return rows


def merged(*parts):
    """Keys of a figure from several places; `where` adds up."""
    whole = {key: value for part in parts for key, value in part.items() if key in KEYS | {"run"}}
    whole["where"] = {key: value for part in parts for key, value in part.get("where", {}).items()}
    return whole


def figures_of_table(entry, page):
    """(what cell, run, figure) for each number of a table entry. Raises: AssertionError where table and entry are not of one form."""
    assert set(entry) <= TABLE_KEYS, set(entry) - TABLE_KEYS
    rows, found = table_behind(page, entry["after"]), []
    meanings = {**entry.get("rows", {}), **dict.fromkeys(entry.get("unless", []))}
    used = set()
    for name, *cells in rows:
        key = max((key for key in meanings if (" | ".join([name, *cells]) + " | ").startswith(f"{key} | ")), key=len, default=None)
        used.add(key)
        row = name.replace("`", "") if key is None else meanings[key]
        if row is None:
            continue
        if not isinstance(row, dict):
            row = {"where": {entry.get("first", "label"): row}}
        assert len(cells) == len(entry["columns"]), f"{len(cells)} cells: {name}"
        for column, cell in zip(entry["columns"], cells):
            texts = NUMBER.findall(cell)
            if column is None or not texts:
                continue
            numbers = row.get("numbers") or column.get("numbers") or entry.get("numbers", [{}])
            assert len(texts) <= len(numbers), f"{cell!r} of {name}: expected {len(numbers)} numbers at most"
            for text, number_keys in zip(texts, numbers):
                if number_keys is None:
                    continue
                figure = merged(entry, row, column, number_keys, {"text": text})
                found.append((f"{name}: {cell}", figure.pop("run"), figure))
    assert not set(meanings) - used, f"no row {set(meanings) - used} behind: {entry['after']}"
    assert found, f"nothing is held behind: {entry['after']}"
    return found


class Published(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.entries = yaml.safe_load((PUBLISHED / "figures.yaml").read_text(encoding="utf-8"))
        cls.whole_tables = yaml.safe_load((PUBLISHED / "tables.yaml").read_text(encoding="utf-8"))
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

    def hold(self, figure, run):
        value = value_of(figure, self.runs[run] / "tables")
        self.assertTrue(agrees(figure["text"], value), f"{figure['text']} is {value!r} in the records: {figure}")

    def test_every_figure_is_on_its_page_and_comes_out_of_its_records(self):
        for entry in self.entries:
            page = plain((ROOT / entry["page"]).read_text(encoding="utf-8"))
            with self.subTest(page=entry["page"], says=entry["says"]):
                self.assertTrue(plain(entry["says"]) in page, "the page does not say so")
                for figure in entry["figures"]:
                    self.assertLessEqual(set(figure), KEYS)
                    self.assertRegex(entry["says"], rf"(?<![\d.]){re.escape(figure['text'])}(?![\d]|\.\d)")
                    self.hold(figure, entry["run"])

    def test_every_number_of_a_whole_table_comes_out_of_its_records(self):
        for entry in self.whole_tables:
            for cell, run, figure in figures_of_table(entry, (ROOT / entry["page"]).read_text(encoding="utf-8")):
                with self.subTest(page=entry["page"], after=entry["after"], cell=cell):
                    self.hold(figure, run)

    def test_a_table_that_says_another_number_is_found(self):
        page = "Behind this:\n\n| label | A | B |\n|---|---|---|\n| `one` | 1.5 / 20~ | - |\n| two | **3** to 4% | 7 |\n| other | 9 | 9 |\n"
        entry = {"page": "x", "after": "Behind this", "run": "r", "of": "t.csv", "unless": ["other"], "rows": {"two": {"where": {"label": "second", "set": "s"}}},
                 "columns": [{"where": {"nu": 1}, "numbers": [{"column": "rms"}, {"column": "worst", "times": 100}]}, {"column": "b"}]}
        self.assertEqual([(run, figure) for _, run, figure in figures_of_table(entry, page)], [
            ("r", {"of": "t.csv", "column": "rms", "where": {"label": "one", "nu": 1}, "text": "1.5"}),
            ("r", {"of": "t.csv", "column": "worst", "times": 100, "where": {"label": "one", "nu": 1}, "text": "20"}),
            ("r", {"of": "t.csv", "column": "rms", "where": {"label": "second", "set": "s", "nu": 1}, "text": "3"}),
            ("r", {"of": "t.csv", "column": "worst", "times": 100, "where": {"label": "second", "set": "s", "nu": 1}, "text": "4"}),
            ("r", {"of": "t.csv", "column": "b", "where": {"label": "second", "set": "s"}, "text": "7"})])
        for wrong in ({**entry, "unless": ["nobody"]}, {**entry, "columns": entry["columns"][:1]}, {**entry, "after": "No such words"}, {**entry, "colums": []},
                      {**entry, "columns": [{"column": "rms"}, {"column": "b"}]}):
            self.assertRaises(AssertionError, figures_of_table, wrong, page)

    def test_what_it_is_divided_by_takes_over_what_it_does_not_name(self):
        figure = {"of": "t.csv", "column": "s", "take": "least", "where": {"scene": "bar", "family": "theirs"}, "times": 2, "over": {"same": True, "where": {"family": "ours"}}}
        self.assertEqual(below(figure), {"of": "t.csv", "column": "s", "take": "least", "where": {"scene": "bar", "family": "ours"}})
        self.assertEqual(below({**figure, "over": {"of": "u.csv", "column": "s"}}), {"of": "u.csv", "column": "s"})

    def test_every_archive_is_behind_a_figure_or_a_table(self):
        used = {entry["run"] for entry in self.entries} | {part["run"] for entry in self.whole_tables for part in (entry, *filter(None, entry["columns"])) if "run" in part} | set(make_methods.PLANS)
        self.assertEqual(set(self.runs) - used, set())

    def test_the_page_of_methods_is_what_its_archives_make_of_it(self):
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "methods.md"
            self.assertEqual(make_methods.main([*(str(self.runs[plan]) for plan in make_methods.PLANS), "-o", str(page)]), 0)
            self.assertEqual(page.read_text(encoding="utf-8"), (ROOT / "docs" / "methods.md").read_text(encoding="utf-8"))

    def test_no_archive_names_a_place_of_the_machine_that_it_was_made_on(self):
        for name, run in self.runs.items():
            for file in (*archive.COPIED, archive.RECORDS):
                place = re.search(r'"/(?:home|root|tmp|work)\b[^"]*', (run / file).read_text(encoding="utf-8"))
                self.assertIsNone(place, f"{name}/{file}")

    def test_a_figure_that_is_off_by_its_last_digit_is_found(self):
        for text, value, expected in (("1.8", 1.7501, True), ("1.8", 1.749, False), ("1.8", 1.851, False), ("505", 505.4, True), ("505", 505.6, False),
                                      ("1,503", 1503.0, True), ("1,503", 1504.0, False), ("1e-10", 1.4e-10, True), ("1e-10", 1.6e-10, False), ("2", float("nan"), False)):
            self.assertEqual(agrees(text, value), expected, (text, value))


if __name__ == "__main__":
    unittest.main()

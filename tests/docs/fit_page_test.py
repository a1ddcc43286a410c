#!/usr/bin/env python3
"""The figures of docs/fit.md, "Thirty scenes" and "Ten further scenes", against the table that they are read from, results/fit_scenes.csv.

    fit_page_test.py
"""

import csv
import pathlib
import statistics
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def three_digits(value):
    return f"{value:.3g}"


def read_section(heading):
    text = (ROOT / "docs/fit.md").read_text(encoding="utf-8")
    start = text.index(f"## {heading}")
    return " ".join(text[start:text.index("\n## ", start + 1)].split())


def read_rows(numbers):
    with (ROOT / "results/fit_scenes.csv").open(encoding="utf-8") as stream:
        return [row for row in csv.DictReader(stream) if int(row["scene"]) in numbers]


class ThirtyScenes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.rows = read_rows(range(30))
        cls.section = read_section("Thirty scenes")
        cls.judged = [row for row in cls.rows if row["kept"]]

    def holds(self, sentence):
        self.assertIn(sentence, self.section)

    def test_every_scene_has_one_row_and_how_many_are_there_is_said(self):
        numbers = [int(row["scene"]) for row in self.rows]
        self.assertEqual(len(numbers), len(set(numbers)))
        if len(numbers) < 30:
            self.holds(f"{len(numbers)} of the thirty have been run so far")

    def test_tolerances(self):
        kept = [row for row in self.judged if row["kept"] == "True"]
        self.holds(f"{len(kept)} of {len(self.judged)} keep their tolerance on the five fresh loads")
        worst = max(float(row["worst_fresh_error"]) / float(row["tolerance"]) for row in self.judged)
        self.holds(f"the worst with {three_digits(100 * worst)}% of it")

    def test_promises(self):
        over = [float(row["worst_fresh_error"]) / float(row["promised_error"]) - 1 for row in self.judged]
        more = [each for each in over if each > 0]
        self.holds(f"{len(more)} of them {'leaves' if len(more) == 1 else 'leave'} more there than `fit.json` promised, by up to {three_digits(100 * max(more, default=0))}%")

    def test_costs(self):
        ratios = [float(row["ratio"]) for row in self.judged]
        self.holds(f"median {statistics.median(ratios):.2f}, {min(ratios):.2f} to {max(ratios):.2f}")
        unseen = [float(row["ratio"]) for row in self.judged if row["held_out"] == "True"]
        self.holds(f"bodies that no model was chosen on: median {statistics.median(unseen):.2f}, at most {max(unseen):.2f} ({len(unseen)} scenes)")

    def test_processors(self):
        alone = [row for row in self.rows if row["processors"] == "1"]
        others = ", ".join(row["scene"] for row in self.rows if row["processors"] != "1")
        self.holds(f"{len(alone)} of them had a processor each")
        self.holds(f"{len(self.rows) - len(alone)} had both ({others})")

    def test_confirmations(self):
        confirmed = [row for row in self.judged if int(row["confirming_loads"]) > 0]
        self.holds(f"{len(confirmed)} of the {len(self.judged)} choices are confirmed")

    def test_scenes_without_a_model(self):
        others = [row for row in self.rows if not row["kept"]]
        none = [row for row in others if row["note"] == "nothing does"]
        self.holds(f"in {len(none)} neither did")
        if len(others) > len(none):
            self.holds(f"in {len(others) - len(none)} one alone did")


class FurtherScenes(unittest.TestCase):
    def test_figures(self):
        rows, section = read_rows(range(30, 40)), read_section("Ten further scenes")
        self.assertEqual([int(row["scene"]) for row in rows], list(range(30, 40)))
        judged = [row for row in rows if row["kept"]]
        none = [row["scene"] for row in rows if row["note"] == "nothing does"]
        one = [row["scene"] for row in rows if not row["kept"] and row["note"] != "nothing does"]
        kept = [row for row in judged if row["kept"] == "True"]
        worst = max(float(row["worst_fresh_error"]) / float(row["tolerance"]) for row in judged)
        over = [row for row in judged if float(row["worst_fresh_error"]) > float(row["promised_error"])]
        ratios = [float(row["ratio"]) for row in judged]
        for sentence in (f"In {len(judged)} of them both fits found a model; in {len(none)} neither did ({', '.join(none)}:",
                         f"in {len(one)} the finer sweep alone did ({', '.join(one)},",
                         f"{len(kept)} of {len(judged)} keep their tolerance on the five fresh loads**, the worst with {three_digits(100 * worst)}% of it",
                         f"{len(over)} of them leave more there than `fit.json` promised",
                         f"median {statistics.median(ratios):.2f}, {min(ratios):.2f} to {max(ratios):.2f}"):
            self.assertIn(sentence, section)
        self.assertTrue(all(row["processors"] == "1" for row in rows))
        self.assertTrue(all(int(row["confirming_loads"]) > 0 for row in judged))


if __name__ == "__main__":
    unittest.main()

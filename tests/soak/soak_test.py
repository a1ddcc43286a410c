"""The judge of a soak rejects records that are not flat, and a soak is the same to the bit when it is run again; the page
of the soaks says what was kept of them.

    soak_test.py BUILD
"""

import contextlib
import csv
import io
import json
import pathlib
import random
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "report")]
import soak  # noqa: E402
from rounded import NUMBER, agrees  # noqa: E402

BUILD = sys.argv.pop(1) if len(sys.argv) > 1 else str(HERE.parents[1] / "build" / "release")
DEEPEST_M = 5e-3
ABOUT = {"source": "made up", "model": "springs", "engine": "springs", "vertices": 1, "tets": 1, "springs": 1, "cycles_wanted": 400,
         "step_s": 1e-3, "deepest_m": DEEPEST_M}


def made_up(cycles=400, **changes):
    """A flat record with noise; `changes` are functions of (value, share of the record) by column."""
    dice = random.Random(3)
    rows = []
    for cycle in range(1, cycles + 1):
        row = {"cycle": cycle, "simulated_s": 2.0 * cycle, "steps": 2000 * cycle, "vertex": dice.randrange(99), "depth_m": 4e-3, "slid": 0,
               "pressed_kinetic_j": 1e-9, "pressed_elastic_j": 1e-3 * dice.uniform(0.5, 1.5), "pressed_load_j": 1e-4, "pressed_force_n": 1.0,
               "pressed_largest_m": 4e-3, "pressed_inverted": 0, "rest_kinetic_j": 1e-13 * dice.uniform(0.9, 1.1), "rest_elastic_j": 1e-13,
               "rest_load_j": 0.0, "rest_largest_m": 1e-8 * dice.uniform(0.8, 1.2), "rest_mean_x_m": 1e-9 * dice.gauss(0, 1),
               "rest_mean_y_m": 1e-9 * dice.gauss(0, 1), "rest_mean_z_m": 1e-9 * dice.gauss(0, 1), "rest_inverted": 0, "broken": 0,
               "hash": f"xxh3:{cycle:032x}", "rss_bytes": 10_000_000.0, "wall_s": 0.1 * cycle}
        for name, change in changes.items():
            row[name] = change(row[name], cycle / cycles)
        rows.append(row)
    return rows


class Verdict(unittest.TestCase):
    def bad_parts(self, rows):
        verdict = soak.judge(rows, DEEPEST_M)
        bad = {name for name, part in verdict.items() if isinstance(part, dict) and not part["good"]}
        self.assertEqual(verdict["flat"], not bad)
        return bad

    def test_a_flat_record_is_flat(self):
        self.assertEqual(self.bad_parts(made_up()), set())
        self.assertEqual(self.bad_parts(made_up(40)), set())

    def test_what_is_exactly_at_rest_is_flat(self):
        at_rest = {name: lambda value, share: 0.0 for name in (*soak.OFFSETS, "rest_kinetic_j", "rest_elastic_j")}
        self.assertEqual(self.bad_parts(made_up(**at_rest)), set())

    def test_each_fault_is_found(self):
        for bad, changes in (
                ("whole", {"rest_mean_x_m": lambda value, share: float("nan") if share == 0.5 else value}),
                ("whole", {"pressed_force_n": lambda value, share: float("inf") if share == 0.5 else value}),
                ("whole", {"broken": lambda value, share: float(share == 1)}),
                ("whole", {"rest_inverted": lambda value, share: float(share == 0.25)}),
                ("energy", {"rest_kinetic_j": lambda value, share: 1e-8 if share == 0.5 else value}),
                ("energy", {"rest_kinetic_j": lambda value, share: value + 3e-11 * share}),
                ("energy", {name: lambda value, share: 0.0 for name in ("pressed_kinetic_j", "pressed_elastic_j", "pressed_load_j")}),
                ("drift", {"rest_mean_y_m": lambda value, share: value + 1e-7 * share}),
                ("drift", {"rest_largest_m": lambda value, share: value + 1e-7 * share}),
                ("drift", {"rest_largest_m": lambda value, share: 1e-6 if share == 0.5 else value}),
                ("clock", {"simulated_s": lambda value, share: value * (1 + 1e-5)}),
                ("memory", {"rss_bytes": lambda value, share: value + 2e6 * share}),
                ("memory", {"rss_bytes": lambda value, share: value + (2e6 if share > 0.9 else 0)})):
            with self.subTest(bad=bad, of=list(changes)):
                self.assertEqual(self.bad_parts(made_up(**changes)), {bad})

    def test_memory_may_settle_first(self):
        self.assertEqual(self.bad_parts(made_up(rss_bytes=lambda value, share: value - (5e6 if share < 0.05 else 0))), set())

    def test_memory_is_not_asked_of_sanitizers(self):
        growing = made_up(rss_bytes=lambda value, share: value + 2e7 * share)
        self.assertTrue(soak.judge(growing, DEEPEST_M, is_sanitized=True)["flat"])

    def test_a_short_record_is_no_verdict(self):
        self.assertEqual(self.bad_parts(made_up(39)), {"enough"})


class Command(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def soak(self, *words):
        with contextlib.redirect_stdout(io.StringIO()) as said, contextlib.redirect_stderr(io.StringIO()) as complained:
            try:
                code = soak.main([str(word) for word in words])
            except SystemExit as end:
                code = end.code
        return code, said.getvalue(), complained.getvalue()

    def write_record(self, rows):
        (self.folder / "body.json").write_text(json.dumps(ABOUT))
        with open(self.folder / "soak.csv", "w", newline="", encoding="ascii") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)

    def test_a_record_is_judged_anew(self):
        self.write_record(made_up())
        code, said, _ = self.soak("--read", self.folder)
        self.assertEqual((code, said.splitlines()[-1]), (0, "flat"))
        self.assertTrue(json.loads((self.folder / "soak.json").read_text())["verdict"]["flat"])
        self.assertTrue((self.folder / "soak.svg").exists())
        self.write_record(made_up(rss_bytes=lambda value, share: value * (1 + share)))
        code, said, _ = self.soak("--read", self.folder)
        self.assertEqual((code, said.splitlines()[-1]), (1, "NOT FLAT"))

    def test_a_record_that_is_none_is_refused(self):
        self.write_record(made_up())
        text = (self.folder / "soak.csv").read_text()
        for broken, named in ((text[:-40], "cut off"), (text.splitlines()[0] + "\n", "found none"), (text.replace("1e-09", "much"), "much")):
            (self.folder / "soak.csv").write_text(broken)
            code, _, complained = self.soak("--read", self.folder)
            self.assertEqual(code, 2)
            self.assertIn(named, complained)
            self.assertEqual(complained.count("\n"), 1)

    def test_a_short_soak_is_flat_and_the_same_again(self):
        for model in ("springs", "smoothed"):
            first, again, other = (self.folder / f"{model}_{name}" for name in ("first", "again", "other"))
            words = [BUILD, "cube:4", "--model", model, "--hours", 50 / 1800]
            code, said, complained = self.soak(*words, "-o", first)
            self.assertEqual((code, said.splitlines()[-1]), (0, "flat"), said + complained)
            rows = soak.read_record(first / "soak.csv")
            self.assertEqual(len(rows), 50)
            self.assertGreater(len({row["vertex"] for row in rows}), 20)
            self.assertGreater(min(row["pressed_largest_m"] / row["depth_m"] for row in rows), 0.1, "it is pressed")
            code, said, _ = self.soak(*words, "-o", again, "--against", first / "soak.csv")
            self.assertEqual(code, 0, said)
            self.assertEqual([row["hash"] for row in soak.read_record(again / "soak.csv")], [row["hash"] for row in rows])
            code, said, _ = self.soak(*words, "-o", other, "--seed", 2, "--against", first / "soak.csv")
            self.assertEqual(code, 1)
            self.assertEqual(json.loads((other / "soak.json").read_text())["verdict"]["same"],
                             {"good": False, "cycles_compared": 50, "first_that_differs": 1})

    def test_usage(self):
        for words, code, named in (([], 2, "BUILD"), ([BUILD, "--hours", "0"], 2, "--hours"), ([BUILD, "cube:1"], 2, "cube:N"),
                                   ([BUILD, "no/such.mesh"], 2, "no/such.mesh"), ([self.folder, "cube:4"], 3, "palpate_soak"),
                                   ([BUILD, "--model", "jelly"], 2, "jelly")):
            with self.subTest(words=words):
                ended, _, complained = self.soak(*words, *(["-o", self.folder / "out"] if words else []))
                self.assertEqual(ended, code)
                if "cube:1" not in words:  # whose message is the program's own
                    self.assertIn(named, complained)


class Page(unittest.TestCase):
    """docs/soak.md says what the kept verdicts of the two hours say (results/soak), each number to its last digit."""

    ROOT = HERE.parents[1]

    @staticmethod
    def numbers_of(kept):
        body, verdict = kept["body"], kept["verdict"]
        drift, energy, seconds = verdict["drift"], verdict["energy"], body["cycle_s"]
        axes = max((drift[f"rest_mean_{axis}_m"] for axis in "xyz"), key=lambda part: abs(part["change"]))
        cycles = verdict["enough"]["cycles"]
        return {"presses": [cycles], "simulated hours": [cycles * seconds / 3600], "steps": [cycles * seconds / body["step_s"]],
                "energy under the finger": [energy["pressed_median_j"]], "energy 1.3 s after": [energy["worst_share"]], "largest displacement at rest": [drift["worst_m"]],
                "change of the largest one": [drift["rest_largest_m"]["change"], drift["rest_largest_m"]["standard_error"]],
                "largest change of the mean": [axes["change"], axes["standard_error"]], "clock off": [verdict["clock"]["worst_off_s"]],
                "resident memory": [verdict["memory"]["settled_bytes"] / 2**20, verdict["memory"]["growth_bytes"] / 2**20],
                "presses with an inverted": [verdict["whole"]["inverted_pressed"]]}

    def test_the_table_says_what_was_kept(self):
        page = (self.ROOT / "docs" / "soak.md").read_text(encoding="utf-8")
        rows = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in page.splitlines() if line.startswith("| ")]
        for column, model in ((1, "springs"), (2, "smoothed")):
            kept = json.loads((self.ROOT / "results" / "soak" / f"{model}.json").read_text(encoding="utf-8"))
            self.assertTrue(kept["verdict"]["flat"])
            for name, values in self.numbers_of(kept).items():
                with self.subTest(model=model, row=name):
                    found = [row for row in rows if row[0] == name] or [row for row in rows if row[0].startswith(name)]
                    self.assertEqual(len(found), 1)
                    texts = NUMBER.findall(found[0][column])
                    self.assertEqual(len(texts), len(values))
                    for text, value in zip(texts, values):
                        self.assertTrue(agrees(text, value), (text, value))


if __name__ == "__main__":
    unittest.main()

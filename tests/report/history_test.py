"""Figures over many runs: which steps are found, how often one where there is none, and what is said of them."""

import contextlib
import csv
import io
import json
import math
import os
import pathlib
import random
import shutil
import sys
import tempfile
import unittest
import unittest.mock

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "report")]
import make_history
import synthetic
from history import history, steps

MEASURES = [{"name": "percent_above_0_5", "unit": "%", "better": "higher", "key": "/judge/percent_above_0_5", "anew": False},
            {"name": "kernel_s", "unit": "s", "better": "lower", "key": "/kernel_s", "anew": True}]


def naive_steps(values):
    """A rule of thumb that takes scatter for steps: a neighbour farther off than twice the standard deviation."""
    mean = sum(values) / len(values)
    deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / (len(values) - 1))
    return [place for place in range(1, len(values)) if abs(values[place] - values[place - 1]) > 2 * deviation]


class Rule(unittest.TestCase):
    def false_alarms(self, rule, draw, count, length):
        generator = random.Random(11)
        return sum(bool(rule([draw(generator) for _ in range(length)])) for _ in range(count))

    def test_steps_where_there_is_none_are_as_rare_as_the_level_says(self):
        # Of 2000 series at 1%: 20 expected, standard deviation 4.4; four of them beside. Ranks, so any distribution does.
        bound = 20 + 4 * math.sqrt(2000 * steps.LEVEL * (1 - steps.LEVEL))
        for name, draw in (("normal", lambda g: g.gauss(1, 0.05)), ("heavy tails", lambda g: g.gauss(0, 1) / (abs(g.gauss(0, 1)) + 1e-9)),
                           ("lognormal", lambda g: g.lognormvariate(0, 1)), ("many equal", lambda g: g.randrange(4))):
            with self.subTest(name):
                self.assertLessEqual(self.false_alarms(steps.scattering_steps, draw, 2000, 20), bound)
        for length in (10, 40):
            self.assertLessEqual(self.false_alarms(steps.scattering_steps, lambda g: g.gauss(0, 1), 2000, length), bound)
        self.assertGreater(self.false_alarms(naive_steps, lambda g: g.gauss(1, 0.05), 2000, 20), 10 * bound)

    def test_a_step_of_three_deviations_is_found_where_it_is(self):
        generator = random.Random(5)
        hits = 0
        for _ in range(200):
            values = [generator.gauss(10 if place < 12 else 13, 1) for place in range(24)]
            found = steps.scattering_steps(values)
            hits += len(found) == 1 and abs(found[0][0] - 12) <= 1
        self.assertGreaterEqual(hits, 190)

    def test_two_steps_and_one_run_that_went_wrong(self):
        generator = random.Random(6)
        values = [generator.gauss(1, 0.02) for _ in range(14)] + [generator.gauss(2, 0.02) for _ in range(14)] + \
                 [generator.gauss(1.5, 0.02) for _ in range(14)]
        self.assertEqual([place for place, _ in steps.scattering_steps(values)], [14, 28])
        values[5] = 40.0
        self.assertEqual([place for place, _ in steps.scattering_steps(values)], [14, 28])
        flat = [generator.gauss(1, 0.02) for _ in range(30)]
        flat[17] = 1e6
        self.assertEqual(steps.scattering_steps(flat), [])

    def test_the_statistic_by_hand(self):
        # Ranks 1..6 in order: after three the sum is 6 - 10.5 = -4.5; s^2 = 35/12, times 3 3 / 5.
        self.assertAlmostEqual(steps.split_statistics(steps.middle_ranks([3, 4, 5, 6, 7, 8]))[0][0], 4.5 / math.sqrt(35 / 12 * 9 / 5))
        self.assertEqual(list(steps.middle_ranks([5, 1, 5, 2])), [3.5, 1, 3.5, 2])
        self.assertEqual(steps.scattering_steps([1.0] * 30), [])

    def test_the_rarest_order_of_ten_is_rare_enough_and_of_nine_is_not(self):
        self.assertLessEqual(2 / math.comb(10, 5), steps.LEVEL)
        self.assertGreater(2 / math.comb(9, 4), steps.LEVEL)
        self.assertTrue(steps.scattering_steps([1.0, 1.1, 1.2, 1.3, 1.05, 9.0, 9.1, 9.2, 9.3, 9.05]))
        self.assertFalse(steps.scattering_steps([1.0, 1.1, 1.2, 1.3, 9.0, 9.1, 9.2, 9.3, 9.05]))

    def test_an_exact_series_shows_each_change_beyond_rounding(self):
        self.assertTrue(steps.is_exact([5, 7], True, False))
        self.assertFalse(steps.is_exact([5, 7], True, True))
        self.assertFalse(steps.is_exact([5, 7], False, False))
        self.assertFalse(steps.is_exact([1, 2, 3, 4, 5], True, False), "it changes in every run: it scatters")
        self.assertEqual(steps.exact_steps([5, 5 * (1 + 1e-9), 5, 7, 7]), [(3, None)])


class Runs(unittest.TestCase):
    def setUp(self):
        wide = unittest.mock.patch.dict(os.environ, {"COLUMNS": "1000"})
        wide.start()
        self.addCleanup(wide.stop)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "measures.json").write_text(json.dumps(MEASURES), encoding="utf-8")

    def add_run(self, number, lines, **other):
        run = self.folder / "runs" / f"run{number:02d}"
        run.mkdir(parents=True)
        (run / "records.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
        provenance = {"schema": "palpate/provenance/1", "plan": "made_up", "plan_data": {"measure": ["percent_above_0_5"]},
                      "started_at": f"2026-01-{number + 1:02d}T00:00:00Z", "commit": f"c{number:08d}", "dirty": False, "compiler": "g++ 12"}
        (run / "provenance.json").write_text(json.dumps({**provenance, **other}), encoding="utf-8")

    def add_runs(self, count=20, better_from=12, slower_from=14):
        generator = random.Random(7)
        for number in reversed(range(count)):  # the order of the folders is not that of the runs
            percent = 70.0 if number < better_from else 75.0
            scale = 0.010 if number < slower_from else 0.016
            lines = [synthetic.record("kidney", "a", percent, repeat=i, kernel_s=scale * generator.uniform(0.95, 1.05)) for i in range(3)]
            self.add_run(number, lines, **({"compiler": "g++ 13"} if number >= slower_from else {}))

    def call(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = make_history.main(["--measures", str(self.folder / "measures.json"), *arguments])
        return code, out.getvalue(), err.getvalue()

    def test_steps_come_the_largest_first_with_commits_and_what_else_changed(self):
        self.add_runs()
        code, out, err = self.call(str(self.folder / "runs"))
        self.assertEqual((code, err), (0, ""))
        lines = out.splitlines()
        self.assertIn("kernel_s", lines[2])
        self.assertIn("c00000013 -> c00000014", lines[2])
        self.assertIn("worse (compiler changed too)", lines[2])
        self.assertIn("+7.14%", lines[3])
        self.assertIn("c00000011 -> c00000012", lines[3])
        self.assertIn("exact  better", lines[3])
        self.assertIn("2 steps in 2 series of 20 runs; 1 of them scatter", out)

    def test_json_csv_and_charts(self):
        self.add_runs()
        out_folder = self.folder / "out"
        code, out, _ = self.call("--json", "--out", str(out_folder), str(self.folder / "runs"))
        self.assertEqual(code, 0)
        described = json.loads(out)
        self.assertEqual([step["measure"] for step in described["steps"]], ["kernel_s", "percent_above_0_5"])
        self.assertAlmostEqual(described["steps"][1]["share"], 5 / 70, 12)
        with open(out_folder / "history.csv", encoding="utf-8", newline="") as stream:
            rows = list(csv.DictReader(stream))
        self.assertEqual(len(rows), 40)
        self.assertEqual([row["commit"] for row in rows if row["step"] == "1"], ["c00000012", "c00000014"])
        charts = {path.name: path.read_bytes() for path in (out_folder / "charts").iterdir()}
        self.assertEqual(sorted(charts), ["step_01_made_up_kidney_a_None_kernel_s.png", "step_01_made_up_kidney_a_None_kernel_s.svg",
                                          "step_02_made_up_kidney_a_None_percent_above_0_5.png",
                                          "step_02_made_up_kidney_a_None_percent_above_0_5.svg"])
        self.call("--out", str(out_folder), str(self.folder / "runs"))
        self.assertEqual({path.name: path.read_bytes() for path in (out_folder / "charts").iterdir()}, charts)

    def test_what_no_history_has_written_stays(self):
        self.add_runs(count=6, better_from=3, slower_from=3)
        runs, out = str(self.folder / "runs"), self.folder / "out"
        self.assertEqual(self.call("--out", str(out), runs)[0], 0)
        svg = next((out / "charts").glob("*.svg"))
        self.assertEqual(self.call("--out", str(out), runs)[0], 0)
        for path, theirs in ((out / "history.csv", "time_s,total_j\n0,1\n"), (out / "steps.csv", "my steps\n"), (svg, "<svg>mine</svg>"),
                             (out / "charts" / "step_01_mine.png", "a photograph"), (out / "charts", "in the way")):
            with self.subTest(path.name):
                kept = self.folder / "kept"
                shutil.copytree(out, kept)
                if path.is_dir():
                    shutil.rmtree(path)
                path.write_text(theirs, encoding="utf-8")
                before = {each: each.read_bytes() for each in out.rglob("*") if each.is_file()}
                with unittest.mock.patch.object(history, "read_history", side_effect=AssertionError("work was done")):
                    code, _, err = self.call("--out", str(out), runs)
                self.assertEqual((code, err.count("\n")), (2, 1), err)
                self.assertIn(f"{path.name}: expected", err)
                self.assertEqual({each: each.read_bytes() for each in out.rglob("*") if each.is_file()}, before)
                shutil.rmtree(out)
                kept.rename(out)
        (out / "charts" / "step_by_step.png").write_text("of other things", encoding="utf-8")
        (out / "history.csv").rename(self.folder / "elsewhere.csv")
        (out / "history.csv").symlink_to(self.folder / "elsewhere.csv")
        self.assertIn("history.csv: expected a file or nothing, found a link", self.call("--out", str(out), runs)[2])
        (out / "history.csv").unlink()
        self.assertEqual(self.call("--out", str(out), runs)[0], 0)
        self.assertEqual((out / "charts" / "step_by_step.png").read_text(encoding="utf-8"), "of other things")

    def test_one_measure_alone(self):
        self.add_runs()
        _, out, _ = self.call("--measure", "percent_above_0_5", str(self.folder / "runs"))
        self.assertIn("1 steps in 1 series", out)

    def test_runs_of_one_commit_are_named_by_their_folders_and_show_a_changed_contestant(self):
        for number in range(4):
            percent = 70.0 if number < 2 else 60.0
            self.add_run(number, [synthetic.record("kidney", "a", percent)], commit="c1",
                         programs={"palpate": str(number), "mine/adapter.py": "old" if number < 2 else "new"})
        _, out, _ = self.call("--measure", "percent_above_0_5", str(self.folder / "runs"))
        self.assertIn("run01 -> run02", out)
        self.assertIn("worse (mine/adapter.py changed too)", out)

    def test_too_few_runs_of_what_scatters_are_said(self):
        self.add_runs(count=6, better_from=3, slower_from=3)
        _, out, _ = self.call(str(self.folder / "runs"))
        self.assertIn("1 steps in 1 series of 6 runs. 1 series scatter and have fewer than 10 runs", out)

    def test_a_rejected_repeat_and_warm_up_leave_no_figure(self):
        good = synthetic.record("kidney", "a", 70.0)
        self.add_run(0, [good])
        self.add_run(1, [good, synthetic.record("kidney", "a", 30.0, repeat=1, outcome="rejected")])
        self.add_run(2, [synthetic.record("kidney", "a", 10.0, warmup=True), {**good, "repeat": 1}])
        found = history.read_history([self.folder / "runs"], MEASURES, "percent_above_0_5")
        series, = found.series
        self.assertEqual([point.run.commit for point in series.points], ["c00000000", "c00000002"])
        self.assertEqual([point.values for point in series.points], [[good["judge"]["percent_above_0_5"]]] * 2)
        self.assertEqual(series.steps, [])

    def test_folders_and_records_that_are_none(self):
        empty = self.folder / "empty"
        empty.mkdir()
        self.assertEqual(self.call(str(empty))[0], 2)
        self.assertIn("found none", self.call(str(empty))[2])
        self.assertIn("found no folder", self.call(str(self.folder / "nowhere"))[2])
        self.add_run(0, [synthetic.record("kidney", "a", 70.0)], started_at=None)
        self.assertIn("does not say of which plan", self.call(str(self.folder / "runs"))[2])
        (self.folder / "runs" / "run00" / "records.jsonl").write_text("{}\n", encoding="utf-8")
        self.add_run(1, [synthetic.record("kidney", "a", 70.0)])
        (self.folder / "runs" / "run01" / "records.jsonl").write_text("{}\n", encoding="utf-8")
        self.assertIn("expected a record with a label", self.call(str(self.folder / "runs"))[2])


if __name__ == "__main__":
    unittest.main()

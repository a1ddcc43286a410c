"""No table shows the order in which cases were run; the load of the machine while they were, and what is said of it."""

import json
import random
import unittest

import support
import synthetic
from shared import load


def with_load(line, load_1min=1.0, processor_s=2.0, others_s=0.02):
    return {**line, "load_1min": load_1min, "processor_s": processor_s, "others_s": others_s}


class Order(support.ReportTest):
    def write(self, lines):
        synthetic.write_run(self.folder, lines)
        path = self.folder / "provenance.json"
        made = json.loads(path.read_text(encoding="utf-8"))
        made["cases"] = list(dict.fromkeys(line["case"] for line in self.planned if line["label"] != "input"))
        path.write_text(json.dumps(made), encoding="utf-8")

    def tables(self, lines):
        self.write(lines)
        code, out, err = self.report("--no-charts")
        self.assertEqual((code, err), (0, ""))
        return {path.name: path.read_bytes() for path in (self.folder / "tables").iterdir()}, out

    def test_tables_do_not_depend_on_the_order_of_records(self):
        whole = synthetic.thesis_records(seeds=19, repeats=3)
        sweep = [synthetic.record("kidney", "swept", 70.0 + value, case=f"kidney/swept/{value}", sweep={"fusions": value}, repeat=repeat)
                 for repeat in range(2) for value in (5, 10, 20)]
        inputs = [line for line in whole if line["label"] == "input"]
        self.planned = inputs + [line for line in whole if line["label"] != "input"] + sweep
        expected = self.tables(self.planned)
        for seed in range(3):
            run = self.planned[len(inputs):]
            random.Random(seed).shuffle(run)
            self.assertEqual(self.tables(inputs + run), expected, f"seed {seed}")


class Load(support.ReportTest):
    def notes(self, lines):
        synthetic.write_run(self.folder, lines)
        code, out, err = self.report("--no-charts")
        self.assertEqual((code, err), (0, ""))
        return [line for line in out.splitlines() if "busy machine" in line]

    def test_a_busy_machine_is_said_below_the_tables(self):
        quiet = [with_load(line) for line in synthetic.thesis_records(seeds=3)]
        self.assertEqual(self.notes(quiet), [])
        self.assertEqual(self.notes(synthetic.thesis_records(seeds=3)), [], "old records say nothing of it")
        one = [dict(line) for line in quiet]
        one[2] = with_load(one[2], 2.5, 2.0, 0.9)
        said, = self.notes(one)
        self.assertIn("load 1.00 (most 2.50)", said)
        self.assertIn("(most 45%), over 10% in 1 of ", said)
        row = next(row for row in self.table("timing.csv") if float(row["load_1min_max"] or 0) == 2.5)
        self.assertAlmostEqual(float(row["others_share"]), (0.02 * (int(row["n"]) - 1) + 0.9) / (2.0 * int(row["n"])), delta=1e-12)

    def test_shares_are_those_of_sums(self):
        short = [load.Load(1.0, 0.1, ticks) for ticks in (0.0, 0.03, -0.01, 0.02, 0.0)]  # 10 ticks each: one alone says nothing
        self.assertEqual([one.share for one in short], [None] * 5)
        self.assertAlmostEqual(load.share_of(short), 0.04 / 0.5, delta=1e-12)
        self.assertIsNone(load.share_of(short[:3]))
        self.assertEqual(load.Load(1.0, 1.0, -0.02).share, 0.0)
        self.assertEqual(load.Load(1.0, 1.0, 2.0).share, 1.0)
        self.assertIsNone(load.Load(1.0, None, None).share)
        self.assertEqual(load.load_text([load.Load(None, None, None)]), "")
        self.assertEqual(load.busy_count([load.Load(1.0, 1.0, 0.1), load.Load(1.0, 1.0, 0.11)]), 1)


if __name__ == "__main__":
    unittest.main()

"""The table of speeds: medians, ratios, verdicts and differing hashes, from rows that are made up."""

import json
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import speed_table  # noqa: E402


def row(name, ns, **more):
    return {"name": f"{name}/iterations:5/manual_time", "run_type": "iteration", "ns_per_spring": ns, "cpu_ns_per_spring": ns / 2,
            **more}


def plain(size, threads, ns, label="aa avx2"):
    return row(f"bench_plain<float>/{size}/{threads}", ns, label=label, bytes_per_spring=30.0, error_m=1e-7,
               error_relative=1e-4, across=0.1)


def data(*rows):
    return {"context": {"num_cpus": 2, "mhz_per_cpu": 2600, "load_avg": [0.1, 0.2, 0.3]}, "benchmarks": list(rows)}


def verdicts(rows, clock="wall"):
    figures = speed_table.Figures(speed_table.read_rows(data(*rows)), clock)
    return {what: (value, verdict) for what, _, value, verdict in speed_table.targets(figures)}


class SpeedTable(unittest.TestCase):
    def test_medians_and_ratios(self):
        rows = [plain(10, 1, ns) for ns in (1.52, 1.48, 1.5)] + 2 * [row("bench_pointers/10/1", 4.5)]
        found = verdicts(rows)
        self.assertEqual(found["ns a spring, 1.3k"], (1.5, "met"))
        self.assertEqual(found["pointers over ours, 1.3k"], (3.0, "met"))
        self.assertEqual(found["ns a spring, 1M"], (None, "not measured"))

    def test_a_missed_target_says_so(self):
        rows = 2 * [plain(46, 1, 3.5), plain(46, 2, 3.0)]
        found = verdicts(rows)
        self.assertEqual(found["ns a spring, 100k"], (3.5, "missed"))
        self.assertEqual(found["two threads over one, 100k"][1], "missed")
        self.assertIn("missed", speed_table.render(data(*rows), "wall"))

    def test_a_spread_above_the_margin_leaves_a_target_open(self):
        self.assertEqual(verdicts([plain(10, 1, ns) for ns in (1.5, 1.7, 2.1)])["ns a spring, 1.3k"], (1.7, "open"))
        self.assertEqual(verdicts([plain(10, 1, ns) for ns in (2.3, 2.4, 3.0)])["ns a spring, 1.3k"][1], "open")
        self.assertEqual(verdicts([plain(10, 1, ns) for ns in (1.6, 1.7, 1.8)])["ns a spring, 1.3k"][1], "met")
        # In a ratio either row may be off: 10% each way leaves 9 / 8 open.
        near = [plain(10, 1, ns) for ns in (0.95, 1.0, 1.05)] + [row("bench_bullet_springs/10/1", ns) for ns in (8.6, 9.0, 9.4)]
        self.assertEqual(verdicts(near)["Bullet's springs over ours, 1.3k"], (9.0, "open"))
        far = near[:3] + 3 * [row("bench_bullet_springs/10/1", 12.0)]
        self.assertEqual(verdicts(far)["Bullet's springs over ours, 1.3k"], (12.0, "met"))

    def test_one_repetition_has_no_spread(self):
        self.assertEqual(verdicts([plain(10, 1, 1.0)])["ns a spring, 1.3k"], (1.0, "open"))

    def test_the_roofline_is_bytes_over_bandwidth(self):
        rows = 2 * [plain(100, 1, 3.0),
                    {"name": "bench_triad/100/1/iterations:9/manual_time", "gb_per_s": 20.0, "cpu_gb_per_s": 30.0}]
        self.assertEqual(verdicts(rows)["ours over the roofline, 1M"], (2.0, "met"))

    def test_the_clock_of_the_thread_is_for_one_thread_alone(self):
        rows = 2 * [plain(46, 1, 4.0), plain(46, 2, 2.0)]
        found = verdicts(rows, "cpu")
        self.assertEqual(found["ns a spring, 100k"], (2.0, "met"))
        self.assertEqual(found["two threads over one, 100k"], (2.0, "met"))

    def test_hashes_that_differ_are_shown(self):
        same = [plain(10, 1, 1.0), plain(10, 2, 1.0), row("bench_portable/10/1", 2.0, label="aa portable")]
        self.assertIn("aa in all rows", speed_table.render(data(*same), "wall"))
        other = same + [plain(10, 2, 1.0, label="bb avx2")]
        self.assertIn("DIFFERS: aa, bb", speed_table.render(data(*other), "wall"))

    def test_aggregates_and_failures_are_left_out(self):
        rows = [plain(10, 1, 1.0), {**plain(10, 1, 7.0), "run_type": "aggregate"}, {**plain(10, 1, 7.0), "error_message": "x"}]
        self.assertEqual(verdicts(rows)["ns a spring, 1.3k"][0], 1.0)

    def test_kept_rows_make_the_same_table_and_do_not_name_the_machine(self):
        rows = [plain(size, threads, ns) for size in (10, 21) for threads in (1, 2) for ns in (1.4999999, 1.7, 2.123456789)]
        made = data(*rows, row("bench_every_force/10/2", 17.0), {**plain(10, 1, 9.0), "run_type": "aggregate"})
        made["context"] |= {"host_name": "somewhere", "executable": "/home/someone/palpate_bench"}
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "rows.json"
            speed_table.write_rows(made, path)
            text = path.read_text(encoding="utf-8")
        self.assertEqual(speed_table.render(json.loads(text), "wall"), speed_table.render(made, "wall"))
        self.assertNotIn("some", text)
        self.assertEqual(speed_table.few_digits(7090301.0), 7090301.0)


if __name__ == "__main__":
    unittest.main()

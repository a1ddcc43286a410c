"""The table of the tet engine's speeds: medians, rooflines, verdicts and differing hashes, from rows that are made up."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import tets_table  # noqa: E402


def row(name, ns, label="aa avx2"):
    return {"name": f"{name}/iterations:1/manual_time", "run_type": "iteration", "ns_per_tet": ns, "cpu_ns_per_tet": ns / 2,
            "bytes_per_tet": 60.0, "halo": 0.3, "label": label}


def triad(rate):
    return {"name": "bench_triad/100/1/iterations:1/manual_time", "run_type": "iteration", "gb_per_s": rate,
            "cpu_gb_per_s": 2 * rate}


def data(*rows):
    return {"context": {"num_cpus": 2, "mhz_per_cpu": 2600, "load_avg": [0.1]}, "benchmarks": list(rows)}


def verdicts(rows, clock="wall"):
    figures = tets_table.Figures(tets_table.read_rows(data(*rows)), clock)
    return {what: (value, verdict) for what, _, value, verdict in tets_table.targets(figures)}


class TetsTable(unittest.TestCase):
    def test_medians_and_rooflines(self):
        rows = [row("bench_tets<float>/21/1/1", ns) for ns in (4.1, 4.0, 3.9)] + 3 * [triad(30.0)]
        found = verdicts(rows)
        self.assertEqual(found["tets corotated, 10k"], (4.0, "met"))
        self.assertEqual(found["tets corotated over its roofline, 10k"], (2.0, "met"))
        self.assertEqual(found["tets linear, 10k"], (None, "not measured"))

    def test_rows_of_springs_are_none_of_it(self):
        springs = {"name": "bench_plain<float>/21/1/iterations:1/manual_time", "run_type": "iteration", "ns_per_spring": 1.5}
        self.assertEqual(tets_table.read_rows(data(springs)), {})

    def test_a_missed_target_says_so(self):
        found = verdicts(2 * [row("bench_edge_node<float>/21/1/0", 20.0)] + 2 * [triad(30.0)])
        self.assertEqual(found["edge_node linear, 10k"][1], "missed")
        self.assertEqual(found["edge_node linear over its roofline, 10k"][1], "missed")

    def test_a_margin_below_the_spread_is_open(self):
        rows = [row("bench_tets<float>/21/1/0", ns) for ns in (5.0, 7.0)] + 2 * [triad(30.0)]
        self.assertEqual(verdicts(rows)["tets linear, 10k"][1], "open")
        self.assertEqual(verdicts([row("bench_tets<float>/21/1/0", 1.0), triad(30.0)])["tets linear, 10k"][1], "open")

    def test_the_clock_of_the_thread(self):
        rows = 2 * [row("bench_tets<float>/21/1/0", 8.0)] + 2 * [triad(30.0)]
        self.assertEqual(verdicts(rows, "cpu")["tets linear, 10k"], (4.0, "met"))
        self.assertEqual(verdicts(rows, "cpu")["tets linear over its roofline, 10k"][0], 4.0)

    def test_hashes_that_differ_are_seen(self):
        same = [row("bench_tets<float>/21/1/0", 4.0), row("bench_tets<float>/21/2/0", 3.0),
                row("bench_tets_portable<float>/21/1/0", 9.0, "aa portable")]
        self.assertEqual({len(found) for found in tets_table.hashes(tets_table.read_rows(data(*same))).values()}, {1})
        other = [*same, row("bench_tets<float>/21/2/0", 3.0, "bb avx2")]
        self.assertIn("DIFFERS", tets_table.render(data(*other), "wall"))
        double = [*same, row("bench_tets<double>/21/1/0", 3.0, "bb avx2"), row("bench_tets_damped<float>/21/1/0", 3.0, "cc avx2")]
        self.assertNotIn("DIFFERS", tets_table.render(data(*double), "wall"))


if __name__ == "__main__":
    unittest.main()

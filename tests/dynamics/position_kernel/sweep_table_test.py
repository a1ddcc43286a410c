"""The table of sweeps: medians, clocks, gaps and differing hashes, from rows that are made up."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import sweep_table  # noqa: E402


def row(kernel, part, is_damped, ns, label="aa", cells=10):
    name = "spring" if part == 0 else "tet"
    return {"name": f"bench_sweep<PositionKernel::{kernel}>/{cells}/{part}/{is_damped}/iterations:1/manual_time", "run_type": "iteration", "label": label,
            f"ns_per_{name}": ns, f"cpu_ns_per_{name}": ns / 2}


def data(*rows):
    return {"context": {"num_cpus": 2, "mhz_per_cpu": 2600, "load_avg": [0.1]}, "benchmarks": list(rows)}


class SweepTable(unittest.TestCase):
    def test_medians_undamped_and_damped_by_either_clock(self):
        rows = [row("kSingle", 0, 0, ns) for ns in (30.0, 32.0, 28.0)] + [row("kSingle", 0, 1, 40.0), row("kBest", 1, 0, 50.0, cells=21)]
        self.assertRegex(sweep_table.render(data(*rows), "wall"), r"\| a spring, 1\.3k +\| 30\.0 / 40\.0 +\| - / - +\| - / - +\|")
        self.assertRegex(sweep_table.render(data(*rows), "cpu"), r"\| a spring, 1\.3k +\| 15\.0 / 20\.0 ")
        self.assertRegex(sweep_table.render(data(*rows), "wall"), r"\| a corotated tetrahedron, 10k +\| - / - +\| - / - +\| 50\.0 / - ")
        self.assertIn("13% at the most", sweep_table.render(data(*rows), "wall"))

    def test_lanes_of_either_kind_have_the_same_hashes(self):
        same = [row("kSingle", 0, 0, 30.0, "one"), row("kPortable", 0, 0, 20.0, "two"), row("kBest", 0, 0, 10.0, "two avx2")]
        self.assertNotIn("DIFFERS", sweep_table.render(data(*same), "wall"))
        other = [*same, row("kBest", 0, 0, 10.0, "three avx2")]
        self.assertIn("a spring, 1.3k, lanes: DIFFERS: three, two", sweep_table.render(data(*other), "wall"))
        self.assertEqual({len(found) for found in sweep_table.hashes(sweep_table.read_rows(data(*same))).values()}, {1})


if __name__ == "__main__":
    unittest.main()

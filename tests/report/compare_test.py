"""Two runs against each other: what is paired, what is said first, what is no comparison, and the exit codes."""

import contextlib
import io
import json
import pathlib
import unittest

import support  # finds the report
import synthetic
import compare_runs

SECONDS = [1.00, 1.01, 1.02, 1.03, 1.04, 1.05, 1.06, 1.07, 1.08]  # nine repeats


def repeats(case, scale=1.0, answer="1", count=9, **other):
    """The records of a case; its times are scaled."""
    mesh, label = case.split("/")[:2]
    return [synthetic.record(mesh, label, 80.0, repeat=place, kernel_s=scale * seconds, case=case, output_hash="xxh3:" + answer * 32,
                             load_1min=1.0, processor_s=2.0, others_s=0.02, **other)
            for place, seconds in enumerate(SECONDS[:count])]


class CompareTest(support.ReportTest):
    def write(self, name, lines, **provenance):
        folder = synthetic.write_run(self.folder.parent / name, lines)
        made = json.loads((folder / "provenance.json").read_text(encoding="utf-8"))
        made.update({"commit": "123456789", "processor": "a processor", "programs": {"palpate": "xxh3:0"}, **provenance})
        (folder / "provenance.json").write_text(json.dumps(made), encoding="utf-8")
        return folder

    def compare(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = compare_runs.main([str(argument) for argument in arguments])
        return code, out.getvalue(), err.getvalue()

    def found(self, *arguments):
        code, out, err = self.compare(*arguments, "--json")
        self.assertEqual((code, err), (0, ""))
        return json.loads(out)


class Runs(CompareTest):
    def test_cases_are_paired_and_the_most_changed_comes_first(self):
        a = self.write("a", repeats("kidney/one") + repeats("kidney/two") + repeats("kidney/three"))
        b = self.write("b", repeats("kidney/three", 0.5) + repeats("kidney/one", 1.001) + repeats("kidney/two", 1.5))
        result = self.found(a, b)["measures"][0]
        self.assertEqual([pair["case"] for pair in result["pairs"]], ["kidney/three", "kidney/two", "kidney/one"])
        self.assertEqual([pair["verdict"] for pair in result["pairs"]], ["faster", "slower", ""])
        for pair, ratio in zip(result["pairs"], (0.5, 1.5, 1.001)):
            self.assertAlmostEqual(pair["ratio"], ratio, delta=1e-12)
            self.assertLessEqual(pair["interval"]["low"], ratio)
            self.assertGreaterEqual(pair["interval"]["high"], ratio)
        self.assertAlmostEqual(result["geometric_mean"], (0.5 * 1.5 * 1.001) ** (1 / 3), delta=1e-12)
        self.assertEqual((result["below_level"], result["below_level_holm"]), (2, 2))
        self.assertAlmostEqual(result["expected_by_chance"], 0.15, delta=1e-12)

    def test_every_line_fits_and_the_differences_come_first(self):
        long_name = "kidney/" + "a_label_that_is_rather_long_" * 3 + "/tets_removed_ratio=0.22/seed=12"
        a = self.write("a", repeats("kidney/one") + repeats(long_name))
        b = self.write("b", repeats("kidney/one", 1.2) + repeats(long_name, 0.8), commit="abcdef123", flags="-O2 " + "-g " * 60,
                       processor="another", programs={"palpate": "xxh3:1"})
        code, out, err = self.compare(a, b)
        self.assertEqual((code, err), (0, ""))
        body = out[out.index("A and B differ in"):]
        self.assertLessEqual(max(map(len, body.splitlines())), 98)
        for said in ("commit: 123456789 | abcdef123", "processor: a processor | another", "programs: palpate: xxh3:0 | xxh3:1", "load in B: load 1.00"):
            self.assertIn(said, out)
            self.assertLess(out.index(said), out.index("kernel_s, B over A"))
        self.assertIn("kidney/one", out)
        self.assertIn("geometric mean 0.980 of 2 ratios; most 1.200 (kidney/one)", out)

    def test_times_of_different_answers_are_no_comparison(self):
        a = self.write("a", repeats("kidney/one") + repeats("kidney/two"))
        b = self.write("b", repeats("kidney/one", 2.0, answer="2") + repeats("kidney/two", 1.001))
        found = self.found(a, b)
        for result in found["measures"]:
            self.assertEqual([pair["case"] for pair in result["pairs"]], ["kidney/two"])
            self.assertEqual(result["no_comparison"], [{"case": "kidney/one", "why": "another answer: 11111111 in A, 22222222 in B"}])
        judged = self.found(a, b, "--measure", "mean_quality:/judge/mean_quality:1:")["measures"][0]
        self.assertEqual(len(judged["pairs"]), 2)
        self.assertEqual(self.compare(a, b, "--fail-above", 1.5)[0], 0)

    def test_answers_that_differ_by_nature_are_compared_and_said(self):
        varying = [{**line, "output_hash": f"xxh3:{place}"} for place, line in enumerate(repeats("kidney/one"))]
        found = self.found(self.write("a", varying), self.write("b", repeats("kidney/one", 1.001)))
        self.assertEqual(len(found["measures"][0]["pairs"]), 1)
        self.assertEqual(found["changed"], {"kidney/one": "answers differ between repeats (9 in A, 1 in B)"})

    def test_another_input_and_other_options(self):
        other_mesh = [{**line, "mesh": {**line["mesh"], "hash": "1"}} for line in repeats("kidney/one")]
        a = self.write("a", repeats("kidney/one") + repeats("kidney/two"))
        b = self.write("b", other_mesh + repeats("kidney/two", options={"drop": 0.5}))
        found = self.found(a, b)
        self.assertEqual(found["measures"][0]["no_comparison"], [{"case": "kidney/one", "why": "another input"}])
        self.assertEqual(found["changed"], {"kidney/two": "other options"})

    def test_what_is_in_one_alone_or_was_not_accepted(self):
        rejected = [{**line, "outcome": "rejected"} for line in repeats("kidney/two")]
        partly = repeats("kidney/four")
        partly[0]["outcome"] = "crashed"
        a = self.write("a", repeats("kidney/one") + repeats("kidney/two") + repeats("kidney/three") + partly)
        b = self.write("b", repeats("kidney/one") + rejected + repeats("kidney/five") + repeats("kidney/four"))
        found = self.found(a, b)
        self.assertEqual((found["only_in_a"], found["only_in_b"]), (["kidney/three"], ["kidney/five"]))
        self.assertEqual(found["measures"][0]["no_comparison"], [{"case": "kidney/two", "why": "B: 9 rejected"}])
        self.assertEqual(found["changed"], {"kidney/four": "1 repeats of A were not accepted, and are left out"})
        self.assertIn("in A alone, 1 cases:\n  kidney/three", self.compare(a, b)[1])

    def test_warm_ups_inputs_and_searches_do_not_count(self):
        warm = [{**line, "warmup": True} for line in repeats("kidney/one", 100.0, count=1)]
        searched = [{**line, "searched": True, "wall_s": 1000.0} for line in repeats("kidney/one", count=1)]
        after = [{**line, "repeat": line["repeat"] + 1} for line in [*searched, *repeats("kidney/one")[1:]]]
        lines = [synthetic.input_record("kidney", 90.0), *warm, *after]
        found = self.found(self.write("a", lines), self.write("b", repeats("kidney/one")))
        kernel, wall = (result["pairs"][0] for result in found["measures"])
        self.assertEqual((kernel["repeats_a"], wall["repeats_a"]), (9, 8))
        self.assertEqual(kernel["ratio"], 1.0)

    def test_few_repeats_are_said_and_decide_nothing(self):
        eight = (self.write("a8", repeats("kidney/one", count=8)), self.write("b8", repeats("kidney/one", 2.0, count=8)))
        self.assertIn("warning: kernel_s: fewer than 9 repeats in 1 of 1 pairs (least 8)", self.compare(*eight)[1])
        self.assertEqual(self.compare(*eight, "--fail-above", 1.5)[0], 1)
        for count, shown in ((3, "[1.923, 2.080] 90.0%"), (1, "none")):
            a, b = self.write("a", repeats("kidney/one", 1.0, count=count)), self.write("b", repeats("kidney/one", 2.0 * 1.02 / 1.02, count=count))
            code, out, err = self.compare(a, b, "--fail-above", 1.5)
            self.assertEqual(code, 2, out)
            self.assertIn("none of the pairs can be decided", err)
            self.assertIn("1 of 1 pairs have no interval of 95%", out)
            self.assertIn(shown if count == 1 else "90.0%", out)

    def test_fail_above_asks_for_the_whole_interval(self):
        a, b = self.write("a", repeats("kidney/one")), self.write("b", repeats("kidney/one", 1.1))
        low = self.found(a, b)["measures"][0]["pairs"][0]["interval"]["low"]
        self.assertTrue(1.0 < low < 1.1)
        self.assertEqual(self.compare(a, b, "--measure", "kernel_s", "--fail-above", low * 0.999)[0], 1)
        self.assertEqual(self.compare(a, b, "--measure", "kernel_s", "--fail-above", low * 1.001)[0], 0)
        self.assertIn("above 1.01: kernel_s of kidney/one: 1.100", self.compare(a, b, "--measure", "kernel_s", "--fail-above", 1.01)[1])

    def test_figures_without_scatter_or_above_zero(self):
        a = self.write("a", repeats("kidney/one"))
        b = self.write("b", [{**line, "judge": {**line["judge"], "mean_quality": 0.66}} for line in repeats("kidney/one")])
        pair = self.found(a, b, "--measure", "mean_quality:/judge/mean_quality:1:")["measures"][0]["pairs"][0]
        self.assertTrue(pair["no_scatter"] and pair["differs"])
        self.assertAlmostEqual(pair["ratio"], 1.1, delta=1e-12)
        self.assertEqual(self.compare(a, b, "--measure", "mean_quality:/judge/mean_quality:1:", "--fail-above", 1.05)[0], 1)
        zero = self.found(a, b, "--measure", "boundary_changed_faces:/judge/boundary_changed_faces:faces:")["measures"][0]["pairs"][0]
        self.assertEqual((zero["ratio"], zero["interval"], zero["p"]), (None, None, 1.0))
        self.assertEqual(self.compare(a, b, "--measure", "nothing:/judge/nothing:1:")[0], 2)

    def test_a_busy_machine_is_said(self):
        busy = [{**line, "load_1min": 3.0, "others_s": 1.0} for line in repeats("kidney/one")]
        out = " ".join(self.compare(self.write("a", repeats("kidney/one")), self.write("b", busy))[1].split())
        self.assertIn("load in A: load 1.00 (most 1.00); others took 1% (most 1%), over 10% in 0 of 9 repeats", out)
        self.assertIn("load in B: load 3.00 (most 3.00); others took 50% (most 50%), over 10% in 9 of 9 repeats", out)
        old = [{key: value for key, value in line.items() if not key.startswith(("load", "processor", "others"))} for line in repeats("kidney/one")]
        self.assertIn("load in A: 0.75 at its start", self.compare(self.write("c", old, load=[0.75, 1, 1]), self.write("d", old))[1])
        self.assertIn("load in B: not known", self.compare(self.write("c", old), self.write("d", old))[1])

    def test_what_is_no_input(self):
        a, b = self.write("a", repeats("kidney/one")), self.write("b", repeats("kidney/two"))
        self.assertIn("no case is in both (A has 1: kidney/one; B has 1: kidney/two)", self.compare(a, b)[2])
        self.assertEqual(self.compare(a, b)[0], 2)
        self.assertIn("expected a run folder", self.compare(a, self.folder / "nowhere")[2])
        (b / "records.jsonl").write_text("garbage\n{}\n", encoding="utf-8")
        self.assertIn("records.jsonl:1: expected a JSON object", self.compare(a, b)[2])


class Benchmarks(CompareTest):
    def entries(self, name, scale, count=9, unit="us", **other):
        made = [{"name": name, "run_name": name, "run_type": "iteration", "repetitions": count, "repetition_index": place, "threads": 1,
                 "iterations": 100, "real_time": scale * seconds, "cpu_time": 0.9 * scale * seconds, "time_unit": unit, **other}
                for place, seconds in enumerate(SECONDS[:count])]
        return made + [{"name": f"{name}_median", "run_name": name, "run_type": "aggregate", "aggregate_name": "median", "real_time": 1e9,
                        "cpu_time": 1e9, "time_unit": unit}]

    def file(self, name, entries, **context):
        path = self.folder.parent / name
        path.parent.mkdir(parents=True, exist_ok=True)
        made = {"context": {"executable": "bench", "num_cpus": 2, "load_avg": [0.5, 0.4, 0.3], "library_build_type": "release", **context},
                "benchmarks": entries}
        path.write_text(json.dumps(made), encoding="utf-8")
        return path

    def test_repetitions_are_paired_and_aggregates_are_not(self):
        a = self.file("a.json", self.entries("BM_step/8", 1.0) + self.entries("BM_set", 3.0, items_per_second=5.0))
        b = self.file("b.json", self.entries("BM_step/8", 0.0005, unit="ms") + self.entries("BM_set", 3.0, items_per_second=10.0), num_cpus=4)
        found = self.found(a, b)
        self.assertEqual([result["measure"] for result in found["measures"]], ["real_time", "cpu_time"])
        pair = found["measures"][0]["pairs"][0]
        self.assertEqual((pair["case"], pair["repeats_a"], pair["repeats_b"]), ("BM_step/8", 9, 9))
        self.assertAlmostEqual(pair["ratio"], 0.5, delta=1e-12)
        self.assertAlmostEqual(pair["median_a"], 1.04e-6, delta=1e-18)
        self.assertEqual(found["differences"], [{"what": "num_cpus", "a": "2", "b": "4"}])
        rate = self.found(a, b, "--measure", "items_per_second")["measures"][0]["pairs"]
        self.assertEqual([(one["case"], one["ratio"]) for one in rate], [("BM_set", 2.0)])
        self.assertIn("load in A: 0.50 at its start", self.compare(a, b)[1])

    def test_errors_and_files_that_cannot_be_compared(self):
        a = self.file("a.json", self.entries("BM_step", 1.0) + self.entries("BM_bad", 1.0, error_occurred=True, error_message="no"))
        self.assertEqual(self.found(a, a)["measures"][0]["no_comparison"], [{"case": "BM_bad", "why": "A: 9 error"}])
        aggregates = self.file("b.json", self.entries("BM_step", 1.0)[-1:])
        self.assertIn("found aggregates alone", self.compare(a, aggregates)[2])
        other = self.folder.parent / "c.json"
        other.write_text("{}", encoding="utf-8")
        self.assertIn("expected a file of Google Benchmark", self.compare(a, other)[2])
        self.assertIn("time_unit: expected ns, us, ms, s, found days", self.compare(a, self.file("d.json", self.entries("BM_step", 1.0, unit="days")))[2])
        run = self.write("run", repeats("kidney/one"))
        code, _, err = self.compare(a, run)
        self.assertEqual(code, 2)
        self.assertIn("found one of each", err)


if __name__ == "__main__":
    unittest.main()

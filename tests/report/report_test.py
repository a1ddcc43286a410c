"""The report on made-up records: tables, verdict, charts, and what it says of a run that is not whole."""

import json
import math
import subprocess
import sys
import unittest
from unittest import mock

from support import ReportTest, make_report
from shared import equal_count
from shared import records
import synthetic
from simplify import verdict


class Tables(ReportTest):
    def test_histogram_holds_each_bucket_and_adds_up(self):
        synthetic.write_run(self.folder, synthetic.thesis_records())
        self.assertEqual(self.report("--no-charts")[0], 0)
        rows = [row for row in self.table("histogram.csv") if (row["mesh"], row["label"]) == ("kidney", "hierarchical")]
        self.assertEqual(len(rows), 10)
        self.assertEqual(sum(int(row["tets"]) for row in rows), 6300)
        self.assertAlmostEqual(sum(float(row["percent"]) for row in rows if float(row["quality_from"]) >= 0.5), 75.0, 9)

    def test_quality_is_the_median_over_seeds_with_its_range(self):
        lines = [synthetic.record("kidney", "random", percent, seed=seed) for seed, percent in enumerate((70, 50, 80))]
        synthetic.write_run(self.folder, lines, {})
        self.report("--no-charts")
        row, = self.table("quality.csv")
        cells = [float(row[f"percent_above_0_5_{kind}"]) for kind in ("median", "min", "max")]
        self.assertEqual((cells, row["cases"]), ([70, 50, 80], "3"))

    def test_timing_leaves_out_warm_up_and_what_was_not_accepted(self):
        lines = [synthetic.record("kidney", "a", 70, repeat=i, kernel_s=s) for i, s in enumerate((0.03, 0.01, 0.02), start=1)]
        lines.append(synthetic.record("kidney", "a", 70, kernel_s=9.0, warmup=True))
        lines.append(synthetic.record("kidney", "a", 70, repeat=4, kernel_s=0.0001, outcome="rejected"))
        synthetic.write_run(self.folder, lines, {})
        self.report("--no-charts")
        row, = self.table("timing.csv")
        self.assertEqual([float(row[f"kernel_{kind}_s"]) for kind in ("median", "min", "max")], [0.02, 0.01, 0.03])
        self.assertEqual((row["n"], row["outcome"]), ("3", "3 accepted, 1 rejected"))
        self.assertAlmostEqual(float(row["tets_removed_per_s"]), 1800 / 0.02)

    def test_the_rate_is_that_of_the_median_time(self):
        synthetic.write_run(self.folder, [synthetic.record("kidney", "a", 70, seed=seed, repeat=repeat, kernel_s=seconds) for seed, times in enumerate(((0.001, 0.001, 0.001), (0.04,), (0.03,)))
                                          for repeat, seconds in enumerate(times)], {})
        self.assertEqual(self.report("--no-charts")[0], 0)
        row, = self.table("timing.csv")
        self.assertEqual(float(row["kernel_median_s"]), 0.03)  # over the seeds
        self.assertAlmostEqual(float(row["tets_removed_per_s"]), 1800 / 0.03)

    def test_memory_and_process_time_of_a_search_are_left_out_where_a_repeat_had_none(self):
        lines = [synthetic.record("kidney", "a", 70, searched=True, wall_s=9.0, peak_rss_bytes=900),
                 synthetic.record("kidney", "a", 70, repeat=1, searched=False, wall_s=1.0, peak_rss_bytes=100)]
        for chosen, wall, memory in ((lines, "1.0", "100"), (lines[:1], "9.0", "900")):
            synthetic.write_run(self.folder, chosen, {})
            self.report("--no-charts")
            row, = self.table("timing.csv")
            self.assertEqual((row["wall_median_s"], row["peak_rss_max_bytes"], row["n"]), (wall, memory, str(len(chosen))))

    def test_the_interval_of_the_median_says_its_kind_and_what_it_covers(self):
        lines = [synthetic.record("kidney", "nine", 70, repeat=i, kernel_s=0.001 * (9 - i)) for i in range(9)]
        lines += [synthetic.record("kidney", "five", 70, repeat=i, kernel_s=0.001 * (5 - i)) for i in range(5)]
        lines += [synthetic.record("kidney", "one", 70)]
        synthetic.write_run(self.folder, lines, {})
        _, out, _ = self.report("--no-charts")
        rows = {row["label"]: row for row in self.table("timing.csv")}
        cells = lambda label: [rows[label][f"kernel_median_{end}_s"] for end in ("low", "high")] + [
            rows[label]["interval_covers"], rows[label]["interval_kind"]]
        self.assertEqual(cells("nine"), ["0.002", "0.008", "0.9609375", "order statistics, 2nd to 8th of 9 repeats"])
        self.assertEqual(cells("five"), ["0.001", "0.005", "0.9375", "order statistics, 1st to 5th of 5 repeats"])
        self.assertEqual(cells("one"), ["", "", "", "none: one value"])
        self.assertIn("[2.00 ms, 8.00 ms]   96.0%", out)
        self.assertIn("[1.00 ms, 5.00 ms]   93.7%", out)

    def test_the_interval_of_a_label_with_seeds_is_over_the_seeds(self):
        lines = [synthetic.record("kidney", "a", 70, seed=seed, repeat=i, kernel_s=0.001 * seed + 0.0001 * i)
                 for seed in range(1, 7) for i in range(3)]
        synthetic.write_run(self.folder, lines, {})
        self.report("--no-charts")
        row, = self.table("timing.csv")
        self.assertEqual((row["n"], row["interval_kind"]), ("18", "order statistics, 1st to 6th of 6 seeds"))
        self.assertEqual([round(float(row[f"kernel_median_{end}_s"]), 6) for end in ("low", "high")], [0.0011, 0.0061])

    def test_validity_lists_every_outcome_and_why(self):
        lines = [synthetic.record("kidney", "a", 70),
                 synthetic.record("kidney", "b", 60, outcome="rejected", violations=["inverted_tets 3 > 0"]),
                 synthetic.record("kidney", "c", None, outcome="timed_out", message="timed out after 5 s", kernel_s=None)]
        synthetic.write_run(self.folder, lines, {})
        code, out, _ = self.report("--no-charts")
        rows = {row["label"]: row for row in self.table("validity.csv")}
        self.assertEqual(rows["b"]["violations"], "inverted_tets 3 > 0")
        self.assertEqual((rows["c"]["outcome"], rows["c"]["message"]), ("timed_out", "timed out after 5 s"))
        self.assertEqual(rows["c"]["inverted_tets"], "")
        self.assertEqual(code, 0)
        self.assertIn("1 timed_out", out)

    def test_rejections_are_listed_by_reason(self):
        synthetic.write_run(self.folder, [synthetic.record("kidney", "a", 70)], {})
        self.report("--no-charts")
        self.assertEqual({row["reason"]: row["tets"] for row in self.table("rejections.csv")},
                         {"boundary": "900", "flip": "40", "quality": "0"})

    def test_null_and_missing_figures_become_empty_cells(self):
        line = synthetic.record("kidney", "a", 70, peak_rss_bytes=None)
        del line["judge"]["mean_quality"]
        line["judge"]["min_dihedral_deg"] = None
        synthetic.write_run(self.folder, [line], {})
        self.assertEqual(self.report("--no-charts")[0], 0)
        row, = self.table("quality.csv")
        self.assertEqual((row["mean_quality_median"], row["min_dihedral_deg_median"]), ("", ""))
        self.assertEqual(self.table("timing.csv")[0]["peak_rss_max_bytes"], "")


class Verdict(ReportTest):
    CLAIM = verdict.Claim("", "", "percent_above_0_5", "a", "b", "c", 63.33, 45.71)

    def decide(self, better, than, spread, claim=None):
        return verdict.decide(claim or self.CLAIM, better, [than], spread)[0]

    def test_rule(self):
        low = [55 + 0.1 * i for i in range(39)]  # 55 to 58.8
        cases = [((80, 60, low), verdict.REPRODUCES), ((70, 61, low), verdict.REPRODUCES), ((68, 60, low), verdict.SIGN_ONLY),
                 ((80, 60, [*low[1:], 81]), verdict.REPRODUCES), ((80, 60, [*low[2:], 80, 81]), verdict.OPEN),
                 ((80, 60, [*low[6:], *[85] * 6]), verdict.DOES_NOT), ((60, 60, low), verdict.DOES_NOT),
                 ((50, 60, low), verdict.DOES_NOT), ((69, 60, []), verdict.REPRODUCES), ((80, 60, low[:18]), verdict.OPEN),
                 ((80, 60, low[:19]), verdict.REPRODUCES), ((80, 60, [90] * 3), verdict.DOES_NOT)]
        for values, expected in cases:
            self.assertEqual(self.decide(*values), expected, values)

    def test_rule_for_a_measure_where_the_published_side_is_lower(self):
        claim = verdict.Claim("", "", "kernel_s", "a", "b", "c", 1.0, 3.0)
        self.assertEqual(self.decide(1.0, 2.5, [2.4] * 19, claim), verdict.REPRODUCES)
        self.assertEqual(self.decide(1.0, 2.5, [0.9] * 19, claim), verdict.DOES_NOT)

    def test_a_difference_below_the_last_shown_digit_is_a_tie(self):
        self.assertEqual(verdict.decide(self.CLAIM, 99.934, [99.930], []), (verdict.DOES_NOT, verdict.TIE))
        self.assertEqual(verdict.decide(self.CLAIM, 99.94, [99.93], [])[0], verdict.SIGN_ONLY)
        mean = verdict.Claim("", "", "mean_quality", "a", "b", "", None, None)
        self.assertEqual([verdict.decide(mean, better, [0.6512], [])[0] for better in (0.6514, 0.65122)], [verdict.REPRODUCES, verdict.DOES_NOT])
        self.assertEqual(mean.signed(0.0002), "+0.0002")
        seconds = verdict.Claim("", "", "kernel_s", "a", "b", "", 1.0, 3.0)
        self.assertEqual(verdict.decide(seconds, 0.001, [0.003], [])[0], verdict.SIGN_ONLY)  # times have no last digit

    def test_what_is_held_against_it_may_scatter(self):
        decide = lambda values: verdict.decide(self.CLAIM, 80, values, [])[0]
        self.assertEqual(decide([60, 61, 62, 60.5, 61.5, 62.5]), verdict.REPRODUCES)
        self.assertEqual(decide([60, 61, 62, 79, 81, 82]), verdict.OPEN)
        self.assertEqual(decide([81, 82, 83, 84, 85, 86]), verdict.DOES_NOT)
        self.assertEqual(decide([60, 61]), verdict.OPEN, "two values have no 95% interval")

    def chance(self, rule, seeds, share):
        """The chance of "reproduces" if each of so many random orders is at least as good with that share: counted out."""
        return sum(math.comb(seeds, k) * share**k * (1 - share) ** (seeds - k)
                   for k in range(seeds + 1) if rule(k, seeds) == verdict.REPRODUCES)

    def test_more_seeds_do_not_make_the_rule_harder(self):
        old = lambda k, _: verdict.DOES_NOT if k else verdict.REPRODUCES  # b above the best of all seeds
        sizes = (19, 39, 79, 159, 319, 639)
        now = [self.chance(verdict.rank_state, n, 0.01) for n in sizes]
        self.assertTrue(all(after >= before - 0.06 for before, after in zip(now, now[1:])), now)
        self.assertTrue(now[0] > 0.8 and now[-1] > 0.999, now)
        before = [self.chance(old, n, 0.01) for n in sizes]
        self.assertTrue(before[0] > 0.8 and before[-1] < 0.002, "the old rule has to fail this test")

    def test_an_order_that_is_no_better_than_random_passes_as_rarely_at_any_number_of_seeds(self):
        # Drawn from the random ones itself, it is at most k-th among n with the chance (k + 1) / (n + 1).
        for n in (19, 39, 40, 99, 400, 999):
            passed = sum(verdict.rank_state(k, n) == verdict.REPRODUCES for k in range(n + 1)) / (n + 1)
            self.assertTrue(0.05 - 1 / (n + 1) < passed <= 0.05, (n, passed))

    def test_what_is_refuted_is_so_for_certain(self):
        # If just 5% of the orders are as good, "does not reproduce" is wrong in at most 2.5%.
        for n in (10, 40, 200):
            wrong = sum(math.comb(n, k) * 0.05**k * 0.95 ** (n - k) for k in range(n + 1)
                        if verdict.rank_state(k, n) == verdict.DOES_NOT)
            self.assertLessEqual(wrong, 0.025)

    def test_against_the_claim(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(better=75, than=80))
        _, out, _ = self.report("--no-charts")
        self.assertIn("kidney: hierarchical 75.00 (6300 tets), sequential 80.00 (6300 tets): -5.00 points", out)
        self.assertIn("63.33 against 45.71 (+17.62 points)", out)
        self.assertIn("Verdict: the claim does not reproduce.", out)
        self.assertEqual((self.folder / "tables" / "verdict.txt").read_text(encoding="utf-8").strip(),
                         out[out.index("Claim:"):].strip())
        rows = self.table("verdict.csv")
        self.assertEqual([row["verdict"] for row in rows], [verdict.DOES_NOT] * 2)
        self.assertAlmostEqual(float(rows[0]["difference"]), -5.0, 6)
        self.assertEqual((rows[0]["spread_n"], rows[0]["at_least_as_good"], float(rows[0]["rank_chance"])), ("39", "39", 1.0))
        self.assertIn("78 of 78 are at least as good as hierarchical (95.4% to 100.0% of all; rank test p = 1)", out)

    def test_a_claim_that_the_provenance_holds_itself(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(), {})
        (self.folder / "provenance.json").write_text(json.dumps({"schema": "palpate/provenance/1", **synthetic.PLAN}), encoding="utf-8")
        self.assertIn("Verdict: the claim does not reproduce.", self.report("--no-charts")[1])

    def test_for_the_claim(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(better=80, than=60, spread=(55, 65)))
        self.assertIn("Verdict: the claim reproduces.", self.report("--no-charts")[1])

    def test_a_claim_that_is_required_decides_the_exit_code(self):
        plan = {**synthetic.PLAN, "claim": {**synthetic.PLAN["claim"], "required": True}}
        for better, code, said in ((80, 0, None), (66, 1, "it reproduces in sign only"), (50, 1, "it does not reproduce")):
            lines = synthetic.thesis_records(better=better, than=60, spread=(55, 65))
            synthetic.write_run(self.folder, lines, plan)
            found, out, _ = self.report("--no-charts")
            self.assertEqual(found, code, out)
            last = "required, and does not hold: the claim that hierarchical beats sequential: "
            self.assertEqual(out.strip().splitlines()[-1] == f"{last}{said}", code == 1)
        synthetic.write_run(self.folder, [], plan)
        self.assertEqual(self.report("--no-charts")[0], 1, "what was not run does not hold")

    def test_in_sign_only_if_one_mesh_is_weaker(self):
        lines = synthetic.thesis_records(better=80, than=60, spread=(55, 65), meshes=("kidney",))
        lines += synthetic.thesis_records(better=66, than=60, spread=(59, 61), meshes=("bean",))
        synthetic.write_run(self.folder, lines)
        self.assertIn("Verdict: the claim reproduces in sign only.", self.report("--no-charts")[1])

    def test_without_an_accepted_answer_it_is_not_decided(self):
        lines = [line for line in synthetic.thesis_records(meshes=("kidney",)) if line["label"] != "sequential"]
        lines.append(synthetic.record("kidney", "sequential", None, outcome="crashed"))
        synthetic.write_run(self.folder, lines)
        code, out, _ = self.report("--no-charts")
        self.assertEqual(code, 0)
        self.assertIn("kidney: cannot be decided: no accepted answer of sequential (1 crashed).", out)
        self.assertNotIn("Verdict:", out)

    def test_variants_are_compared_with_the_claims_side(self):
        lines = synthetic.thesis_records(meshes=("kidney",))
        lines += [synthetic.record("kidney", "small", 74), synthetic.record("kidney", "large", 90)]
        synthetic.write_run(self.folder, lines)
        _, out, _ = self.report("--no-charts")
        self.assertEqual([float(row["minus_hierarchical"]) for row in self.table("variants.csv")], [-1.0, 15.0])
        self.assertLess(out.index("large    +15.00"), out.index("small     -1.00"))

    def stopped_early(self, mesh, label, percent, tets, **other):
        """An answer that was to stop at 6300 tets and ended at its limit with `tets`."""
        return synthetic.record(mesh, label, percent, judge=synthetic.judge(percent, tets),
                                stop={"kind": "tets", "value": 6300, "of": "hierarchical"}, **other)

    def test_a_variant_at_another_count_is_marked_and_not_ranked(self):
        lines = synthetic.thesis_records(meshes=("kidney",))
        lines += [self.stopped_early("kidney", "early", 95, 7630), synthetic.record("kidney", "small", 74)]
        lines.append(synthetic.record("kidney", "far", 60, judge=synthetic.judge(60, 5000), stop={"kind": "limit", "value": None}))
        synthetic.write_run(self.folder, lines)
        _, out, _ = self.report("--no-charts")
        rows = {row["label"]: row for row in self.table("variants.csv")}
        self.assertEqual([rows["early"][key] for key in ("tets", "note", "minus_hierarchical", "minus_sequential")],
                         ["7630", "stopped early: 7,630 tets", "", ""])
        self.assertEqual([rows["far"][key] for key in ("note", "minus_hierarchical")], ["at its limit: 5,000 tets", ""])
        self.assertEqual((rows["small"]["note"], float(rows["small"]["minus_hierarchical"])), ("", -1.0))
        ranking = out[out.index("largest first; only between answers whose tetrahedra are within 1%"):]
        self.assertLess(ranking.index("small "), ranking.index("early "))
        self.assertIn("stopped early: 7,630 tets", ranking)
        for table in ("quality.csv", "timing.csv"):
            notes = {row["label"]: row["note"] for row in self.table(table)}
            self.assertEqual((notes["early"], notes["sequential"]), ("stopped early: 7,630 tets", ""))

    def test_the_tolerance_of_equal_count(self):
        self.assertTrue(equal_count.is_equal(6363, 6300))
        self.assertTrue(equal_count.is_equal(6237, 6300))
        self.assertFalse(equal_count.is_equal(6364, 6300))
        self.assertFalse(equal_count.is_equal(6236, 6300))
        self.assertFalse(equal_count.is_equal(None, 6300))

    def test_sides_at_another_count_decide_nothing(self):
        lines = [line for line in synthetic.thesis_records(better=80, than=60, spread=(55, 65))
                 if (line["mesh"]["name"], line["label"]) != ("kidney", "sequential")]
        lines.append(self.stopped_early("kidney", "sequential", 60, 7630))
        synthetic.write_run(self.folder, lines)
        _, out, _ = self.report("--no-charts")
        self.assertIn("kidney: cannot be decided: not at equal count, hierarchical has 6,300 tetrahedra and sequential 7,630.", out)
        self.assertIn("Verdict: the claim cannot be decided.", out)
        self.assertEqual([row["verdict"] for row in self.table("verdict.csv")], [verdict.UNDECIDED, verdict.REPRODUCES])

    def test_seeds_at_another_count_are_left_out_of_the_spread(self):
        lines = synthetic.thesis_records(better=80, than=60, spread=(55, 65), meshes=("kidney",))
        lines.append(self.stopped_early("kidney", "sequential random", 90, 7630, seed=99))
        synthetic.write_run(self.folder, lines)
        _, out, _ = self.report("--no-charts")
        self.assertIn("over 39 seeds (1 at another count left out), 0 of them at least as good (0.0% to 9.0% of all; "
                      "rank test p = 0.025). Reproduces.", out)
        self.assertIn("stopped early: 1 of 40 seeds", out)

    def test_an_answer_short_of_its_fusions_is_said_without_a_reference(self):
        line = synthetic.record("kidney", "a", 70)
        line["report"]["fusions"] = 60
        synthetic.write_run(self.folder, [line, synthetic.record("kidney", "b", 70)], {})
        self.report("--no-charts")
        self.assertEqual([row["note"] for row in self.table("quality.csv")], ["stopped early: 6,300 tets", ""])

    def test_one_mesh_that_cannot_be_decided_leaves_the_whole_undecided(self):
        make = lambda outcome: verdict.MeshVerdict("m", "", None, None, None, [], outcome, "")
        self.assertEqual(verdict.overall([make(verdict.REPRODUCES), make(verdict.UNDECIDED)]), verdict.UNDECIDED)
        self.assertEqual(verdict.overall([make(verdict.DOES_NOT), make(verdict.UNDECIDED)]), verdict.DOES_NOT)
        self.assertEqual(verdict.overall([make(verdict.REPRODUCES), make(verdict.SIGN_ONLY)]), verdict.SIGN_ONLY)
        self.assertEqual(verdict.overall([make(verdict.REPRODUCES), make(verdict.OPEN)]), verdict.OPEN)

    def test_a_plan_without_a_claim_has_no_verdict(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(), {})
        code, out, _ = self.report("--no-charts")
        self.assertEqual(code, 0)
        self.assertNotIn("erdict", out)
        self.assertFalse((self.folder / "tables" / "verdict.csv").exists())


class Charts(ReportTest):
    def test_the_same_records_give_the_same_bytes(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(meshes=("kidney",)))
        self.assertEqual(self.report()[0], 0)
        first = self.charts()
        self.assertEqual(self.report()[0], 0)
        self.assertEqual(first, self.charts())
        names = ("histogram_kidney", "histograms_all_kidney", "overview", "timing")
        self.assertEqual(set(first), {f"{name}.{ending}" for name in names for ending in ("svg", "png")})
        self.assertTrue(all(data.startswith(b"\x89PNG") for name, data in first.items() if name.endswith("png")))

    def test_other_records_give_other_bytes(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(meshes=("kidney",)))
        self.report()
        first = self.charts()
        synthetic.write_run(self.folder, synthetic.thesis_records(better=60, meshes=("kidney",)))
        self.report()
        self.assertNotEqual(first["histogram_kidney.svg"], self.charts()["histogram_kidney.svg"])

    def test_an_answer_at_another_count_is_marked_in_the_overview(self):
        from simplify import charts
        line = synthetic.record("kidney", "early", 95, judge=synthetic.judge(95, 7630), stop={"kind": "tets", "value": 6300})
        synthetic.write_run(self.folder, [*synthetic.thesis_records(meshes=("kidney",)), line])
        run = records.read_run(self.folder)
        claim = verdict.read_claim(run.plan_data)
        equal_count.add_count_notes(run, claim)
        drawn = {}
        with mock.patch.object(charts, "save", lambda figure, _, name: drawn.update({name: figure}) or []):
            charts.draw_charts(run, claim, self.folder / "charts")
        words = [text.get_text() for text in drawn["overview"].findobj(charts.plt.Text)]
        self.assertIn("stopped early: 7,630 tets", words)
        self.assertTrue(any("not to be compared" in word for word in words))
        titles = [ax.get_title(loc="left") for ax in drawn["histograms_all_kidney"].axes]
        self.assertTrue(any(title.startswith("early, stopped early: 7,630 tets") for title in titles))

    def test_a_sweep_and_no_claim_draw_too(self):
        lines = [synthetic.record("kidney", "a", 70 + i, sweep={"fusions": 10 * i}, case=f"a{i}") for i in range(3)]
        synthetic.write_run(self.folder, lines, {})
        code, out, _ = self.report()
        self.assertEqual(code, 0)
        self.assertIn("a (fusions 20)", out)
        self.assertEqual(set(self.charts()), {f"{name}.{ending}" for name in ("histograms_all_kidney", "overview", "timing")
                                                   for ending in ("svg", "png")})

    def test_charts_of_a_former_report_are_taken_away(self):
        synthetic.write_run(self.folder, synthetic.thesis_records())
        self.report()
        synthetic.write_run(self.folder, synthetic.thesis_records(meshes=("kidney",)))
        self.report()
        self.assertFalse([name for name in self.charts() if "bean" in name])


class BrokenRuns(ReportTest):
    def leaves_with(self, **streams):
        """Exit code of the report as a program, with a stream of it on a full disk."""
        with open("/dev/full", "w", encoding="utf-8") as full:
            given = {name: full for name, is_full in streams.items() if is_full}
            given.setdefault("stdout", subprocess.DEVNULL)
            given.setdefault("stderr", subprocess.DEVNULL)
            return subprocess.run([sys.executable, "-B", make_report.__file__, str(self.folder), "--no-charts"], check=False, **given).returncode

    def test_words_that_find_no_room_change_no_exit_code_to_that_of_a_verdict(self):
        self.assertEqual(self.leaves_with(stderr=True), 2)  # there is no run
        synthetic.write_run(self.folder, synthetic.thesis_records(seeds=2))
        self.assertEqual(self.leaves_with(), 0)
        self.assertNotIn(self.leaves_with(stdout=True), (0, 1, 2))
        self.assertNotIn(self.leaves_with(stdout=True, stderr=True), (0, 1, 2))

    def test_no_accepted_answer_at_all(self):
        synthetic.write_run(self.folder, [synthetic.record("kidney", "hierarchical", None, outcome="crashed")])
        code, out, _ = self.report()
        self.assertEqual(code, 0)
        self.assertIn("no accepted answers: no charts", out)
        self.assertIn("The claim cannot be decided", out)

    def test_no_records_at_all(self):
        synthetic.write_run(self.folder, [])
        code, out, _ = self.report()
        self.assertEqual(code, 0)
        self.assertIn("no records", out)

    def test_no_folder(self):
        code, _, err = self.report()
        self.assertEqual(code, 2)
        self.assertEqual(err.count("\n"), 1)

    def test_a_broken_line_is_named(self):
        synthetic.write_run(self.folder, synthetic.thesis_records())
        path = self.folder / "records.jsonl"
        lines = path.read_text(encoding="utf-8").split("\n")
        lines[2] = lines[2][:40]
        path.write_text("\n".join(lines), encoding="utf-8")
        code, _, err = self.report()
        self.assertEqual(code, 2)
        self.assertIn("records.jsonl:3", err)
        self.assertFalse((self.folder / "tables").exists())

    def test_another_version_is_refused(self):
        for name, expected in (("records.jsonl", "palpate/record/1"), ("provenance.json", "palpate/provenance/1")):
            synthetic.write_run(self.folder, synthetic.thesis_records())
            path = self.folder / name
            text = path.read_text(encoding="utf-8")
            for other in (expected[:-1] + "2", "", "palpate/plan/1"):
                path.write_text(text.replace(expected, other), encoding="utf-8")
                code, _, err = self.report()
                self.assertEqual(code, 2)
                self.assertIn(f'schema: expected {expected}, found "{other}"', err)
                self.assertIn(name, err)

    def test_a_record_that_is_nested_too_deep_is_said(self):
        synthetic.write_run(self.folder, [synthetic.record("kidney", "a", 70)] * 2, {})
        path = self.folder / "records.jsonl"
        lines = path.read_text(encoding="utf-8").split("\n")
        for deep in ("[" * 5000 + "]" * 5000, "[" * 100_000, '{"a":' * 100_000):
            path.write_text("\n".join([deep, *lines]), encoding="utf-8")
            code, _, err = self.report()
            self.assertEqual(code, 2)
            self.assertIn("records.jsonl:1: expected a JSON object, found ", err)
            self.assertEqual(err.count("\n"), 1)

    def test_a_last_line_cut_off_by_a_kill_is_left_out_and_said(self):
        synthetic.write_run(self.folder, [synthetic.record("kidney", "a", 70, repeat=i) for i in range(3)], {})
        path = self.folder / "records.jsonl"
        path.write_text(path.read_text(encoding="utf-8")[:-30], encoding="utf-8")
        code, out, _ = self.report("--no-charts")
        self.assertEqual(code, 0)
        self.assertIn("cut off", out)
        self.assertEqual(self.table("timing.csv")[0]["n"], "2")

    def test_a_fault_of_the_report_is_not_taken_for_a_requirement_that_does_not_hold(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(meshes=("kidney",)))
        with mock.patch.object(verdict, "judge_run", side_effect=ZeroDivisionError("made up")):
            code, _, err = self.report("--no-charts")
        self.assertEqual(code, 3)
        self.assertIn("ZeroDivisionError: made up", err)

    def test_a_folder_that_cannot_be_written(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(meshes=("kidney",)))
        (self.folder / "tables").write_text("in the way", encoding="utf-8")
        code, _, err = self.report()
        self.assertEqual(code, 3)
        self.assertIn("tables", err)


if __name__ == "__main__":
    unittest.main()

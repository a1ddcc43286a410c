"""The report of a contest of the engine, on made-up records."""

import json
import shutil
import types
import unittest

from support import ReportTest
from engine import engine, engine_charts, engine_page
from shared import records
import synthetic

PLAN = {"question": "Does it come back?", "contest": "engine", "scenes": ["stiff", "soft"],
        "contestants": [{"method": "mover.replay", "label": "replay"}, {"method": "mover.rest", "label": "rest"},
                        {"method": "mover.ticks", "label": "ticks"}]}
MESH = "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\nTetrahedra 1\n1 2 3 4 0\nEnd\n"


def line(scene, label, kind, judged, reported, report, options=None, vertices=4, **other):
    made = synthetic.record(scene, label, None, contestant=f"mover.{label}", options=options or {}, report={"outcome": "completed", **report},
                            judge={"kind": kind, "valid": True, "findings": [], **judged})
    return {**made, "case": f"{scene}/{label}/{json.dumps(other.get('sweep'))}", "reported": reported, "mesh": {"name": scene, "vertices": vertices, "tets": 1, "hash": "0"}, **other}


def replay(scene, left, twentieth):
    returns = [{"load": 1, "released_s": 1.0, "end_s": 4.0, "released_m": 5e-3, "left_m": left, "error": left / 5e-3, "rms_error": 0.1,
                "half_s": None if twentieth is None else 0.1, "twentieth_s": twentieth}]
    return line(scene, "replay", "replay", {"returns": returns}, {"stability_margin": 1.05, "speeds_cut": 12, "peak_speed_m_s": 0.3},
                {"engine": "general", "time_step_s": 3e-4}, mesh_file=f"motions/{scene}/replay.json")


def ticks(vertices, threads, median, worst, error=0.05, **force):
    reported = {"steps_per_tick": 2, "tick_p50_s": median, "tick_p99_s": 2 * median, "tick_p99_9_s": 3 * median, "tick_worst_s": worst,
                "ticks": 100, "ticks_missed": int(worst > 1e-3)}
    judged = {"held_force_size_n": 0.5, "reference_force_size_n": 0.52, "force_error": error, **force}
    report = {"tick_s": 1e-3, "bucket_ends_s": [median, worst], "buckets": [99, 1]}
    return line("soft", "ticks", "ticks", judged, reported, report, {"precision": "single", "engine_threads": threads}, vertices,
                sweep={"option.vertices": vertices, "option.engine_threads": threads})


class Engine(ReportTest):
    LINES = [replay("soft", 5e-6, 0.2), replay("stiff", 4.5e-3, None),
             line("stiff", "rest", "rest", {"slowest_decay_s": 1285.0}, {"stability_margin": 1.01, "stable_step_s": 3.03e-4},
                  {"time_step_s": 3e-4}, vertices=1300, sweep={"option.vertices": 1300}),
             line("stiff", "rest", "rest", {}, {"stability_margin": 0.5, "stable_step_s": 1.5e-4}, {"time_step_s": 3e-4}, vertices=10000,
                  sweep={"option.vertices": 10000}),
             ticks(4000, 1, 4e-4, 5e-3), ticks(1000, 1, 1e-4, 8e-4), ticks(2000, 1, 3e-4, 4e-3), ticks(8000, 1, 2e-4, 9e-4),
             ticks(1000, 2, 1.1e-3, 2e-3)]

    def run_report(self, lines=None, charts=False):
        synthetic.write_run(self.folder, self.LINES if lines is None else lines, PLAN)
        for scene, size in (("soft", 1.0), ("stiff", 2.0)):
            columns = ["time_s", "probe_1_ux_m", "probe_1_uy_m", "probe_1_uz_m"]
            rows = [[0.5 * k, 3e-3 * size / (1 + k), 4e-3 * size / (1 + k), 0.0] for k in range(9)]
            frames = [{"time_s": 0.5 * k, "displacement_m": [1e-3 * k] * 12} for k in range(9)]
            for name, text in ((f"motions/{scene}/replay.json", json.dumps({"columns": columns, "rows": rows, "frames": frames})),
                               (f"problems/{scene}/in.mesh", MESH)):
                (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
                (self.folder / name).write_text(text, encoding="utf-8")
        code, self.printed, err = self.report(*([] if charts else ["--no-charts"]))
        self.assertEqual((code, err), (0, ""))

    def test_returns_say_what_is_left_and_what_was_not_reached(self):
        self.run_report()
        rows = {row["scene"]: row for row in self.table("returns.csv")}
        self.assertEqual(list(rows), ["stiff", "soft"])
        self.assertEqual((rows["stiff"]["left of it"], rows["stiff"]["half after"], rows["stiff"]["a twentieth after"]),
                         ("90%", "not yet", "not yet"))
        self.assertEqual((rows["soft"]["left of it"], rows["soft"]["a twentieth after"]), ("0.1%", "0.2 s"))

    def test_a_slow_decay_is_said_in_minutes_and_as_it_would_be_watched(self):
        self.run_report()
        rows = self.table("rest.csv")
        self.assertEqual((rows[0]["slowest decay"], rows[0]["watched at one step a tick"]), ("21.4 min", "5.95 h"))
        self.assertEqual(rows[1]["slowest decay"], "")

    def test_the_largest_mesh_is_the_last_before_the_first_that_misses(self):
        self.run_report()
        rows = {row["threads"]: row for row in self.table("largest.csv")}
        self.assertEqual((rows["1"]["median"], rows["1"]["99.9%"], rows["1"]["none missed"]), ("8,000", "2,000", "1,000"))
        self.assertEqual(rows["2"]["median"], "none")

    def test_ticks_are_sorted_by_setting_and_size(self):
        self.run_report()
        self.assertEqual([(row["threads"], row["vertices"]) for row in self.table("ticks.csv")],
                         [("1", "1,000"), ("1", "2,000"), ("1", "4,000"), ("1", "8,000"), ("2", "1,000")])

    def test_a_force_that_the_reference_cannot_tell_is_marked(self):
        self.run_report([ticks(1000, 1, 1e-4, 8e-4), ticks(2000, 1, 1e-4, 8e-4, reference_force_change=0.02, reference_too_coarse=True),
                         ticks(4000, 1, 1e-4, 8e-4, reference_force_change=0.002, reference_too_coarse=False)])
        self.assertEqual([(row["its change"], row["off by"]) for row in self.table("ticks.csv")],
                         [("", "5.00%~"), ("2.00%", "5.00%~"), ("0.20%", "5.00%")])
        self.assertIn("the reference cannot tell", self.printed)

    def test_what_gave_no_answer_keeps_its_row(self):
        lost = {**self.LINES[0], "outcome": "timed_out", "judge": None, "report": None, "message": "timed out", "mesh_file": None}
        self.run_report([lost, self.LINES[1]])
        self.assertEqual([row["note"] for row in self.table("replays.csv")], ["", "timed_out: timed out"])
        self.run_report([lost])  # a method that never answered: nobody knows what its answers would have been
        self.assertEqual(self.table("silent.csv")[0]["note"], "timed_out: timed out")
        self.assertIn("timed_out: timed out", self.printed)

    def test_the_charts_are_the_same_twice(self):
        self.run_report(charts=True)
        first = self.charts()
        self.assertEqual(sorted(name for name in first if name.endswith(".svg")),
                         ["budget.svg", "force.svg", "largest.svg", "margins.svg", "phases_soft.svg", "phases_stiff.svg", "returns.svg", "tick_times.svg"])
        self.run_report(charts=True)
        self.assertEqual(self.charts(), first)

    def test_pictures_say_when_their_frames_are(self):
        case = types.SimpleNamespace(record={"judge": {"returns": [{"released_s": 1.0, "end_s": 4.0}, {"released_s": 5.0, "end_s": 6.0}]}})
        at = lambda *times: [{"time_s": time} for time in times]
        titles = lambda frames: [title for title, _ in engine_charts.choose_pictures(case, frames)]
        # Wanted: 1, 1.6 and 4 s, then 5, 5.2 and 6 s.
        self.assertEqual(titles(at(0, 0.5, 1.0, 1.55, 3.0, 4.0, 4.9, 5.3, 6.0)),
                         ["undeformed\n0 s", "palpation 1, held\n1 s", "let go, 0.55 s\n1.55 s", "let go, 3 s\n4 s",
                          "palpation 2, held\n4.9 s", "let go, 0.3 s\n5.3 s", "let go, 1 s\n6 s"])
        # No frame is said to be held when the tool is gone, or of a palpation that it is not of.
        self.assertEqual(titles(at(0, 1.01, 3.9)), ["undeformed\n0 s", "let go, 0.01 s\n1.01 s", "let go, 2.9 s\n3.9 s"])
        self.assertEqual(titles(at(0.7)), ["first frame\n0.7 s", "palpation 1, held\n0.7 s"])
        self.assertEqual(titles([]), [])

    def test_a_rejected_replay_counts_in_no_sentence_and_each_says_what_it_is_of(self):
        bad = replay("soft", 4.9e-3, None)
        bad["reported"]["stability_margin"] = 0.4
        self.run_report([*self.LINES[1:3], {**bad, "outcome": "rejected", "violations": ["its outcome is inverted"]}])
        found = engine.read_cases(records.read_run(self.folder))
        self.assertEqual(engine_page.verdict_of(found)[0], "Of 1 returns to rest the worst keeps 90% of where it was let go (stiff, replay); the stable step of the replays is at "
                         "least 1.05 times their step. The stable step of bodies at rest is at least 1.01 times the step (stiff, rest).")
        self.assertEqual({row["margin"]: row["hollow"] for row in engine_page.margin_chart(found).rows}, {1.01: False, 1.05: False, 0.4: True})

    def test_a_setting_on_two_scenes_is_two_curves(self):
        other = ticks(1000, 1, 2e-4, 9e-4)
        other = {**other, "case": other["case"].replace("soft", "stiff"), "mesh": {"name": "stiff", "vertices": 1000, "tets": 1, "hash": "0"}}
        self.run_report([ticks(1000, 1, 1e-4, 8e-4), other, ticks(1000, 2, 1e-4, 8e-4)])
        rows = engine_page.tick_chart(engine.read_cases(records.read_run(self.folder))).rows
        self.assertEqual({row["name"] for row in rows}, {"ticks, single, 1 thread, soft", "ticks, single, 1 thread, stiff", "ticks, single, 2 threads"})

    def test_a_motion_that_cannot_be_read_is_noted(self):
        self.run_report()
        (self.folder / "motions/soft/replay.json").write_text("{", encoding="utf-8")
        code, printed, _ = self.report()
        self.assertEqual(code, 0)
        self.assertIn("no motion of replay on soft", printed)

    def test_motions_that_did_not_come_along_are_said_once(self):
        self.run_report()
        shutil.rmtree(self.folder / "motions")
        printed = self.report()[1]
        self.assertEqual([line for line in printed.splitlines() if "motion" in line and line.startswith("note")],
                         ["note: no motions are drawn: the run's folder has none, as they do not travel with an archive"])


if __name__ == "__main__":
    unittest.main()

"""Files of a run's folder that a contestant left deep, huge, odd, or as no file: they are said, and never crash, hang or fill the memory."""

import json
import os
import pathlib
import tempfile
import unittest
import unittest.mock

from support import ReportTest
from engine import motion_file
from engine_test import MESH, PLAN, replay, ticks
from shared import mesh_file, records, run_file
import stability_test
import synthetic

DEEP = "[" * 100_000 + "]" * 100_000


class Reader(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name) / "any.json"

    def refused(self, read=run_file.read_object):
        with self.assertRaises(run_file.BadRun) as caught:
            read(self.path)
        self.assertIn(str(self.path), str(caught.exception))
        return str(caught.exception)

    def test_texts_that_are_none_are_refused_in_one_line(self):
        for text, said in ((DEEP, "too deep"), ('{"a":' * 70 + "1" + "}" * 70, "too deep"), ('{"a": NaN}', "any.json: expected a number, found NaN"), ("[]", "an object"),
                           ('{"a": -Infinity}', "expected a number, found -Infinity"), ("{", "expected JSON"), ("", "expected JSON"), ("\xff", "UTF-8"), ('{"a": "' + "[" * 100, "expected JSON")):
            self.path.write_text(text, encoding="latin-1")
            self.assertIn(said, self.refused(), text[:40])
        self.path.write_text(json.dumps({"text": "[{" * 1000 + '"[', "number": 10**400}))
        self.assertEqual(run_file.read_object(self.path)["number"], float("inf"))

    def test_what_is_no_file_is_refused_and_not_waited_for(self):
        self.assertIn("cannot be read (No such file", self.refused())
        os.mkfifo(self.path)
        self.assertIn("found a pipe", self.refused())
        self.path.unlink()
        self.path.mkdir()
        self.assertIn("found a folder", self.refused())
        self.path.rmdir()
        self.path.symlink_to("/dev/zero")
        self.assertIn("found a link", self.refused())

    def test_a_huge_file_is_not_read(self):
        self.path.write_text("{}")
        os.truncate(self.path, 2**40)
        self.assertIn("expected at most 536,870,912 bytes, found 1,099,511,627,776", self.refused())
        self.assertIn("134,217,728", self.refused(mesh_file.read_mesh))
        self.path.write_text("{\"a\": [" + "[]," * 1000 + "1]}")
        with unittest.mock.patch.object(run_file, "MOST_VALUES", 1000):
            self.assertIn("at most 1,000 values", self.refused())

    def test_a_mesh_whose_corners_are_none_of_its_vertices_is_none(self):
        for corners in ("1 2 3 5", "0 1 2 3", "1 2 3 -4", "1 2 3 1e30", "1 2 3 nan"):
            self.path.write_text(MESH.replace("1 2 3 4 0", f"{corners} 0"))
            self.assertIn("expected vertices from 1 to 4", self.refused(mesh_file.read_mesh))
        self.path.write_text(MESH.replace("0 0 1 0", "0 0 nan 0"))
        self.assertIn("expected finite numbers", self.refused(mesh_file.read_mesh))

    def test_lines_of_records_are_bounded(self):
        line = json.dumps(synthetic.record("kidney", "sequential", 80.0))
        self.path.write_text(line + "\n" + line[:-1] + ', "x": "' + "y" * 5000 + '"}\n')
        with unittest.mock.patch.object(records, "MOST_LINE_BYTES", 4096):
            self.assertIn("any.json:2: expected a record of at most 4,096 bytes", self.refused(lambda path: records.read_lines(path, [])))


class OddMotions(ReportTest):
    """The report of a contest of the engine over motions that are none."""

    GOOD = {"columns": ["time_s", "largest_displacement_m", "total_j"], "rows": [[0, 0, 0], [1, 1e-3, None]], "frames": []}

    def notes_of(self, text):
        synthetic.write_run(self.folder, [replay("soft", 5e-6, 0.2)], PLAN)
        path = self.folder / "motions" / "soft" / "replay.json"
        for name, content in ((path, text), (self.folder / "problems" / "soft" / "in.mesh", MESH)):
            name.parent.mkdir(parents=True, exist_ok=True)
            name.write_text(content, encoding="utf-8")
        code, said, err = self.report()
        self.assertEqual((code, err), (0, ""), text[:80])
        return " ".join(said.split())

    def test_odd_motions_are_noted_and_not_drawn(self):
        self.assertNotIn("no motion of", self.notes_of(json.dumps(self.GOOD)))
        frame = {"time_s": 0, "displacement_m": [0] * 12}
        for key, value in (("columns", 3), ("columns", []), ("columns", [1, 2, 3]), ("columns", ["time_s"] * 3), ("columns", ["a", "b", "c"]), ("rows", {}), ("rows", []),
                           ("rows", [[0, 0]]), ("rows", [[0, "x", 0]]), ("rows", [[None, 0, 0]]), ("rows", [[0, True, 0]]), ("rows", [0]), ("frames", {}), ("frames", [3]),
                           ("frames", [{**frame, "time_s": "now"}]), ("frames", [{**frame, "displacement_m": [[0] * 12]}]), ("frames", [{"time_s": 0}])):
            said = self.notes_of(json.dumps({**self.GOOD, key: value}))
            self.assertIn(f"no motion of replay on soft: motions/soft/replay.json: {key}: expected", said)
            self.assertEqual(said.count("no motion of"), 1, "said once")
        for text in (DEEP, "[]", "{", json.dumps(self.GOOD).replace("null", "NaN")):
            self.assertIn("no motion of replay on soft: motions/soft/replay.json: expected", self.notes_of(text))
        self.notes_of(json.dumps({**self.GOOD, "frames": [frame, {**frame, "time_s": 1}, {"time_s": 2, "displacement_m": [1]}]}))

    def test_a_frame_of_another_mesh_is_left_out(self):
        frames = [{"time_s": k, "displacement_m": [1e-3 * k] * size} for k, size in enumerate((12, 4, 12, 15))]
        self.assertEqual(len(motion_file.motion_of({**self.GOOD, "frames": frames}, "any")["frames"]), 4)
        self.assertNotIn("no motion of", self.notes_of(json.dumps({**self.GOOD, "frames": frames})))

    def test_records_that_are_a_pipe_or_a_folder_are_said_at_once(self):
        self.folder.mkdir(parents=True)
        os.mkfifo(self.folder / "records.jsonl")
        code, _, err = self.report()
        self.assertEqual(code, 2)
        self.assertIn("records.jsonl: expected a file, found a pipe", err)


class OddRecords(ReportTest):
    """What a contestant tells of itself may be anything: the report is made all the same."""

    ODD = ([], "x", 10**400, [[1], 2], {"a": {"b": []}})

    def test_blocks_that_are_the_contestants_own_may_hold_anything(self):
        for plan, lines in ((PLAN, [ticks(4000, 1, 4e-4, 5e-3), replay("soft", 5e-6, 0.2)]), (stability_test.PLAN, [stability_test.measured("motion.plain_float", "nominal", 1.001)]),
                            (synthetic.PLAN, synthetic.thesis_records(seeds=2, repeats=2, meshes=("kidney",)))):
            for odd in self.ODD:
                self.made(plan, [{**line, "report": odd, "reported": odd, "tuned": odd, "notes": odd} for line in lines])
                self.made(plan, [{**line, "violations": odd, "message": odd} for line in lines])
                keys = ("kind", "engine", "engine_threads", "time_step_s", "buckets", "bucket_ends_s", "tick_s", "tets_out", "rejected", "runs", "vertex")
                self.made(plan, [{**line, **{block: {**(line.get(block) or {}), **dict.fromkeys(keys, odd)} for block in ("report", "reported")}} for line in lines])
                for key in keys:
                    self.made(plan, [*lines[:-1], {**lines[-1], **{block: {**(lines[-1].get(block) or {}), key: odd} for block in ("report", "reported")}}])

    def made(self, plan, lines):
        synthetic.write_run(self.folder, lines, plan)
        code, _, err = self.report("--no-charts")
        self.assertIn(code, (0, 1), f"{json.dumps(lines[-1])[:2000]} {err}")

    def test_ticks_in_buckets_that_are_none_are_not_drawn(self):
        for key, odd in (("buckets", [[1], 2]), ("buckets", [1]), ("buckets", [0, 0]), ("buckets", [-1, 2]), ("bucket_ends_s", 3), ("bucket_ends_s", [0, 1]), ("buckets", [10**400, 1])):
            line = ticks(4000, 1, 4e-4, 5e-3)
            synthetic.write_run(self.folder, [{**line, "report": {**line["report"], key: odd}}, ticks(2000, 1, 4e-4, 5e-3)], PLAN)
            code, _, err = self.report()
            self.assertEqual((code, err), (0, ""), f"{key} {odd}")


if __name__ == "__main__":
    unittest.main()

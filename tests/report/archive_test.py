"""Archives of runs: what comes back is what went in, and nothing else is taken for it."""

import contextlib
import io
import json
import lzma
import unittest

from support import ReportTest
import archive_run
import synthetic


class Archives(ReportTest):
    def setUp(self):
        super().setUp()
        synthetic.write_run(self.folder, synthetic.thesis_records(seeds=3))
        (self.folder / "plan.yaml").write_text("schema: palpate/plan/1\n")
        self.archive, self.again = self.folder.parent / "archive", self.folder.parent / "again"

    def call(self, *arguments):
        err = io.StringIO()
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(err):
            code = archive_run.main([str(argument) for argument in arguments])
        return code, err.getvalue()

    def pack(self):
        self.assertEqual(self.call(self.folder, self.archive), (0, ""))

    def refused(self, said):
        code, err = self.call("--unpack", self.archive, self.again)
        self.assertEqual(code, 2, err)
        self.assertIn(said, err)
        self.assertEqual(err.count("\n"), 1)
        self.assertFalse((self.again / "records.jsonl").exists())

    def test_a_link_in_a_run_is_not_followed(self):
        secret = self.folder.parent / "secret"
        secret.write_text("nobody is to see this\n")
        (self.folder / "plan.yaml").unlink()
        (self.folder / "plan.yaml").symlink_to(secret)
        code, err = self.call(self.folder, self.archive)
        self.assertEqual(code, 2)
        self.assertIn("plan.yaml: expected a file, found a link", err)
        self.assertFalse((self.archive / "plan.yaml").exists())

    def test_what_comes_back_is_what_went_in(self):
        self.pack()
        self.assertEqual(self.call("--unpack", self.archive, self.again), (0, ""))
        for name in ("plan.yaml", "provenance.json", "records.jsonl"):
            self.assertEqual((self.again / name).read_bytes(), (self.folder / name).read_bytes(), name)
        self.assertEqual({path.name for path in self.again.iterdir()}, {"plan.yaml", "provenance.json", "records.jsonl"})

    def test_the_report_of_an_archive_is_that_of_its_run(self):
        self.report("--no-charts")
        tables = {path.name: path.read_bytes() for path in (self.folder / "tables").iterdir()}
        self.pack()
        self.call("--unpack", self.archive, self.again)
        self.folder = self.again
        self.assertEqual(self.report("--no-charts")[0], 0)
        self.assertEqual({path.name: path.read_bytes() for path in (self.again / "tables").iterdir()}, tables)

    def test_the_same_records_make_the_same_bytes(self):
        self.pack()
        other = self.folder.parent / "other"
        self.assertEqual(self.call(self.folder, other)[0], 0)
        for path in self.archive.iterdir():
            self.assertEqual(path.read_bytes(), (other / path.name).read_bytes(), path.name)

    def test_what_is_no_run_is_not_packed(self):
        (self.folder / "provenance.json").write_text("[]")
        self.assertIn("expected an object", self.call(self.folder, self.archive)[1])
        (self.folder / "records.jsonl").unlink()
        code, err = self.call(self.folder, self.folder.parent / "third")
        self.assertEqual(code, 2)
        self.assertIn("expected a file of a run", err)

    def test_a_cut_record_is_not_packed(self):
        with open(self.folder / "records.jsonl", "a", encoding="utf-8") as records:
            records.write('{"schema": ')
        code, err = self.call(self.folder, self.archive)
        self.assertEqual(code, 2)
        self.assertIn("cut", err)
        self.assertFalse((self.archive / "archive.json").exists())

    def test_what_has_no_records_or_lines_without_one_is_not_packed(self):
        records = self.folder / "records.jsonl"
        whole = records.read_text(encoding="utf-8")
        for text, said in (("", "expected the records of a run, found none"), ("\n", "found none"), (whole + "\n", "expected a record a line, found "),
                           (whole + "not json\n", f"records.jsonl:{whole.count(chr(10)) + 1}: expected a JSON object"), (whole + "{}\n", "expected a record with a label")):
            records.write_text(text, encoding="utf-8")
            code, err = self.call(self.folder, self.archive)
            self.assertEqual((code, err.count("\n")), (2, 1), err)
            self.assertIn(said, err)
            self.assertEqual(list(self.archive.iterdir()), [])
        records.write_text(whole, encoding="utf-8")
        self.pack()

    def test_a_folder_is_empty_after_a_failure_and_takes_the_next_try(self):
        (self.folder / "provenance.json").write_text('{"plan": "p"}')
        whole = (self.folder / "records.jsonl").read_bytes()
        (self.folder / "records.jsonl").write_bytes(whole[:-1])
        self.assertEqual(self.call(self.folder, self.archive)[0], 2)
        self.assertEqual(list(self.archive.iterdir()), [])
        (self.folder / "records.jsonl").write_bytes(whole)
        self.pack()
        (self.archive / "records.jsonl.xz").write_bytes(b"none")
        self.assertEqual(self.call("--unpack", self.archive, self.again)[0], 2)
        self.assertEqual(list(self.again.iterdir()), [])

    def test_a_folder_with_something_in_it_is_left_alone(self):
        self.pack()
        self.assertIn("empty folder", self.call(self.folder, self.archive)[1])
        self.again.mkdir()
        (self.again / "mine.txt").write_text("mine")
        self.refused("empty folder")
        self.assertEqual([path.name for path in self.again.iterdir()], ["mine.txt"])

    def test_changed_records_are_found(self):
        self.pack()
        lines = (self.folder / "records.jsonl").read_text()
        packed = self.archive / "records.jsonl.xz"
        for text, said in ((lines.replace("0.01", "0.02", 1), "with another"), (lines[:-2] + "\n", "bytes with the sum"), (lines + "{}\n", "found more")):
            packed.write_bytes(lzma.compress(text.encode()))
            self.refused(said)

    def test_more_than_was_announced_is_never_written(self):
        self.pack()
        packed = self.archive / "records.jsonl.xz"
        packed.write_bytes(lzma.compress(b"\n" * 20_000_000, preset=0))  # 3 kB
        self.refused("found more")
        self.assertEqual(list(self.again.iterdir()), [])

    def test_damage_is_one_line(self):
        self.pack()
        packed = self.archive / "records.jsonl.xz"
        whole = packed.read_bytes()
        for damaged in (whole[:-40], whole[:200] + b"xxxx" + whole[204:], whole + b"more", b"", b"no xz"):
            packed.write_bytes(damaged)
            self.refused("records.jsonl.xz: ")

    def test_a_note_of_another_form_is_refused(self):
        self.pack()
        note = self.archive / "archive.json"
        good = json.loads(note.read_text())
        for key, value, said in (("schema", "palpate/archive/2", "palpate/archive/1"), ("bytes", "many", "a whole number"), ("bytes", True, "a whole number"),
                                 ("sha256", None, "a text")):
            note.write_text(json.dumps({**good, key: value}))
            self.refused(said)
        note.write_text("[" * 100_000)
        self.refused("archive.json: ")


if __name__ == "__main__":
    unittest.main()

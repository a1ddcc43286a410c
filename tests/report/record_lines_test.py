"""Lines of records.jsonl that are no records: whoever reads a run refuses it, with the line, and takes none of it for figures."""

import contextlib
import io
import json
import unittest

from support import HERE, ReportTest
import archive_run
import compare_runs
import make_history
import make_report
import synthetic
from shared.compact_record import OUTCOMES
from shared.records import histogram

ABSENT = object()


class Lines(ReportTest):
    def setUp(self):
        super().setUp()
        self.lines = [synthetic.record("kidney", "a", 70, repeat=repeat, load_1min=1.0, processor_s=2.0, others_s=-0.01, searched=False) for repeat in range(3)]
        synthetic.write_run(self.folder, self.lines, {})
        (self.folder / "plan.yaml").write_text("schema: palpate/plan/1\n")
        provenance = self.folder / "provenance.json"
        provenance.write_text(json.dumps({**json.loads(provenance.read_text()), "started_at": "2026-01-01T00:00:00Z"}))
        self.records = self.folder / "records.jsonl"
        self.measures = self.folder.parent / "measures.json"
        self.measures.write_text("[]")

    def write(self, texts):
        self.records.write_text("".join(text + "\n" for text in texts), encoding="utf-8")

    def second(self, key, value):
        """The texts of the lines, the second one with something else under a key."""
        changed = {**self.lines[1], key: value}
        if value is ABSENT:
            del changed[key]
        return [json.dumps(line) for line in (self.lines[0], changed, self.lines[2])]

    def refused(self, texts, said):
        """By all that read records, in one line, before anything is written."""
        self.write(texts)
        before = sorted(self.folder.rglob("*"))
        archive = self.folder.parent / "archive"
        for main, arguments in ((make_report.main, [self.folder]), (compare_runs.main, [self.folder, self.folder]), (archive_run.main, [self.folder, archive]),
                                (make_history.main, ["--measures", self.measures, self.folder])):
            with contextlib.redirect_stderr(io.StringIO()) as err, contextlib.redirect_stdout(io.StringIO()) as out:
                code = main([str(argument) for argument in arguments])
            self.assertEqual((code, out.getvalue(), err.getvalue().count("\n")), (2, "", 1), f"{main.__module__}: {err.getvalue()}")
            self.assertIn(f"{self.records}:{said}", err.getvalue(), main.__module__)
        self.assertEqual(sorted(self.folder.rglob("*")), before)
        self.assertEqual(list(archive.iterdir()), [])

    def test_a_word_that_is_no_number_is_refused_wherever_it_stands(self):
        for word in ("NaN", "Infinity", "-Infinity"):
            for key in ("kernel_s", "wall_s", "judge", "anything"):
                place = {"judge": {**self.lines[1]["judge"], "mean_quality": 0.125}}.get(key, 0.125)
                texts = [text.replace("0.125", word) for text in self.second(key, place)]
                self.refused(texts, f"2: expected a number, found {word}")
        compact = [text.replace(": ", ":").replace(", ", ",") for text in self.second("kernel_s", 0.125)]  # as the runner writes it
        self.refused([text.replace("0.125", "NaN") for text in compact], "2: expected a number, found NaN")

    def test_what_may_not_stand_under_a_key_is_refused(self):
        time, count = "a number from 0, or null", "a whole number from 0 to 1000000000"
        for key, value, expected in (("kernel_s", "fast", time), ("kernel_s", -1, time), ("wall_s", True, time), ("user_s", [1], time), ("peak_rss_bytes", -5, time),
                                     ("kernel_s", 10**400, time), ("load_1min", {}, time), ("processor_s", "2", time), ("others_s", "2", "a number or null"),
                                     ("repeat", -5, count), ("repeat", 1.0, count), ("repeat", True, count), ("repeat", None, count), ("repeat", 10**9 + 1, count),
                                     ("case", 7, "a text"), ("case", None, "a text"), ("warmup", 0, "true or false"), ("required", "no", "true or false"),
                                     ("searched", None, "true or false"), ("outcome", "fine", "one of accepted, "), ("outcome", None, "one of "), ("outcome", [], "one of ")):
            with self.subTest(key=key, value=str(value)[:20]):
                self.refused(self.second(key, value), f"2: {key}: expected {expected}")
        self.refused([text.replace("0.125", "1e999") for text in self.second("kernel_s", 0.125)], f"2: kernel_s: expected {time}, found Infinity")
        for key in ("case", "outcome", "repeat"):
            self.refused(self.second(key, ABSENT), f"2: {key}: expected ")
        self.refused(["not json", *self.second("seed", 1)], "1: expected a JSON object")

    def test_what_may_stand_there_is_read(self):
        for outcome in OUTCOMES:
            self.write(self.second("outcome", outcome))
            self.assertEqual(self.report("--no-charts")[0], 0, outcome)
        for key in ("kernel_s", "wall_s", "user_s", "peak_rss_bytes", "load_1min", "processor_s", "others_s"):
            for value in (None, 0, 2, ABSENT):
                self.write(self.second(key, value))
                self.assertEqual(self.report("--no-charts")[0], 0, key)

    def test_a_repeat_that_stands_there_twice_is_refused(self):
        first, second, third = map(json.dumps, self.lines)
        said = f"expected each repeat of a case once, found repeat 1 of {self.lines[1]['case']} again"
        self.refused([first, second, third, second], f"4: {said}")
        self.refused([first, second, json.dumps({**self.lines[1], "kernel_s": 9.0}), third], f"3: {said}")
        self.refused([first, json.dumps({**self.lines[1], "warmup": True}), second], f"3: {said}")
        self.write([first, second, json.dumps({**self.lines[1], "case": "kidney/b", "label": "b"}), third])
        self.assertEqual(self.report("--no-charts")[0], 0)

    def test_the_outcomes_are_those_of_the_schema(self):
        schema = json.loads((HERE.parents[1] / "experiments" / "schema" / "record.schema.json").read_text(encoding="utf-8"))
        self.assertEqual(schema["properties"]["outcome"]["enum"], list(OUTCOMES))

    def test_a_histogram_of_infinities_is_none(self):
        self.assertIsNone(histogram({"judge": {"histogram": [float("inf")] + [1] * 9}}))
        self.assertIsNone(histogram({"judge": {"histogram": [10**400] + [1] * 9}}))


if __name__ == "__main__":
    unittest.main()

"""Compact records: whatever stands in a line, they say what json says of it."""

import json
import unittest

from support import ReportTest
from shared import records
from shared.compact_record import NOT_KEPT, Record, RecordPacker, split
import synthetic

HOSTILE = [
    '{"label":"a","kernel_s":1.5,"repeat":3,"wall_s":2}',
    '{"kernel_s":1,"label":"a","judge":{"kernel_s":7,"repeat":9},"repeat":2}',
    '{"judge":{"kernel_s":7},"label":"a"}',  # not its own, but a block's
    '{"label":"a","message":"\\"kernel_s\\":5,\\"repeat\\":6","repeat":1}',
    '{"kernel_s":1,"kernel_s":2,"label":"a","x":0}',  # the last one counts
    '{"kernel_s":[1,2],"label":"a"}',
    '{"kernel_s":{"a":1},"label":"a"}',
    '{"kernel_s":"a,b","label":"a","repeat":"c,d"}',
    '{"kernel_s":",","label":"a","repeat":",","wall_s":1}',
    '{"kernel_s":null,"label":"a","repeat":true,"wall_s":3,"z":1e400}',
    '{"label":"kernel_s","wall_s": 3 ,"repeat" : 4, "user_s":5}',
    '{"label":"\\u0000kernel_s\\u0000","kernel_s":2,"message":"\\u0000repeat\\u0000"}',
    '{"label":"a","report":[1,[2,{"b":3}]],"judge":{},"options":{"seed":1},"violations":["x"]}',
    '{"wall_s":1,"label":"a","kernel_s":2}',  # in another order
    '{"label":"\\ud83d\\ude00é","kernel_s":-0.0,"repeat":123456789012345678901234567890,"x":1}',
]


def as_read(record):
    return {key: record[key] for key in record}


class Compact(unittest.TestCase):
    def test_hostile_lines_are_what_json_says(self):
        packer = RecordPacker()
        for _ in range(2):  # the second time their forms are known
            for line in HOSTILE:
                read = packer.read(line.encode())
                self.assertIsInstance(read, Record, line)
                self.assertEqual(repr(as_read(read)), repr(json.loads(line)), line)
                self.assertEqual([read.get(key) is None for key in ("nothing",)], [True])

    def test_what_is_no_record_and_what_is_no_json(self):
        packer = RecordPacker()
        for line in ("3", "[]", "{}", '{"label":3}', '{"kernel_s":1,"label":null}'):
            self.assertEqual(packer.read(line.encode()), json.loads(line))
        for line in ('{"label":"a","kernel_s":,"x":1}', '{"label":"a","kernel_s":1 2,"x":1}', '{"label":"a","kernel_s":1],"x":1}', '{"label":"a"', "[" * 100_000,
                     '{"label":"a","kernel_s":NaN,"x":1}', '{"label":"a","judge":{"x":-Infinity},"repeat":1,"z":0}'):
            for _ in range(2):
                self.assertRaises((ValueError, RecursionError), packer.read, line.encode())

    def test_repeats_share_all_but_their_own(self):
        lines = [json.dumps(synthetic.record("kidney", "a", 70, repeat=repeat, kernel_s=0.1 * repeat), sort_keys=True, separators=(",", ":")).encode()
                 for repeat in range(3)]
        self.assertEqual(len({split(line)[0] for line in lines}), 1)
        packer = RecordPacker()
        first, *others = map(packer.read, lines)
        for repeat, other in enumerate(others, start=1):
            self.assertIs(other.shared, first.shared)
            self.assertEqual((other["repeat"], other["kernel_s"]), (repeat, 0.1 * repeat))
            self.assertEqual(as_read(other), {key: value for key, value in json.loads(lines[repeat]).items() if key not in NOT_KEPT})

    def test_a_block_that_was_closed_opens_again(self):
        packer = RecordPacker()
        read = [packer.read(json.dumps({"label": "a", "judge": {"tets": place}}).encode()) for place in range(20_100)]
        for _ in range(2):
            self.assertEqual([record["judge"]["tets"] for record in read], list(range(20_100)))


class Files(ReportTest):
    def test_a_text_that_is_no_utf_8_is_said(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(repeats=1, seeds=2), {})
        with open(self.folder / "records.jsonl", "ab") as stream:
            stream.write(b'{"label":"\xff","kernel_s":1,"x":2}\n')
        code, _, error = self.report()
        self.assertEqual(code, 2)
        self.assertIn("expected UTF-8 text", error)

    def test_a_run_of_many_meshes_prints_and_draws_the_first_and_says_so(self):
        lines = [synthetic.record(f"m{place}", "a", 70) for place in range(130)]
        synthetic.write_run(self.folder, lines, {"charts": ["overview"]})
        code, out, _ = self.report()
        self.assertEqual(code, 0)
        self.assertIn("the summary has the first 100 of 130 meshes", out)
        self.assertIn("charts show the first 24 of 130 meshes", out)
        self.assertNotIn("m101 ", out)
        self.assertEqual(len(self.table("quality.csv")), 130)


if __name__ == "__main__":
    unittest.main()

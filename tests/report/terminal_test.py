"""Tables and prose for a terminal: nothing is lost, nothing is wider than it, files keep their width."""

import os
import re
import unittest
import unittest.mock

import synthetic
from support import ReportTest
from shared import tables, terminal

NAMES = ["mesh", "label", "fusions", "tets", "% above 0.5", "% above 0.6", "mean", "min angle", "note"]
ROWS = [["kidney", "hierarchical", "87", "6300", "71.0", "60.1", "0.612", "1.5", "stopped early: 7,630 tets, which is more than was asked for"],
        ["", "sequential random", "88 [86, 90]", "6290", "80.0", "70.2", "0.701", "11.5", ""]]


def words(text):
    """How often each word is there, without rulers."""
    found = {}
    for word in re.sub(r"(^|(?<=\s))-+(?=\s|$)", "", text).split():
        found[word] = found.get(word, 0) + 1
    return found


class Folding(unittest.TestCase):
    def test_a_table_that_fits_is_as_it_was(self):
        text = "A title\n\n" + tables.align(NAMES, ROWS) + "\n\nand prose."
        self.assertEqual(terminal.fold(text, 1000), text)

    def test_one_that_is_too_wide_becomes_blocks_with_the_names_in_each(self):
        for most in (60, 72, 80, 100):
            folded = terminal.fold(tables.align(NAMES, ROWS), most)
            self.assertLessEqual(max(map(len, folded.split("\n"))), most, folded)
            blocks = folded.split("\n\n")
            self.assertGreater(len(blocks), 1)
            for block in blocks:
                self.assertTrue(block.startswith("mesh    label"), block)
                self.assertIn("sequential random", block)

    def test_no_cell_is_lost_or_doubled(self):
        text = tables.align(NAMES, ROWS)
        for most in range(52, 140, 7):
            found = words(terminal.fold(text, most))
            for word, count in words(text).items():
                self.assertGreaterEqual(found.get(word, 0), count, (word, most))
                if word not in ("mesh", "label", "kidney", "hierarchical", "sequential", "random", *" ".join(NAMES).split()):
                    self.assertEqual(found[word], count, (word, most))

    def test_the_oracle_notices_a_table_that_was_cut(self):
        text = tables.align(NAMES, ROWS)
        cut = "\n".join(line[:60] for line in text.split("\n"))
        self.assertNotEqual(words(text), words(cut))

    def test_long_names_make_records(self):
        name = "a_mesh_with_a_long_name/and_a_label_with_another/tets_removed_ratio=0.22"
        folded = terminal.fold(tables.align(["case", "before", "after", "note"], [[name, "0.5", "0.75", "why " * 20]]), 80)
        lines = folded.split("\n")
        self.assertEqual(lines[0], name)
        self.assertTrue(lines[1].startswith("    before 0.5  after 0.75"), lines[1])
        self.assertLessEqual(max(map(len, lines)), 80)
        self.assertEqual(folded.count("why"), 20)

    def test_titles_between_rows_stay_between_them(self):
        lines = [["label", *(f"measure {k} " for k in range(12)), "note"], "kidney, 22% removed: 6,300 of 8,100 tetrahedra asked for",
                 ["refined", *(f"0.{k}*" for k in range(12)), ""], "kidney, 50% removed: 4,050 of 8,100 tetrahedra asked for",
                 ["cgal", *(f"1.{k} " for k in range(12)), "late"]]
        folded = terminal.fold(tables.pad_columns(lines), 80)
        self.assertLessEqual(max(map(len, folded.split("\n"))), 80)
        places = [folded.index(text) for text in ("22% removed", "refined", "50% removed", "cgal", "late")]
        self.assertEqual(places, sorted(places))
        self.assertEqual([folded.count(text) for text in ("22% removed", "50% removed", "0.11*", "1.11", "late")], [1] * 5)

    def test_blocks_keep_as_many_names_as_tell_the_rows_apart(self):
        rows = [["haptic_palpation", label, threads, *("0.123 ms" for _ in range(9)), ""] for label in ("ticks", "a_paced") for threads in ("1", "2")]
        folded = terminal.fold(tables.pad_columns([["scene", "label", "threads", *(f"measure {k}" for k in range(9)), ""], *rows]), 80)
        self.assertGreater(len(folded.split("\n\n")), 1)
        for block in folded.split("\n\n"):
            self.assertRegex(block, r"\A *scene +label +threads")
            self.assertEqual([len(re.findall(rf" +{label} +{threads} ", block)) for label in ("ticks", "a_paced") for threads in (1, 2)], [1] * 4, block)

    def test_a_title_that_is_short_is_no_row(self):
        lines = [["label", *(f"measure {k}" for k in range(12)), "note"], "", "ball", ["a_label_of_some_length", *("0.5" for _ in range(12)), ""], "", "bar", ["b", *("0.6" for _ in range(12)), ""]]
        folded = terminal.fold(tables.pad_columns(lines), 80).split("\n")
        self.assertEqual([folded.count(title) for title in ("ball", "bar")], [1, 1])
        self.assertEqual(folded[:2], ["", "ball"])
        self.assertEqual([line for line in folded if re.fullmatch("label *|-+", line)], [])

    def test_a_last_column_of_figures_has_a_ruler_and_one_of_words_has_none(self):
        self.assertEqual(tables.pad_columns([["a", "count"], ["x", "12"]]).split("\n"), ["a  count", "-  -----", "x     12"])
        self.assertEqual(tables.pad_columns([["a", "count", "note"], ["x", "12", "late"]]).split("\n"), ["a  count  note", "-  -----", "x     12  late"])

    def test_prose_is_wrapped_with_its_indentation(self):
        folded = terminal.fold("  " + "word " * 40, 50).split("\n")
        self.assertTrue(all(line.startswith("  word") and len(line) <= 50 for line in folded), folded)
        self.assertEqual(" ".join(folded).split(), ["word"] * 40)


class Width(ReportTest):
    columns = 80

    def test_columns_is_honoured_and_80_is_what_stands_without(self):
        self.assertEqual(terminal.width(), 80)
        with unittest.mock.patch.dict(os.environ, {"COLUMNS": "132"}):
            self.assertEqual(terminal.width(), 132)
        with unittest.mock.patch.dict(os.environ):
            del os.environ["COLUMNS"]
            with unittest.mock.patch.object(terminal.shutil.os, "get_terminal_size", side_effect=OSError):
                self.assertEqual(terminal.width(), 80)

    def test_a_report_fits_the_terminal_and_its_files_do_not_know_it(self):
        tables_of = {}
        for columns in ("80", "1000"):
            with unittest.mock.patch.dict(os.environ, {"COLUMNS": columns}):
                synthetic.write_run(self.folder, synthetic.thesis_records(seeds=5))
                code, out, _ = self.report("--no-charts")
            self.assertEqual(code, 0)
            tables_of[columns] = {path.name: path.read_bytes() for path in (self.folder / "tables").iterdir()}
            widest = max(map(len, out.split("\n")))
            self.assertLessEqual(widest, int(columns))
        self.assertGreater(widest, 80)  # of the wide one: the narrow one did fold something
        self.assertEqual(tables_of["80"], tables_of["1000"])


if __name__ == "__main__":
    unittest.main()

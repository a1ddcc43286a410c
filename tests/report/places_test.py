"""Where pages and tables may be written: what stands there and is not theirs stays, and is said before any work."""

import contextlib
import io
import os
import stat
import unittest
import unittest.mock

from support import ReportTest
import compare_page
import make_report
import synthetic
from page import write_page
from shared.run_file import BadRun
from shared.whole_file import replacing


class Pages(ReportTest):
    def test_a_place_where_no_page_can_go_is_said_before_any_work(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(seeds=2))
        pipe, link, loop = (self.folder.parent / name for name in ("pipe", "link", "loop"))
        os.mkfifo(pipe)
        link.symlink_to(pipe)
        loop.symlink_to(loop)
        for place, said in ((pipe, "found a pipe"), (link, "found a pipe"), (loop, "found a link"), (self.folder, "found a folder"),
                            (self.folder / "records.jsonl", "found a file that is no page"), (pipe / "x.html", "found no folder"),
                            (self.folder / "no" / "x.html", f"expected a file in a folder that exists, found no folder {self.folder}/no"),
                            (self.folder / ("x" * 300), "found: File name too long")):
            with unittest.mock.patch.object(make_report, "read_without_collecting", side_effect=AssertionError("work was done")):
                code, _, err = self.report("-o", str(place))
            self.assertEqual((code, err.count("\n")), (2, 1), f"{place}: {err}")
            self.assertIn(said, err)
        self.assertTrue(stat.S_ISFIFO(os.lstat(pipe).st_mode))
        with contextlib.redirect_stderr(io.StringIO()) as err:
            self.assertEqual(compare_page.main([str(self.folder), str(self.folder), "-o", str(pipe)]), 2)
        self.assertIn("found a pipe", err.getvalue())
        os.mkfifo(self.folder / "report.html")
        self.assertEqual(self.report()[0], 2)
        self.assertFalse((self.folder / "tables").exists(), "nothing is written for a page that cannot be")

    def test_a_page_goes_where_a_link_leads(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(seeds=2))
        link, page = self.folder.parent / "link.html", self.folder.parent / "page.html"
        link.symlink_to(page)
        for _ in range(2):  # to nothing, and to a page
            self.assertEqual(self.report("--no-charts", "-o", str(link))[0], 0)
            self.assertTrue(link.is_symlink() and not page.is_symlink() and page.read_bytes().startswith(write_page.DOCTYPE))

    def test_nothing_but_a_file_is_renamed_upon(self):
        self.folder.mkdir(parents=True)
        path, theirs = self.folder / "a.csv", self.folder / "theirs"
        for make, said in ((os.mkfifo, "a pipe"), (os.mkdir, "a folder"), (lambda place: place.symlink_to(theirs), "a link")):
            make(path)
            before = os.lstat(path)
            with self.assertRaisesRegex(BadRun, f"a.csv: expected a file or nothing, found {said}"), replacing(path) as beside:
                beside.write_text("ours")
            self.assertEqual((os.lstat(path).st_ino, os.listdir(self.folder)), (before.st_ino, ["a.csv"]))
            path.rename(self.folder.parent / said)


if __name__ == "__main__":
    unittest.main()

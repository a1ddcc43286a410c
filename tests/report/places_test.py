"""Where pages and tables may be written: what stands there and is not theirs stays."""

import os
import unittest

from support import ReportTest
from shared.run_file import BadRun
from shared.whole_file import replacing


class Pages(ReportTest):
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

"""The floors test must catch each kind of violation, and must let pass what the design allows."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import floors

FORBIDDEN = [
    ("core/base/a.h", "core/mesh/tet_mesh.h"),
    ("core/mesh/a.cpp", "core/judge/judge.h"),
    ("core/judge/a.cpp", "core/mesh/topology.h"),
    ("core/judge/a.cpp", "core/simplify/a.h"),
    ("core/simplify/a.h", "core/judge/judge.h"),
    ("core/simplify/a.h", "reference/adapter.h"),
    ("reference/tetfusion/a.cpp", "reference/cgal/a.h"),
    ("reference/tetfusion/a.cpp", "experiments/plan.h"),
    ("reference/adapter.cpp", "reference/cgal/a.h"),
    ("experiments/a.cpp", "tests/support/a.h"),
    ("core/mesh/a.cpp", "tests/support/a.h"),
    ("core/new_folder/a.cpp", "core/base/types.h"),
]
ALLOWED = [
    ("core/mesh/a.cpp", "core/base/types.h"),
    ("core/judge/a.cpp", "core/mesh/tet_mesh.h"),
    ("core/judge/a.cpp", "core/judge/judge.h"),
    ("core/simplify/a.cpp", "core/mesh/topology.h"),
    ("reference/tetfusion/a.cpp", "core/simplify/a.h"),
    ("reference/tetfusion/a.cpp", "reference/adapter.h"),
    ("reference/tetfusion/a.cpp", "reference/tetfusion/a.h"),
    ("experiments/a.cpp", "core/judge/judge.h"),
    ("experiments/a.cpp", "reference/adapter.h"),
    ("tests/judge/a_test.cpp", "core/judge/judge.h"),
    ("tests/judge/a_test.cpp", "tests/support/a.h"),
]


class Floors(unittest.TestCase):
    def write(self, root, source, text):
        path = root / source
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def test_each_forbidden_include_is_found(self):
        for source, target in FORBIDDEN:
            with self.subTest(source=source, target=target), tempfile.TemporaryDirectory() as folder:
                root = pathlib.Path(folder)
                self.write(root, source, f'#pragma once\n#include <vector>\n\n  #  include "{target}"\n')
                found = floors.check_sources(root)
                self.assertEqual(len(found), 1, found)
                self.assertTrue(found[0].startswith(f"{source}:4: includes {target}: "), found)

    def test_each_allowed_include_passes(self):
        for source, target in ALLOWED:
            with self.subTest(source=source, target=target), tempfile.TemporaryDirectory() as folder:
                root = pathlib.Path(folder)
                self.write(root, source, f'#include "{target}"\n')
                self.assertEqual(floors.check_sources(root), [])

    def test_an_include_beside_the_file_does_not_slip_through(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            self.write(root, "core/mesh/topology.h", "")
            self.write(root, "core/judge/a.cpp", '#include "../mesh/topology.h"\n')
            self.assertEqual(len(floors.check_sources(root)), 1)

    def test_the_report_imports_nothing_of_ours(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            self.write(root, "report/a.py", "import csv\nimport records\nfrom experiments import plan\n")
            self.assertEqual(len(floors.check_sources(root)), 1)


if __name__ == "__main__":
    unittest.main()

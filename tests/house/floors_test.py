"""The floors test must catch each kind of violation, and must let pass what the design allows."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import floors

FORBIDDEN = [
    ("core/base/a.h", "core/mesh/tet_mesh.h"),
    ("core/mesh/a.cpp", "core/judge/mesh/judge.h"),
    ("core/mesh/a.cpp", "core/mesh/io/medit.h"),
    ("core/judge/mesh/a.cpp", "core/mesh/topology.h"),
    ("core/judge/mesh/a.cpp", "core/simplify/fusion/a.h"),
    ("core/judge/mesh/a.cpp", "core/judge/surface/a.h"),
    ("core/simplify/fusion/a.h", "core/judge/mesh/judge.h"),
    ("core/simplify/fusion/a.h", "core/simplify/surface/a.h"),
    ("core/simplify/fusion/a.h", "reference/door/adapter.h"),
    ("reference/tetfusion/a.cpp", "reference/cgal/a.h"),
    ("reference/tetfusion/a.cpp", "experiments/plan_reader/plan.h"),
    ("reference/door/a.cpp", "reference/cgal/a.h"),
    ("reference/door/a.cpp", "reference/simplifier_support/a.h"),
    ("experiments/text/a.cpp", "experiments/files/a.h"),
    ("experiments/contests/a.cpp", "experiments/contests/deform/a.h"),
    ("experiments/contests/motion/a.cpp", "experiments/contests/deform/a.h"),
    ("experiments/runner/a.cpp", "tests/support/a.h"),
    ("core/mesh/a.cpp", "tests/support/a.h"),
]
ALLOWED = [
    ("core/mesh/a.cpp", "core/base/types.h"),
    ("core/judge/mesh/a.cpp", "core/mesh/tet_mesh.h"),
    ("core/judge/surface/a.cpp", "core/judge/mesh/judge.h"),
    ("core/simplify/fusion/a.cpp", "core/mesh/topology.h"),
    ("reference/tetfusion/a.cpp", "core/simplify/fusion/a.h"),
    ("reference/tetfusion/a.cpp", "reference/door/adapter.h"),
    ("reference/tetfusion/a.cpp", "reference/tetfusion/b.h"),
    ("reference/fenicsx/a.cpp", "reference/fenicsx/motion/a.h"),
    ("experiments/runner/a.cpp", "core/judge/mesh/judge.h"),
    ("experiments/runner/a.cpp", "experiments/contests/deform/a.h"),
    ("experiments/contests/deform/a.cpp", "experiments/contests/contest.h"),
    ("experiments/main.cpp", "experiments/commands/commands.h"),
    ("experiments/runner/a.cpp", "reference/door/adapter.h"),
    ("tests/judge/a_test.cpp", "core/judge/mesh/judge.h"),
    ("tests/judge/a_test.cpp", "tests/support/a.h"),
]


class Floors(unittest.TestCase):
    def write(self, root, source, text):
        path = root / source
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        (path.parent / "README.md").write_text("# A room\n", encoding="utf-8")

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
            self.write(root, "core/judge/mesh/a.cpp", '#include "../../mesh/topology.h"\n')
            self.assertEqual(len(floors.check_sources(root)), 1)

    def test_a_room_has_a_place_a_readme_and_few_files(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            self.write(root, "core/new_folder/a.cpp", "")
            self.write(root, "core/base/a.h", "")
            (root / "core/base/README.md").unlink()
            for i in range(floors.MOST_FILES + 1):
                self.write(root, f"core/mesh/a{i}.h", "")
            found = floors.check_sources(root)
            self.assertEqual([line.split(":")[0] for line in found], ["core/base", "core/mesh", "core/new_folder"], found)

    def test_what_sanitized_builds_leave_out_is_compiled_everywhere(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            self.write(root, "experiments/processes/child/sanitizers.h", "#ifdef PALPATE_SANITIZED\n#endif\n")
            self.write(root, "core/base/a.cpp", "// PALPATE_SANITIZED in words\n")
            self.assertEqual(floors.check_sources(root), [])
            self.write(root, "tests/a_test.cpp", "#  if !defined(PALPATE_SANITIZED)\n#endif\n")
            self.assertEqual([line.split(":")[0] for line in floors.check_sources(root)], ["tests/a_test.cpp"])

    def test_a_circle_of_files_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            self.write(root, "core/mesh/a.h", '#include "core/mesh/b.h"\n')
            self.write(root, "core/mesh/b.h", "")
            self.write(root, "core/mesh/a.cpp", '#include "core/mesh/a.h"\n')
            self.assertEqual(floors.check_sources(root), [])
            self.write(root, "core/mesh/b.cpp", '#include "core/mesh/a.h"\n')
            self.assertEqual(floors.check_sources(root), ["core/mesh/b: a circle: core/mesh/a > core/mesh/b > core/mesh/a"])

    def test_the_plan_stands_in_architecture(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "ARCHITECTURE.md").write_text("\n".join(floors.plan_lines()), encoding="utf-8")
            self.assertEqual(floors.check_architecture(root), [])
            (root / "ARCHITECTURE.md").write_text("\n".join(floors.plan_lines()[:-1]), encoding="utf-8")
            self.assertEqual(len(floors.check_architecture(root)), 1)

    def test_the_report_imports_nothing_of_ours(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            self.write(root, "report/a.py", "import csv\nimport records\nfrom experiments import plan\n")
            self.assertEqual(len(floors.check_sources(root)), 1)

    def test_the_view_is_below_the_pages_and_pages_import_nothing_else(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            self.write(root, "page/view/a.ts", 'import * as THREE from "three";\nimport { b } from "./b";\n')
            self.write(root, "page/report/c.ts", 'import { a } from "../view/a";\n')
            (root / "page/view/README.md").write_text("x", encoding="utf-8")
            (root / "page/report/README.md").write_text("x", encoding="utf-8")
            self.assertEqual(floors.check_sources(root), [])
            self.write(root, "page/view/b.ts", 'import { c } from "../report/c";\n')
            self.write(root, "page/report/d.ts", 'const e = await import("../../experiments/e");\n')
            self.assertEqual([line.split(":")[0] for line in floors.check_sources(root)], ["page/report/d.ts", "page/view/b.ts"])

    def test_rooms_of_the_report_import_the_shared_one_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            self.write(root, "report/motion/b.py", "from shared.records import figure\nfrom motion import a\n")
            self.assertEqual(floors.check_sources(root), [])
            self.write(root, "report/deform/a.py", "from motion.b import text\n")
            self.assertEqual(len(floors.check_sources(root)), 1)


if __name__ == "__main__":
    unittest.main()

"""Each check of sources.py must refuse a bad file, must pass a good one, and must notice a changed header."""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
REPO = HERE.parents[1]


class Sources(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = pathlib.Path(self.folder.name).resolve() / "repo"
        self.build = self.root / "build"
        self.build.mkdir(parents=True)
        for name in (".clang-format", ".clang-tidy"):
            (self.root / name).write_bytes((REPO / name).read_bytes())
        self.write("core/base/good.h", "#pragma once\n#include <vector>\n\nusing Numbers = std::vector<int>;\n")
        self.write("core/base/good.cpp", '#include "core/base/good.h"\n\nint count(const Numbers& numbers);\n')
        command = f"/usr/bin/g++ -I{self.root} -std=c++20 -c {self.root}/core/base/good.cpp"
        entry = {"directory": str(self.build), "command": command, "file": f"{self.root}/core/base/good.cpp"}
        (self.build / "compile_commands.json").write_text(json.dumps([entry]), encoding="utf-8")

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def hold(self, kind, *more, full=""):
        environment = {**os.environ, "PALPATE_FULL": full}
        done = subprocess.run([sys.executable, "-B", HERE / "sources.py", kind, self.root, self.build, *more],
                              capture_output=True, text=True, env=environment)
        return done.returncode, done.stdout

    def test_good_files_pass_and_are_remembered(self):
        for kind in ("headers", "format", "tidy"):
            with self.subTest(kind=kind):
                code, said = self.hold(kind)
                self.assertEqual(code, 0, said)
                self.assertRegex(said, "[1-9] passed, 0 known")
                code, said = self.hold(kind)
                self.assertEqual(code, 0, said)
                self.assertRegex(said, "0 passed, [1-9] known")

    def test_what_was_recorded_is_known_in_another_checkout_until_it_changes(self):
        for kind in ("headers", "tidy"):
            self.assertEqual(self.hold(kind)[0], 0)
            self.assertIn("1 files recorded", self.hold(kind, "--record")[1])
        moved = self.root.with_name("moved")
        shutil.copytree(self.root, moved, ignore=shutil.ignore_patterns("checked"))
        commands = moved / "build/compile_commands.json"
        commands.write_text(commands.read_text(encoding="utf-8").replace(str(self.root), str(moved)), encoding="utf-8")
        self.root, self.build = moved, moved / "build"
        for kind in ("headers", "tidy"):
            self.assertIn("0 passed, 1 known", self.hold(kind)[1])
            self.assertIn("1 passed, 0 known", self.hold(kind, full="1")[1])
        shutil.rmtree(self.build / "checked")
        self.write("core/base/good.cpp", "int BadName() { return 0; }\n")
        self.assertEqual(self.hold("tidy")[0], 1)

    def test_what_moves_is_known_where_it_goes(self):
        for kind in ("headers", "tidy"):
            self.assertEqual(self.hold(kind)[0], 0)
            self.assertIn("1 files recorded", self.hold(kind, "--record")[1])
        shutil.rmtree(self.build / "checked")
        (self.root / "core/base").rename(self.root / "core/ground")
        self.write("core/ground/good.cpp", '#include "core/ground/good.h"\n\nint count(const Numbers& numbers);\n')
        commands = self.build / "compile_commands.json"
        commands.write_text(commands.read_text(encoding="utf-8").replace("core/base", "core/ground"), encoding="utf-8")
        for kind in ("headers", "tidy"):
            self.assertIn("0 passed, 1 known", self.hold(kind)[1])
        self.write("core/ground/good.h", "#pragma once\n#include <vector>\n\nusing Numbers = std::vector<long>;\n")
        self.assertIn("1 passed, 0 known", self.hold("tidy")[1])

    def test_a_source_that_is_compiled_with_others_is_held_as_if_alone(self):
        for kind in ("headers", "tidy"):
            self.assertEqual(self.hold(kind)[0], 0)
        self.write("core/base/bad.cpp", '#include "core/base/good.h"\n\nint BadName(const Numbers& numbers);\n')
        united = self.build / "library.dir/Unity/unity_core_base_cxx.cxx"
        united.parent.mkdir(parents=True)
        united.write_text("".join(f'#include "{self.root}/core/base/{name}.cpp"\n\n' for name in ("bad", "good")), encoding="utf-8")
        command = f"/usr/bin/g++ -I{self.root} -Wno-subobject-linkage -std=c++20 -c {united}"
        entry = {"directory": str(self.build), "command": command, "file": str(united)}
        (self.build / "compile_commands.json").write_text(json.dumps([entry]), encoding="utf-8")
        self.assertIn("1 known", self.hold("headers")[1])
        code, said = self.hold("tidy")
        self.assertEqual(code, 1)
        self.assertIn("1 known", said)
        self.assertIn("BadName", said)

    def test_only_what_passed_here_is_recorded(self):
        self.assertIn("0 files recorded", self.hold("tidy", "--record")[1])
        self.assertIn("1 passed, 0 known", self.hold("tidy")[1])

    def test_a_header_that_needs_another_is_refused(self):
        self.write("core/base/bad.h", "#pragma once\ninline std::vector<int> none() { return {}; }\n")
        code, said = self.hold("headers")
        self.assertEqual(code, 1)
        self.assertIn("core/base/bad.h", said)

    def test_untidy_layout_is_refused(self):
        self.write("core/base/bad.h", "#pragma once\nint   f( );\n")
        self.assertEqual(self.hold("format")[0], 1)

    def test_a_name_against_the_style_is_refused(self):
        self.write("core/base/good.cpp", "int BadName() { return 0; }\n")
        code, said = self.hold("tidy")
        self.assertEqual(code, 1)
        self.assertIn("readability-identifier-naming", said)

    def test_a_changed_header_is_looked_at_again(self):
        self.assertEqual(self.hold("tidy")[0], 0)
        self.write("core/base/good.h", "#pragma once\n#include <vector>\nusing Numbers = std::vector<int>;\nint BadName();\n")
        self.assertIn("0 known", self.hold("tidy")[1])

    def test_a_check_is_left_out_only_where_the_vendor_s_header_is_reached(self):
        copied = "#include <string>\nunsigned long size(std::string text) { return text.size(); }\n"
        self.write("core/base/good.cpp", copied)
        code, said = self.hold("tidy")
        self.assertEqual(code, 1)
        self.assertIn("performance-unnecessary-value-param", said)
        self.write("CLI/CLI.hpp", "#pragma once\n")
        self.write("core/base/good.h", "#include <CLI/CLI.hpp>\n")
        self.write("core/base/good.cpp", '#include "core/base/good.h"\n' + copied)
        code, said = self.hold("tidy")
        self.assertEqual(code, 0, said)

    def test_tests_are_held_to_the_style_but_not_searched_for_paths(self):
        slip = '#include "core/base/good.h"\n\nint half(int* at) {\n  at = nullptr;\n  return *at;\n}\n'
        self.write("core/base/good.cpp", slip)
        self.assertIn("clang-analyzer-core.NullDereference", self.hold("tidy")[1])
        self.write("gtest/gtest.h", "#pragma once\n")
        self.write("core/base/good.h", "#pragma once\n#include <gtest/gtest.h>\n")
        code, said = self.hold("tidy")
        self.assertEqual(code, 0, said)
        self.write("core/base/good.cpp", slip.replace("half", "HalfOf"))
        self.assertIn("readability-identifier-naming", self.hold("tidy")[1])


if __name__ == "__main__":
    unittest.main()

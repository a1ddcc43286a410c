"""Installed files find each other wherever they lie, and nothing is written among them: the installed layout in a scratch folder, without root.

    /usr/bin/python3 -B tests/package/layout_test.py BUILD_DIR

What needs a bare Debian is in package_test.py, in the full mode.
"""

import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build" / "release").absolute()
PLAN = """\
schema: palpate/plan/1
question: Does what was installed find itself?
contest: simplify
meshes:
  - {name: cube, make: cube, vertices: 343}
contestants:
  - {method: palpate.hierarchical, label: hierarchical, stop: {ratio: 0.2}}
run: {repeats: 1, warmup: 0, timed: false, timeout_s: 60}
measure: [percent_above_0_5]
"""


def digests(folder):
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.rglob("*") if path.is_file()}


class Layout(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        top = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="palpate-layout-")))
        cls.prefix, cls.work, cls.home = top / "prefix", top / "work", top / "home"
        cls.work.mkdir()
        cls.home.mkdir()
        for component in ("program", "manual"):
            subprocess.run(["cmake", "--install", BUILD, "--prefix", cls.prefix, "--component", component], check=True, capture_output=True)
        cls.before = digests(cls.prefix)

    def tearDown(self):
        self.assertEqual(digests(self.prefix), self.before)

    def palpate(self, *words, code=0, without=(), **more):
        own = {name: value for name, value in os.environ.items() if not name.startswith(("PALPATE_", "XDG_"))}
        own = {**own, "HOME": str(self.home), "NO_COLOR": "1", **more}
        for name in without:
            own.pop(name)
        done = subprocess.run([self.prefix / "bin" / "palpate", *words], cwd=self.work, env=own, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def run_once(self):
        if not (self.work / "one").exists():
            (self.work / "one.yaml").write_text(PLAN, encoding="utf-8")
            self.palpate("run", "one")
            (run,) = (self.work / "results" / "one").iterdir()
            run.rename(self.work / "one")
        return self.work / "one"

    def test_what_the_program_reads_of_the_sources_is_installed(self):
        share = self.prefix / "share" / "palpate"
        for pattern in ("experiments/plans/*.yaml", "experiments/scenes/*.yaml", "experiments/schema/*.json", "experiments/training/*.yaml", "experiments/fit/candidates.yaml",
                        "experiments/campaign/workflow/**/*", "reference/*/contestant.yaml", "reference/organ_data.sh", "report/**/*.py", "report/**/*.css", "results/accepted/*.json"):
            wanted = {str(path.relative_to(ROOT)) for path in ROOT.glob(pattern) if path.is_file() and "__pycache__" not in path.parts}
            self.assertTrue(wanted, pattern)
            self.assertEqual({name for name in wanted if not (share / name).is_file()}, set())
        self.palpate("check", *sorted(path.stem for path in (share / "experiments" / "plans").glob("*.yaml")))

    def test_its_programs_are_those_of_the_build(self):
        listed = json.loads(self.palpate("list", "contestants", "--json").stdout)["contestants"]
        built = json.loads(subprocess.run([BUILD / "bin" / "palpate", "list", "contestants", "--json"], capture_output=True, text=True, check=True).stdout)["contestants"]
        self.assertEqual([(each["folder"], each["available"]) for each in listed], [(each["folder"], each["available"]) for each in built])
        self.assertIn(", package", self.palpate("--version").stdout)

    def test_a_run_lies_in_the_current_folder(self):
        run = self.run_once()
        provenance = json.loads((run / "provenance.json").read_text(encoding="utf-8"))
        self.assertEqual(provenance["source"], "package")
        page = (run / "report.html").read_text(encoding="utf-8")
        self.assertIn("palpate run plan.yaml", page)
        self.assertNotIn("./palpate", page)
        self.assertNotIn(str(ROOT), page)

    def test_accepted_figures_are_copied_before_they_are_changed(self):
        run = self.run_once()
        self.palpate("gate", run, code=1)
        self.palpate("gate", run, "--update")
        self.assertTrue((self.work / "results" / "accepted" / "one.json").is_file())
        self.palpate("gate", run)

    def test_what_is_kept_lies_with_the_user(self):
        shapes = json.loads(self.palpate("list", "meshes", "--json").stdout)["meshes"]
        if not next(shape["available"] for shape in shapes if shape["name"] == "ball"):
            self.skipTest("nothing that is filled is kept: libgmsh-dev is missing")
        ball = ("make", "ball", "--vertices", "200", "-o")
        self.assertIn("expected PALPATE_CACHE, XDG_CACHE_HOME or HOME", self.palpate(*ball, "none.mesh", code=2, without=["HOME"]).stderr)
        self.palpate(*ball, "one.mesh")
        self.assertTrue(any((self.home / ".cache" / "palpate").rglob("*.mesh")))
        self.palpate(*ball, "two.mesh", XDG_CACHE_HOME=str(self.work / "kept"))
        self.assertTrue(any((self.work / "kept" / "palpate").rglob("*.mesh")))

    def test_what_belongs_to_the_sources_is_said(self):
        self.assertIn("the tests run in the sources", self.palpate("test", code=3).stderr)
        self.assertIn(str(self.prefix / "share/palpate/experiments/plans"), self.palpate("run", "no_such_plan", code=2).stderr)

    def test_jobs_start_the_installed_program(self):
        self.run_once()
        self.palpate("workflow", "one.yaml", "-o", "jobs")
        self.assertEqual(json.loads((self.work / "jobs" / "campaign.json").read_text(encoding="utf-8"))["palpate"], str(self.prefix / "lib/palpate/palpate"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

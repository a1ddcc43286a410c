"""The Debian package, on a bare Debian 12: it installs, runs as a user who is not root, and leaves nothing behind.

    /usr/bin/python3 -B tests/package/package_test.py BUILD_DIR

BUILD_DIR is a Release build. Some 600 MB of packages are fetched once and kept in BUILD_DIR/package_cache. Exit code 77 where no bare
Debian can be made (a failure in the full mode, for root).
"""

import gzip
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from bare_debian import BareDebian, is_required, missing_need

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build" / "release")
SKIPPED = 77
USER, HOME = "tester", "/home/tester"
# What a user without the recommended packages cannot have.
OPTIONAL = {"bullet", "cgal_collapse", "fenicsx", "gmsh", "madlib", "netgen", "tetgen", "vtk"}
# Written by the system, not by the package.
SYSTEM = re.compile(r"/(var/(log|cache|lib/(dpkg|apt))|tmp|home|root|run)(/|$)|/etc/ld\.so\.cache$")
PLAN = """\
schema: palpate/plan/1
question: Does an installed palpate judge?
contest: simplify
meshes:
  - {name: cube, make: cube, vertices: 1000, jitter: 0.3, seed: 7}
contestants:
  - {method: palpate.hierarchical, label: hierarchical, stop: {ratio: 0.2}}
  - {method: palpate.refined, label: refined, stop: {ratio: 0.2}}
  - {method: cgal.remesh, label: cgal, stop: {ratio: 0.2}}
run: {repeats: 1, warmup: 0, timed: false, timeout_s: 120}
measure: [percent_above_0_5, inverted_tets]
accept: {inverted_tets: {max: 0}}
"""


def build_package(folder):
    done = subprocess.run([ROOT / "cmake" / "package" / "make_deb.sh", BUILD, folder], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return pathlib.Path(done.stdout.strip())


def field(package, name):
    return subprocess.run(["dpkg-deb", "-f", package, name], capture_output=True, text=True, check=True).stdout.strip()


class Package(unittest.TestCase):
    """One Debian, taken through its life: the tests run in the order of their names."""

    @classmethod
    def setUpClass(cls):
        folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="palpate-package-")))
        folder.chmod(0o755)
        cls.folder = folder
        cls.package = build_package(folder / "first")
        cls.debian = BareDebian(folder / "debian", BUILD / "package_cache")
        shutil.copyfile(cls.package, cls.debian.folder / "tmp" / cls.package.name)
        cls.debian.need("apt-get update")
        # What it depends on comes first, so that what is there before and after is of the package alone.
        depends = re.sub(r"\([^)]*\)|:any|,", " ", field(cls.package, "Depends"))
        cls.debian.need(f"apt-get install -y --no-install-recommends {depends}")
        cls.debian.need(f"useradd --create-home {USER}")
        cls.before = cls.debian.paths()

    def as_user(self, command, **how):
        return self.debian.need(command, user=USER, cwd=HOME, **how)

    def contestants(self):
        """{folder: reason why it is unavailable, or ""}"""
        listed = json.loads(self.as_user("palpate list contestants --json"))["contestants"]
        return {each["folder"]: each["reason"] for each in listed}

    def assert_all_accepted(self, run):
        records = [json.loads(line) for line in (self.debian.folder / HOME[1:] / run / "records.jsonl").read_text(encoding="utf-8").splitlines()]
        self.assertGreater(len(records), 0)
        for record in records:
            self.assertEqual(record["outcome"], "accepted", record["case"])
            self.assertTrue(record["judge"], record["case"])

    def test_1_the_package_is_the_same_to_the_byte_and_has_no_scripts(self):
        again = build_package(self.folder / "second")
        self.assertEqual(self.package.read_bytes(), again.read_bytes())
        control = self.folder / "control"
        subprocess.run(["dpkg-deb", "-e", self.package, control], check=True)
        self.assertEqual(sorted(each.name for each in control.iterdir()), ["control", "md5sums"])
        version = re.search(r"^project\(palpate VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.MULTILINE).group(1)
        self.assertEqual(field(self.package, "Version"), version)
        self.assertIn("libc6", field(self.package, "Depends"))
        self.assertIn("libdolfinx", field(self.package, "Recommends"))

    def test_2_it_installs_alone(self):
        self.debian.need(f"apt-get install -y --no-install-recommends /tmp/{self.package.name}")
        self.assertEqual(self.debian.need("dpkg --verify palpate").strip(), "")
        self.assertEqual(self.debian.need("apt-get check; dpkg --audit").count("palpate"), 0)
        owned = set(self.debian.need("dpkg -L palpate").split())
        type(self).new = {path for path in self.debian.paths() - self.before if not SYSTEM.match(path)}
        self.assertEqual(self.new - owned, set())
        for path in ("/usr/bin/palpate", "/usr/share/man/man1/palpate.1.gz", "/usr/share/doc/palpate/copyright", "/usr/share/palpate/experiments/plans/ci.yaml",
                     "/usr/share/bash-completion/completions/palpate", "/usr/share/zsh/vendor-completions/_palpate",
                     "/usr/share/fish/vendor_completions.d/palpate.fish", "/usr/lib/palpate/palpate_child"):
            self.assertIn(path, self.new)
        page = gzip.decompress((self.debian.folder / "usr/share/man/man1/palpate.1.gz").read_bytes())
        self.assertIn(b".TH PALPATE 1", page)

    def test_3_a_user_without_recommended_packages(self):
        helped = (ROOT / "experiments" / "commands" / "help" / "palpate.txt").read_text(encoding="utf-8")
        self.assertEqual(self.as_user("palpate --help"), helped)
        self.assertRegex(self.as_user("palpate --version"), r"^palpate \S+ \([0-9a-f]{9}, package")
        contestants = self.contestants()
        self.assertEqual({folder for folder, why in contestants.items() if why}, OPTIONAL)
        for folder in OPTIONAL:
            self.assertRegex(contestants[folder], r"lacks the shared library lib\S+, of a package that palpate recommends")
        self.as_user("palpate check $(ls /usr/share/palpate/experiments/plans)")
        (self.debian.folder / HOME[1:] / "installed.yaml").write_text(PLAN, encoding="utf-8")
        self.as_user("palpate run installed.yaml --out results/installed/one")
        self.assert_all_accepted("results/installed/one")
        provenance = json.loads((self.debian.folder / HOME[1:] / "results/installed/one/provenance.json").read_text(encoding="utf-8"))
        self.assertEqual(provenance["source"], "package")
        self.assertIn("palpate_simplify", provenance["programs"])
        page = (self.debian.folder / HOME[1:] / "results/installed/one/report.html").read_text(encoding="utf-8")
        self.assertIn("palpate run plan.yaml", page)
        self.assertNotIn("./palpate", page)
        if (BUILD / "page" / "report.js").exists():
            self.assertGreater(len(page), 500_000, "the page's scripts are in it")

    def test_4_accepted_figures_of_ones_own_lie_in_the_current_folder(self):
        self.as_user("palpate gate results/installed/one --update && palpate gate results/installed/one")
        self.assertTrue((self.debian.folder / HOME[1:] / "results/accepted/installed.json").is_file())
        done = self.debian.run("palpate gate results/installed/one --accepted /usr/share/palpate/results/accepted/ci.json", user=USER, cwd=HOME)
        self.assertEqual(done.returncode, 2, done.stdout)

    def test_5_what_cannot_be_had_is_said(self):
        done = self.debian.run("palpate run ci_deform --out none", user=USER, cwd=HOME)
        self.assertEqual(done.returncode, 3, done.stdout)
        self.assertIn("lacks the shared library", done.stdout)
        done = self.debian.run("palpate test", user=USER, cwd=HOME)
        self.assertEqual(done.returncode, 3, done.stdout)
        self.assertIn("the tests run in the sources", done.stdout)

    def test_6_smaller_commands(self):
        self.as_user("palpate make cube --vertices 500 -o cube.mesh && palpate quality cube.mesh && palpate simplify cube.mesh -o less.mesh --method palpate.refined --ratio 0.3"
                     " && palpate springs cube.mesh -o cube.csv --method isotropy_patch --young-pa 10000 --poisson 0.25"
                     " && palpate simulate /usr/share/palpate/experiments/scenes/plucked_bar.yaml -o plucked && palpate history results -o history"
                     " && palpate workflow installed.yaml -o jobs && palpate report results/installed/one")
        for made in ("less.mesh", "cube.csv", "plucked/history.csv", "jobs/Snakefile", "jobs/campaign.json"):
            self.assertTrue((self.debian.folder / HOME[1:] / made).exists(), made)
        campaign = json.loads((self.debian.folder / HOME[1:] / "jobs/campaign.json").read_text(encoding="utf-8"))
        self.assertEqual(campaign["palpate"], "/usr/lib/palpate/palpate")
        offered = self.as_user(["/bin/bash", "-c", ". /usr/share/bash-completion/completions/palpate; COMP_WORDS=(palpate run thesis_hist); COMP_CWORD=2; _palpate; "
                                                   "printf '%s\\n' \"${COMPREPLY[@]}\""])
        self.assertEqual(offered.split(), ["thesis_histograms"])

    def test_7_with_recommended_packages_everything_is_there(self):
        # Of "one | another" the first, as apt takes it.
        recommended = [re.split(r"[ (|]", entry.strip())[0] for entry in field(self.package, "Recommends").split(",")]
        self.debian.need(f"apt-get install -y --no-install-recommends {' '.join(recommended)}")
        self.assertEqual({folder for folder, why in self.contestants().items() if why}, set())
        for plan in ("ci", "ci_peers", "ci_deform"):
            self.as_user(f"palpate run {plan}")
            (run,) = (self.debian.folder / HOME[1:] / "results" / plan).iterdir()
            self.assert_all_accepted(run.relative_to(self.debian.folder / HOME[1:]))
            self.assertRegex(self.as_user(f"palpate gate results/{plan}"), r"holds: (\d+) of \1 figures hold")
        homeless = self.debian.run("env -u HOME palpate make ball --vertices 300 -o ball.mesh", user=USER, cwd=HOME)
        self.assertEqual(homeless.returncode, 2, homeless.stdout)
        self.assertIn("expected PALPATE_CACHE, XDG_CACHE_HOME or HOME", homeless.stdout)
        if (BUILD / "page" / "live_engine.js").exists():
            self.as_user("palpate live cube.mesh -o live.html")
            self.assertTrue((self.debian.folder / HOME[1:] / "live.html").is_file())

    def test_8_root_writes_nothing_below_usr_either(self):
        def below_usr():
            found = {}
            for path in (self.debian.folder / "usr").rglob("*"):
                if "palpate" in str(path.relative_to(self.debian.folder)):
                    known = path.lstat()
                    found[path] = (known.st_mtime_ns, known.st_size)
            return found

        before = below_usr()
        self.debian.need("palpate run installed.yaml --out /root/run && palpate report /root/run && palpate gate /root/run --update", cwd=HOME)
        self.assertEqual(below_usr(), before)

    def test_9_removed_nothing_of_it_is_left(self):
        before = self.debian.paths()
        self.debian.need("apt-get purge -y palpate")
        after = self.debian.paths()
        gone = {path for path in before - after if not SYSTEM.match(path)}
        self.assertEqual(gone, self.new)
        self.assertEqual({path for path in after - before if not SYSTEM.match(path)}, set())
        left = [path for path in after if "palpate" in path and not re.match(rf"({HOME}|/root|/tmp|/var/(log|cache))/", path)]
        self.assertEqual(left, [])


if __name__ == "__main__":
    why = missing_need()
    if why:
        print(f"skipped: {why}", file=sys.stderr)
        sys.exit(1 if is_required() else SKIPPED)
    unittest.main(argv=sys.argv[:1], verbosity=2)

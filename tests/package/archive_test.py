"""The source archive: what git holds and no more, the same bytes each time, named by the version, and built without a .git folder.

    /usr/bin/python3 -B tests/package/archive_test.py

Its build is configured, not compiled: tests/package/container_test.py compiles it, in the full mode.
"""

import hashlib
import pathlib
import re
import subprocess
import tarfile
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "cmake" / "package" / "make_archive.sh"
VERSION_FILE = "experiments/records/source_version.yaml"


def git(*words, **how):
    return subprocess.run(["git", "-C", how.pop("at", ROOT), *words], capture_output=True, check=True, text=True, **how).stdout


def make(folder, *commit, **how):
    done = subprocess.run([SCRIPT, folder, *commit], capture_output=True, text=True, check=False, **how)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return pathlib.Path(done.stdout.strip())


@unittest.skipUnless((ROOT / ".git").exists(), "these sources are an archive's")
class Archive(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="palpate-archive-")))
        cls.archive = make(cls.folder / "one")
        cls.version = re.search(r"^project\(palpate VERSION (\S+)", git("show", "HEAD:CMakeLists.txt"), re.MULTILINE).group(1)
        with tarfile.open(cls.archive) as tar:
            cls.members = {member.name: member for member in tar.getmembers()}
            tar.extractall(cls.folder, filter="tar") if hasattr(tarfile, "tar_filter") else tar.extractall(cls.folder)
        cls.top = cls.folder / f"palpate-{cls.version}"

    def test_it_is_named_by_the_version(self):
        self.assertEqual(self.archive.name, f"palpate-{self.version}.tar.gz")
        self.assertEqual({name.split("/")[0] for name in self.members}, {f"palpate-{self.version}"})

    def test_the_same_commit_gives_the_same_bytes_whoever_asks(self):
        home = self.folder / "home"
        home.mkdir()
        (home / ".gitconfig").write_text("[tar]\n\tumask = 0077\n[core]\n\tautocrlf = true\n[safe]\n\tdirectory = *\n", encoding="utf-8")
        again = make(self.folder / "two", env={"HOME": str(home), "PATH": "/usr/bin:/bin", "TZ": "Asia/Tokyo", "LC_ALL": "C"})
        digests = {hashlib.sha256(each.read_bytes()).hexdigest() for each in (self.archive, again)}
        self.assertEqual(len(digests), 1)

    def test_it_holds_what_git_holds_byte_by_byte(self):
        listed = {}
        for line in git("ls-tree", "-r", "-z", "HEAD").split("\0")[:-1]:
            head, name = line.split("\t")
            listed[name] = head.split(" ")[2]
        self.assertGreater(len(listed), 1000)
        files = {name.split("/", 1)[1] for name, member in self.members.items() if not member.isdir()}
        self.assertEqual(files, set(listed))
        names = sorted(name for name in listed if name != VERSION_FILE)
        hashes = git("hash-object", "--no-filters", "--stdin-paths", input="\n".join(str(self.top / name) for name in names)).split()
        self.assertEqual([name for name, found in zip(names, hashes) if found != listed[name]], [])

    def test_it_says_which_commit_it_is(self):
        text = (self.top / VERSION_FILE).read_text(encoding="utf-8")
        self.assertIn(f'commit: "{git("rev-parse", "HEAD").strip()}"', text)
        self.assertIn("source: archive", text)

    def test_the_launcher_runs_and_the_build_is_configured_without_git(self):
        self.assertFalse((self.top / ".git").exists())
        helped = subprocess.run([self.top / "palpate", "run", "--help"], capture_output=True, text=True, check=True).stdout
        self.assertEqual(helped, (ROOT / "experiments/commands/help/run.txt").read_text(encoding="utf-8"))
        done = subprocess.run(["cmake", "--preset", "release", "-DPALPATE_BUILD_TESTS=ON"], cwd=self.top, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr[-2000:])
        build = self.top / "build" / "release"
        inputs = subprocess.run(["ninja", "-C", build, "-t", "inputs", "programs"], capture_output=True, text=True, check=True).stdout.split("\n")
        sources = [name for name in inputs if name.startswith(str(self.top)) and not name.startswith(str(build))]
        self.assertGreater(len(sources), 50)
        self.assertEqual([name for name in sources if not pathlib.Path(name).exists()], [])

    def test_what_is_no_checkout_is_refused(self):
        done = subprocess.run([self.top / "cmake" / "package" / "make_archive.sh", self.folder], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 3)
        self.assertIn("no checkout", done.stderr)
        done = subprocess.run([SCRIPT, self.folder / "three", "no_such_commit"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)


if __name__ == "__main__":
    unittest.main(verbosity=2)

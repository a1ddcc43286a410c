"""The steps of the Containerfile, in bare roots of Debian 12 in the place of a container engine: from the source archive to a run.

    /usr/bin/python3 -B tests/package/container_test.py WORK_DIR [--ccache DIR]

The archive is that of HEAD. WORK_DIR/package_cache keeps the packages that were fetched (2 GB). --ccache takes a compiler's cache along,
which is no step of the recipe: without it the build takes what a first one takes. Exit code 77 where no bare Debian can be made
(a failure in the full mode, for root).
"""

import argparse
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

from bare_debian import BareDebian, is_required, missing_need

ROOT = pathlib.Path(__file__).resolve().parents[2]
SKIPPED = 77
STEPS = ("FROM", "WORKDIR", "COPY", "RUN", "ENTRYPOINT")
ARGUMENTS = argparse.Namespace(work=None, ccache=None)


def steps_of(text):
    """[(step, words behind it)] of a Containerfile; lines that go on are one. Fails for a step that is not known here."""
    joined = re.sub(r"\\\n", " ", re.sub(r"(?m)^#.*\n", "", text))
    steps = []
    for line in filter(None, map(str.strip, joined.split("\n"))):
        step, _, rest = line.partition(" ")
        if step not in STEPS:
            raise ValueError(f"a step that this test does not know: {step}")
        steps.append((step, rest.strip()))
    return steps


class Stage:
    """One stage of the recipe: a bare Debian, and where its commands run."""

    def __init__(self, folder, cache):
        self.debian, self.cwd, self.entry = BareDebian(folder, cache), "/", []
        if ARGUMENTS.ccache:
            self.debian.need("apt-get update && apt-get install -y --no-install-recommends ccache")
            self.debian.binds.append(f"{ARGUMENTS.ccache}:/ccache")

    def inside(self, path):
        return self.debian.folder / os.path.normpath(os.path.join(self.cwd, path)).lstrip("/")

    def environment(self):
        jobs = {"CMAKE_BUILD_PARALLEL_LEVEL": os.environ["PALPATE_JOBS"]} if "PALPATE_JOBS" in os.environ else {}
        if not ARGUMENTS.ccache:
            return jobs
        return {**jobs, "CCACHE_DIR": "/ccache", "CCACHE_BASEDIR": self.cwd, "CCACHE_NOHASHDIR": "1", "CMAKE_CXX_COMPILER_LAUNCHER": "ccache", "CMAKE_C_COMPILER_LAUNCHER": "ccache",
                "CCACHE_SLOPPINESS": "pch_defines,time_macros,include_file_mtime,include_file_ctime", "CC": "/usr/bin/gcc", "CXX": "/usr/bin/g++"}

    def run(self, command, **how):
        return self.debian.need(command, cwd=self.cwd, environment=self.environment(), timeout=7200, **how)


def follow(text, context, folder, cache):
    """Follows the recipe with `context` as the folder to build from; returns its last stage."""
    stages, stage = {}, None
    for step, rest in steps_of(text):
        words = shlex.split(rest)
        if step == "FROM":
            if words[0] != "debian:12":
                raise ValueError(f"another base: {words[0]}")
            name = words[2] if len(words) == 3 and words[1] == "AS" else f"stage {len(stages)}"
            stage = stages[name] = Stage(folder / name.replace(" ", "_"), cache)
        elif step == "WORKDIR":
            stage.cwd = words[0]
            stage.inside(".").mkdir(parents=True, exist_ok=True)
        elif step == "COPY":
            source = context
            if words[0].startswith("--from="):
                source = stages[words.pop(0).removeprefix("--from=")].debian.folder
            shutil.copytree(source / words[0].lstrip("/"), stage.inside(words[1]), symlinks=True, dirs_exist_ok=True)
        elif step == "RUN":
            print(f"RUN {rest[:120]}", file=sys.stderr, flush=True)
            stage.run(rest)
        else:
            stage.entry = json.loads(rest)
    return stage


class Container(unittest.TestCase):
    def test_the_recipe_ends_in_a_palpate_that_judges(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory(prefix="palpate-container-")))
        folder.chmod(0o755)
        commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True, check=True).stdout[:9]
        made = subprocess.run([ROOT / "cmake" / "package" / "make_archive.sh", folder, commit], capture_output=True, text=True, check=True)
        archive = pathlib.Path(made.stdout.strip())
        subprocess.run(["tar", "-xzf", archive, "-C", folder], check=True)
        context = folder / archive.name.removesuffix(".tar.gz")
        stage = follow((context / "Containerfile").read_text(encoding="utf-8"), context, folder, ARGUMENTS.work / "package_cache")
        self.assertEqual(stage.entry, ["palpate"])
        self.assertRegex(stage.run([*stage.entry, "--version"]), rf"^palpate \S+ \({commit}, package\)")
        contestants = json.loads(stage.run([*stage.entry, "list", "contestants", "--json"]))["contestants"]
        self.assertEqual([each["folder"] for each in contestants if not each["available"]], [])
        stage.run([*stage.entry, "run", "ci"])
        self.assertRegex(stage.run([*stage.entry, "gate", "results/ci"]), r"holds: (\d+) of \1 figures hold")
        (run,) = (stage.inside("results/ci")).iterdir()
        provenance = json.loads((run / "provenance.json").read_text(encoding="utf-8"))
        self.assertEqual((provenance["source"], provenance["commit"], provenance["dirty"]), ("package", commit, None))
        self.assertGreater((run / "report.html").stat().st_size, 500_000, "the page has its scripts")
        stage.run([*stage.entry, "make", "cube", "--vertices", "500", "-o", "cube.mesh"])
        stage.run([*stage.entry, "live", "cube.mesh", "-o", "live.html"])


class Recipe(unittest.TestCase):
    def test_a_step_that_nobody_follows_is_refused(self):
        with self.assertRaises(ValueError):
            steps_of("FROM debian:12\nADD a b\n")
        self.assertEqual(steps_of("# no step\nFROM debian:12 AS a\nRUN one \\\n    && two\n"), [("FROM", "debian:12 AS a"), ("RUN", "one      && two")])


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("--ccache", type=pathlib.Path)
    ARGUMENTS = parser.parse_args()
    why = missing_need()
    if why:
        print(f"skipped: {why}", file=sys.stderr)
        sys.exit(1 if is_required() else SKIPPED)
    unittest.main(argv=sys.argv[:1], verbosity=2)

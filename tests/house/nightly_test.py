"""The nightly mode: stages that pass, fail, hang, cannot start and leave processes behind, and the summary of it all."""

import contextlib
import io
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / ".ci"))
import nightly  # noqa: E402


def shell(name, script, **more):
    return nightly.Stage(name, f"what {name} does", ["/bin/sh", "-c", script], **more)


def is_running(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"


class Nightly(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_all(self, stages, chosen=None):
        with contextlib.redirect_stdout(io.StringIO()):
            return nightly.run_stages(stages if chosen is None else chosen, [stage.name for stage in stages], self.folder, {"seed": 7})

    def test_each_stage_by_itself_and_all_in_the_summary(self):
        stages = [shell("good", "echo $WORD; exit 0", environment={"WORD": "seen"}), shell("bad", "echo because; echo; exit 3"),
                  nightly.Stage("absent", "is not there", ["/nonexistent/program"]), shell("hanging", "echo waits; sleep 1000", limit_s=0.2),
                  shell("killed", "kill -9 $$"), shell("last", "exit 0")]
        rows = self.run_all(stages)
        self.assertEqual([row["result"] for row in rows], ["passed", "failed", "failed", "timed out", "failed", "passed"])
        self.assertEqual([row["code"] for row in rows], [0, 3, None, None, -9, 0])
        self.assertEqual((self.folder / "good.log").read_text(), "seen\n")
        self.assertEqual(rows[1]["note"], "because")
        summary = json.loads((self.folder / "summary.json").read_text())
        self.assertEqual((summary["seed"], summary["stages"]), (7, rows))
        text = (self.folder / "summary.txt").read_text()
        self.assertEqual(text, nightly.table(rows))
        self.assertRegex(text, r"\n2 of 6 stages passed in \d:\d\d:\d\d; not: bad, absent, hanging, killed\n$")
        for words in ("exit code 3; bad.log ends: because", "hanging.log ends: waits", "cannot start /nonexistent/program"):
            self.assertIn(words, text)

    def test_fuzzing_takes_the_nights_seed_and_keeps_what_it_grew(self):
        options = nightly.read_options(["--seed", "20260208", "--readers", "off", "ply"])
        words = next(stage.command for stage in nightly.list_stages(options, self.folder) if stage.name == "fuzz")
        self.assertEqual(words[-8:], [str(nightly.BUILD), "30", "off", "ply", "--seed", "20260208", "--keep", str(self.folder / "fuzz")])
        help_text = subprocess.run([sys.executable, "-B", str(ROOT / "tests" / "fuzz" / "fuzz.py"), "--help"], capture_output=True, text=True, check=True).stdout
        for option in ("--seed", "--keep"):
            self.assertIn(option, help_text)
        refused = subprocess.run([sys.executable, "-B", str(ROOT / "tests" / "fuzz" / "fuzz.py"), "x", "1", "--seed", "0"], capture_output=True, text=True, check=False)
        self.assertEqual(refused.returncode, 2)

    def test_nights_in_a_row_fit_all_scenes(self):
        sys.path.insert(0, str(ROOT / "tests" / "experiments" / "fit"))
        import fit_scenes
        self.assertEqual(len(list(fit_scenes.scenes())), nightly.FIT_SCENES)
        for count in (10, 15, 40):
            fitted = []
            for seed in range(-(-nightly.FIT_SCENES // count)):
                options = nightly.read_options(["--seed", str(seed), "--fit-scenes", str(count)])
                words = next(stage.command for stage in nightly.list_stages(options, self.folder) if stage.name == "fits")
                first, every, scenes = (int(words[words.index(name) + 1]) for name in ("--first", "--every", "--scenes"))
                fitted += [each["scene"] for each in fit_scenes.scenes()][first::every][:scenes]
            self.assertEqual(sorted(fitted), list(range(nightly.FIT_SCENES)))

    def test_the_summary_is_there_after_each_stage(self):
        seen = []

        def run(stage, folder):
            seen.append((folder / "summary.json").exists())
            return {"stage": stage.name, "what": "", "result": "passed", "wall_s": 1.0, "code": 0, "note": "", "log": ""}

        stages = [shell("a", ""), shell("b", "")]
        with contextlib.redirect_stdout(io.StringIO()):
            nightly.run_stages(stages, ["a", "b"], self.folder, {}, run)
        self.assertEqual(seen, [False, True])

    def test_a_folder_is_gone_on_with(self):
        flag = self.folder / "mended"
        stages = [shell("a", "exit 0"), shell("b", f"test -e {flag}"), shell("c", "exit 0")]
        self.assertEqual([row["result"] for row in self.run_all(stages)], ["passed", "failed", "passed"])
        flag.touch()
        rows = self.run_all(stages, [stages[1]])
        self.assertEqual([(row["stage"], row["result"]) for row in rows], [("a", "passed"), ("b", "passed"), ("c", "passed")])

    def test_a_summary_of_several_commits_says_which_stage_ran_at_which(self):
        stages = [shell("first", "exit 0"), shell("second", "exit 0")]
        names = [stage.name for stage in stages]
        with contextlib.redirect_stdout(io.StringIO()):
            nightly.run_stages(stages, names, self.folder, {"commit": "aaa"})
            self.assertNotIn("aaa", (self.folder / "summary.txt").read_text())
            nightly.run_stages(stages[1:], names, self.folder, {"commit": "bbb"})
        text = (self.folder / "summary.txt").read_text()
        self.assertRegex(text, r"what first does, at aaa\n")
        self.assertRegex(text, r"what second does, at bbb\n")
        kept = json.loads((self.folder / "summary.json").read_text())
        self.assertEqual([kept["commit"], *(row["commit"] for row in kept["stages"])], ["bbb", "aaa", "bbb"])

    def test_what_a_stage_leaves_running_ends_with_it(self):
        note = self.folder / "pid"
        for script, limit_s in ((f"sleep 1000 & echo $! > {note}", 60.0), (f"sh -c 'trap \"\" TERM; echo $$ > {note}; while :; do sleep 1; done'", 1.0)):
            nightly_patience = nightly.end_group.__defaults__
            nightly.end_group.__defaults__ = (0.3,)
            try:
                self.run_all([shell("leaves", script, limit_s=limit_s)])
            finally:
                nightly.end_group.__defaults__ = nightly_patience
            process = int(note.read_text())
            deadline = time.monotonic() + 20
            while is_running(process) and time.monotonic() < deadline:
                time.sleep(0.02)
            self.assertFalse(is_running(process), script)

    def test_an_interrupt_ends_it_and_is_in_the_summary(self):
        program = (f"import sys, pathlib; sys.path.insert(0, {str(ROOT / '.ci')!r}); import nightly\n"
                   "nightly.catch_stops()\n"
                   f"stages = [nightly.Stage(n, n, ['/bin/sh', '-c', 'echo started; sleep 1000']) for n in 'ab']\n"
                   f"nightly.run_stages(stages, ['a', 'b'], pathlib.Path({str(self.folder)!r}), {{}})\n")
        process = subprocess.Popen([sys.executable, "-B", "-c", program], stdout=subprocess.DEVNULL)
        deadline = time.monotonic() + 60
        log = self.folder / "a.log"
        while not (log.exists() and log.read_text()) and time.monotonic() < deadline:
            time.sleep(0.02)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(60), 0)
        rows = json.loads((self.folder / "summary.json").read_text())["stages"]
        self.assertEqual([(row["stage"], row["result"]) for row in rows], [("a", "interrupted")])

    def test_every_stage_starts_what_is_there(self):
        options = nightly.read_options(["--seed", "5", "--soak-wall", "60", "--folder", str(self.folder)])
        stages = nightly.list_stages(options, self.folder)
        self.assertEqual(len({stage.name for stage in stages}), len(stages))
        for stage in stages:
            for word in stage.command:
                path = pathlib.Path(word)
                if path.is_absolute() and ROOT in path.parents and nightly.BUILD not in (path, *path.parents):
                    self.assertTrue(path.exists(), word)
        bench = next(stage for stage in stages if stage.name == "bench")
        self.assertIn(str(self.folder / "bench.json"), " ".join(bench.command))

    def test_a_summary_that_is_none_is_refused(self):
        for text in ("no json", "{}", "[1]", '{"stages": [1]}'):
            (self.folder / "summary.json").write_text(text)
            with contextlib.redirect_stderr(io.StringIO()) as said:
                self.assertEqual(nightly.main(["--no-build", "bench", "--folder", str(self.folder)]), 2)
            self.assertIn("expected an earlier summary", said.getvalue())

    def test_usage(self):
        for words in (["nonsense"], ["--soak-wall", "long"], ["--fit-scenes", "0"]):
            with contextlib.redirect_stderr(io.StringIO()) as said, self.assertRaises(SystemExit) as end:
                nightly.read_options(words)
            self.assertEqual(end.exception.code, 2)
            self.assertIn(words[-1], said.getvalue())
        done = subprocess.run([ROOT / ".ci" / "run", "nonsense"], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (2, ".ci/run: expected nothing, full or contests, found 'nonsense'\n"))


if __name__ == "__main__":
    unittest.main()

"""A plan as jobs, on this machine and on a Slurm of its own, a job killed half-way: the records are those of `palpate run`.

    /usr/bin/python3 -B tests/campaign/workflow_test.py PALPATE local|slurm

PALPATE is the program. Exit code 77 where Snakemake or Slurm is missing (PALPATE_FULL: a failure).
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

from one_node_slurm import OneNodeSlurm, missing_programs

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else ""
WHERE = sys.argv[2] if len(sys.argv) > 2 else ""
SKIPPED = 77
PLAN = """\
schema: palpate/plan/1
question: Do jobs leave what one run leaves?
contest: simplify
meshes:
  - {name: one, make: cube, vertices: 1728}
  - {name: two, make: cube, vertices: 1000, seed: 3}
contestants:
  - {method: palpate.hierarchical, label: hierarchical, stop: {ratio: 0.2}}
  - {method: tetfusion.sequential, label: random, set: {order: random}, stop: {tets_of: hierarchical}, seeds: 12}
run: {repeats: 6, timed: false, timeout_s: 120, memory_mib: 1024}
measure: [percent_above_0_5]
"""
BAR = """\
schema: palpate/scene/1
mesh: {make: bar, vertices: 300, unit_m: 0.02}
material: {young_modulus_pa: 10000, poisson_ratio: 0.25, density_kg_m3: 1050}
clamp: [{half_space: {normal: [1, 0, 0], offset_m: 0}, elastic_pa_per_m: 1.0e6}]
load: [{gravity_m_s2: [0, 0, -9.81]}]
analysis: static
"""
RANKS = """\
schema: palpate/plan/1
question: Are finite elements on two ranks those on one?
contest: deform
scenes: [{name: bar, file: bar.yaml}]
reference: {method: fem.p2, levels: 1}
contestants: [{method: fem.p1, label: p1}]
run: {repeats: 2, timed: false, timeout_s: 120, memory_mib: 4096, mpi_ranks: RANKS}
measure: [displacement_l2]
"""
# A contestant that crashes (exit code 3), and a plan whose acceptance does not hold (1): two verdicts that are no failures of the jobs.
CRASHES = """\
schema: palpate/contestant/1
contest: simplify
command: [/usr/bin/python3, -c, "raise SystemExit(5)"]
licence: none
source: this test
methods:
  - {name: test.crashes, summary: ends without an answer, stops: [ratio]}
"""
VERDICT = """\
schema: palpate/plan/1
question: Do jobs end where a run ends with another code than 0?
contest: simplify
contestant_folders: [adapters/crashes]
meshes: [{name: one, make: cube, vertices: 216}]
contestants:
  - {method: palpate.hierarchical, label: hierarchical, stop: {ratio: 0.2}}
  - {method: METHOD, label: other, stop: {ratio: 0.2}}
run: {repeats: 1, timed: false, timeout_s: 120, memory_mib: 1024}
accept: {mean_quality: {min: LEAST}}
"""
OF_A_REPEAT = ("finished_at", "peak_rss_bytes", "position", "sitting")  # what differs from one running of it to the next


def records_of(run):
    """(case, repeat) -> its record without what differs each time. Fails for one that is there twice."""
    records = {}
    for line in (run / "records.jsonl").read_text(encoding="utf-8").splitlines():
        record = json.loads(line)
        key = (record["case"], record["repeat"])
        assert key not in records, f"{key} is there twice"
        records[key] = {name: value for name, value in record.items() if name not in OF_A_REPEAT}
    return records


def outputs_of(run):
    return {str(path.relative_to(run)): path.read_bytes() for path in sorted((run / "meshes").rglob("*.mesh"))}


class Jobs(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory(prefix="palpate-campaign-")))
        self.jobs = self.folder / "a folder of jobs"

    def palpate(self, *words):
        done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def snakemake(self, *words, environment=None):
        return subprocess.Popen(["/usr/bin/snakemake", *words], cwd=self.jobs, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                text=True)


class Workflow(Jobs):
    def setUp(self):
        super().setUp()
        self.plan = self.folder / "parts.yaml"
        self.plan.write_text(PLAN, encoding="utf-8")
        self.whole = self.folder / "whole"
        self.palpate("run", self.plan, "--out", self.whole, "--no-report")
        self.palpate("workflow", self.plan, "-o", self.jobs, "--costs", self.whole, "--unknown-seconds", "0.5", "--job-seconds", "60")

    def assert_same(self):
        self.assertEqual((self.jobs / "finished").read_text(), "0\n")
        self.assertEqual(records_of(self.jobs / "run"), records_of(self.whole))
        self.assertEqual(outputs_of(self.jobs / "run"), outputs_of(self.whole))
        self.assertTrue((self.jobs / "run" / "report.html").is_file())

    @unittest.skipUnless(WHERE == "local", "by Slurm")
    def test_on_this_machine(self):
        self.run_jobs()
        # A gathering that was killed goes on with the run that it had begun.
        records = self.jobs / "run" / "records.jsonl"
        lines = records.read_bytes().splitlines(keepends=True)
        with open(records, "r+b") as file:
            file.truncate(sum(map(len, lines[:2])) + len(lines[2]) // 2)
        number = records.stat().st_ino
        (self.jobs / "finished").unlink()
        self.run_jobs()
        self.assertEqual(records.stat().st_ino, number)

    def run_jobs(self):
        running = self.snakemake("-j2")
        output, _ = running.communicate()
        self.assertEqual(running.returncode, 0, output)
        self.assert_same()

    @unittest.skipUnless(WHERE == "slurm", "on this machine")
    def test_by_slurm_with_a_job_that_is_killed_half_way(self):
        with OneNodeSlurm(self.enterContext(tempfile.TemporaryDirectory(prefix="palpate-slurm-"))) as slurm:
            running = self.snakemake("--profile", "slurm", "--jobs", "2", "--latency-wait", "10", environment=slurm.environment)
            part, killed = self.kill_one_half_way(slurm, running)
            output, _ = running.communicate()
            self.assertEqual(running.returncode, 0, output)
            sittings = json.loads((part / "provenance.json").read_text(encoding="utf-8"))["sittings"]
        self.assertGreaterEqual(len(sittings), 2, f"the part that was killed with {killed} records went on")
        self.assertIn("Error executing rule part", output)
        self.assert_same()

    def kill_one_half_way(self, slurm, running):
        """Kills the first job whose part has some records and not all. Returns the part's folder, and how many it had."""
        wanted = {path.stem: len(path.read_text().split()) * 6 for path in (self.jobs / "cases").glob("*.txt")}
        while running.poll() is None:
            for records in self.jobs.glob("parts/*/records.jsonl"):
                part = records.parent
                have = records.read_bytes().count(b"\n")
                if part.name in wanted and 3 <= have < wanted[part.name] - 10:
                    job = self.job_of(part)
                    if job is None:
                        continue
                    subprocess.run(["scancel", "--full", "--signal=KILL", job], env=slurm.environment, check=True)
                    return part, have
            time.sleep(0.05)
        self.fail("no job was caught half-way:\n" + running.stdout.read() + slurm.output_of("squeue"))
        return None

    def job_of(self, part):
        """Slurm's number of the job whose process of `palpate` works on the part."""
        for entry in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
            try:
                words = entry.read_bytes().decode(errors="replace").split("\0")
            except OSError:
                continue
            folder = pathlib.Path(os.path.realpath(entry.parent / "cwd")) if words[0] == PROGRAM else None
            if folder == self.jobs.resolve() and f"parts/{part.name}" in words:
                environment = (entry.parent / "environ").read_bytes().decode(errors="replace").split("\0")
                return next((word.removeprefix("SLURM_JOB_ID=") for word in environment if word.startswith("SLURM_JOB_ID=")), None)
        return None


@unittest.skipUnless(WHERE == "local", "by Slurm")
class Endings(Jobs):
    def test_a_run_that_ends_with_another_code_is_finished_all_the_same(self):
        folder = self.folder / "a {folder} of braces"
        (folder / "adapters" / "crashes").mkdir(parents=True)
        (folder / "adapters" / "crashes" / "contestant.yaml").write_text(CRASHES, encoding="utf-8")
        for code, method, least in ((3, "test.crashes", 0), (1, "palpate.outcome", 0.999)):
            plan = folder / f"verdict_{code}.yaml"
            plan.write_text(VERDICT.replace("METHOD", method).replace("LEAST", str(least)), encoding="utf-8")
            run = subprocess.run([PROGRAM, "run", plan, "--out", folder / f"run_{code}", "--no-report"], capture_output=True, text=True, check=False)
            self.assertEqual(run.returncode, code, run.stderr)
            self.jobs = folder / f"jobs_{code}"
            self.palpate("workflow", plan, "-o", self.jobs)
            running = self.snakemake("-j2")
            output, _ = running.communicate()
            self.assertEqual(running.returncode, 0, output)
            self.assertNotIn("Error in rule", output)
            self.assertEqual((self.jobs / "finished").read_text(), f"{code}\n")
            self.assertTrue((self.jobs / "run" / "report.html").is_file())
            self.assertEqual(records_of(self.jobs / "run"), records_of(folder / f"run_{code}"))

    def test_a_gathering_without_a_report_is_not_finished(self):
        (self.folder / "parts.yaml").write_text(PLAN, encoding="utf-8")
        self.palpate("workflow", self.folder / "parts.yaml", "-o", self.jobs)
        (self.jobs / "parts").mkdir()
        for part in (self.jobs / "cases").glob("*.txt"):
            (self.jobs / "parts" / f"{part.stem}.whole").touch()
        (self.jobs / "prepared").touch()
        campaign = json.loads((self.jobs / "campaign.json").read_text(encoding="utf-8"))
        (self.jobs / "campaign.json").write_text(json.dumps({**campaign, "palpate": "/usr/bin/false"}), encoding="utf-8")  # ends with 1 and leaves nothing
        running = self.snakemake("-j2")
        output, _ = running.communicate()
        self.assertNotEqual(running.returncode, 0)
        self.assertIn("Error in rule gather", output)
        self.assertFalse((self.jobs / "finished").exists())


@unittest.skipUnless(WHERE == "slurm", "on this machine")
class Ranks(unittest.TestCase):
    def palpate(self, *words, **options):
        done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, check=False, **options)
        self.assertEqual(done.returncode, 0, done.stderr)

    def records(self, run):
        lines = (run / "records.jsonl").read_text(encoding="utf-8").splitlines()
        return [record for record in map(json.loads, lines) if record["label"] == "p1"]

    def test_a_job_of_two_ranks_gives_the_figure_of_one(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory(prefix="palpate-ranks-")))
        (folder / "bar.yaml").write_text(BAR, encoding="utf-8")
        for count in (1, 2):
            (folder / f"ranks_{count}.yaml").write_text(RANKS.replace("RANKS", str(count)), encoding="utf-8")
        self.palpate("run", folder / "ranks_1.yaml", "--out", folder / "one", "--no-report")
        self.palpate("workflow", folder / "ranks_2.yaml", "-o", folder / "jobs")
        with OneNodeSlurm(self.enterContext(tempfile.TemporaryDirectory(prefix="palpate-slurm-"))) as slurm:
            words = ["/usr/bin/snakemake", "--profile", "slurm", "--jobs", "2", "--latency-wait", "10"]
            done = subprocess.run(words, cwd=folder / "jobs", env=slurm.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)
        one, two = self.records(folder / "one"), self.records(folder / "jobs" / "run")
        self.assertEqual([[record["report"]["processes"] for record in run] for run in (one, two)], [[1, 1], [2, 2]])
        self.assertGreater(one[0]["judge"]["displacement_l2"], 1e-3)
        for record in two:
            self.assertEqual(record["outcome"], "accepted", record)
            self.assertAlmostEqual(record["judge"]["displacement_l2"], one[0]["judge"]["displacement_l2"], delta=1e-7)


if __name__ == "__main__":
    needed = ["snakemake"] if WHERE == "local" else missing_programs()
    missing = [name for name in needed if name in missing_programs()]
    if WHERE == "slurm" and os.geteuid() != 0:
        missing.append("root, to run slurmd")
    if missing:
        print(f"skipped: {', '.join(missing)} is missing")
        sys.exit(1 if os.environ.get("PALPATE_FULL") else SKIPPED)
    sys.exit(unittest.main(argv=sys.argv[:1]))

"""The report of each plan opens: of every plan the first case is run, and its page is read from top to end in a real browser.

    /usr/bin/python3 -B tests/page/every_plan_test.py PALPATE [PLAN...]

PALPATE is the program; without names, all of experiments/plans. Prints what open_page.mjs says of each page. What a plan asks for may be missed by one
case alone (exit code 1); a page has to be there all the same, without an error, a request or a barrier.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
LONGEST_S = 3600  # of one case with its reference, or with the training of its springs


def first_case(palpate, plan):
    listed = subprocess.run([palpate, "run", plan, "--list-cases"], capture_output=True, text=True, check=True).stdout
    return listed.splitlines()[0]


def run_first_case(palpate, plan, out):
    """What went wrong, or ""."""
    words = [palpate, "run", plan, "--case", first_case(palpate, plan), "--out", out]
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=LONGEST_S, check=False)
    except subprocess.TimeoutExpired:
        return f"{plan.stem}: not done after {LONGEST_S} s"
    return "" if done.returncode in (0, 1) and (out / "report.html").is_file() else f"{plan.stem}: exit code {done.returncode}: {done.stderr[-500:]}"


def main(palpate, *names):
    plans = [ROOT / "experiments" / "plans" / f"{name}.yaml" for name in names] or sorted((ROOT / "experiments" / "plans").glob("*.yaml"))
    wrong, pages = [], []
    with tempfile.TemporaryDirectory(prefix="palpate-plans-") as folder:
        for plan in plans:
            out = pathlib.Path(folder) / plan.stem
            said = run_first_case(palpate, plan, out)
            wrong += [said] if said else []
            pages += [] if said else [out / "report.html"]
        opened = subprocess.run(["node", ROOT / "tests" / "page" / "open_page.mjs", ROOT, *pages], env=os.environ, check=False)
    print(f"{len(pages)} of {len(plans)} plans left a page", *wrong, sep="\n")
    return 1 if wrong or opened.returncode != 0 or not pages else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("usage: every_plan_test.py PALPATE [PLAN...]")
    sys.exit(main(*sys.argv[1:]))

"""Do two checkouts give the same results? For changes that must move none: a house rebuilt, code shared, a faster build.

    compare_checkouts.py BEFORE AFTER [PLAN...]

Runs the plans (those of .ci/run if none is named; as AFTER has them) with both checkouts' built programs, and compares all records: figures,
violations, reports and the hashes of meshes, springs, displacements and states; whatever a clock or the machine gives is left out
(VOLATILE). Prints each record that differs, with the places; exits with 1 if there is any, with 2 if a run did not end.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

PLANS = ("ci", "ci_peers", "ci_deform", "ci_motion", "ci_stability", "ci_haptics")
# What differs from run to run on one machine.
VOLATILE = {
    "finished_at", "kernel_s", "wall_s", "user_s", "peak_rss_bytes", "identify_s", "solve_s", "assembly_s", "factor_s", "frequencies_s",
    "setup_s", "seconds", "stable_step_kernel_s", "real_time_factor", "tick_real_time_factor", "tick_mean_s", "tick_p50_s", "tick_p99_s", "tick_p99_9_s",
    "tick_worst_s", "ticks_missed", "buckets", "bucket_ends_s", "from_cache", "position", "load_1min", "processor_s", "others_s",
}


def steady(value):
    """A record without what is volatile."""
    if isinstance(value, dict):
        return {key: steady(each) for key, each in value.items() if key not in VOLATILE}
    return [steady(each) for each in value] if isinstance(value, list) else value


def read_records(folder):
    records = {}
    with open(folder / "records.jsonl", encoding="utf-8") as lines:
        for line in lines:
            record = json.loads(line)
            records[record["case"], record.get("repeat"), record.get("warmup")] = steady(record)
    return records


def find_differences(before, after, place=""):
    """The places where two values differ, each with both."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in sorted(before.keys() | after.keys()):
            yield from find_differences(before.get(key), after.get(key), f"{place}/{key}")
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for i, (one, other) in enumerate(zip(before, after)):
            yield from find_differences(one, other, f"{place}/{i}")
    elif before != after:
        yield f"{place}: {json.dumps(before)} before, {json.dumps(after)} after"


def run(checkout, plan, folder):
    done = subprocess.run([checkout / "build/release/bin/palpate", "run", plan, "--out", folder, "--no-report"],
                          capture_output=True, text=True, cwd=checkout)
    if done.returncode not in (0, 1) or not (folder / "records.jsonl").is_file():
        print(f"{checkout}: {plan.name} ended with {done.returncode}:\n{done.stderr[-2000:]}")
        raise SystemExit(2)


def compare_plan(before, after, name, folder):
    """Runs it in both; returns (records, places that differ)."""
    plan = after / f"experiments/plans/{name}.yaml"
    for checkout, out in ((before, folder / "before"), (after, folder / "after")):
        run(checkout, plan, out)
    old, new = read_records(folder / "before"), read_records(folder / "after")
    found = [f"{name}: {key[0]}, repeat {key[1]}: {'only before' if key in old else 'only after'}" for key in old.keys() ^ new.keys()]
    for key in sorted(old.keys() & new.keys(), key=str):
        found += [f"{name}: {key[0]}, repeat {key[1]}: {place}" for place in find_differences(old[key], new[key])]
    return len(new), found


def main():
    before, after = (pathlib.Path(each).resolve() for each in sys.argv[1:3])
    differ = 0
    for name in sys.argv[3:] or PLANS:
        with tempfile.TemporaryDirectory() as folder:
            records, found = compare_plan(before, after, name, pathlib.Path(folder))
        print("\n".join(found[:40]) + ("\n" if found else "") + f"{name}: {records} records, {len(found)} places differ")
        differ += len(found)
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())

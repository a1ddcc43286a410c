"""A soak: a finger palpates a body for hours of simulated time, and energy, drift and memory have to stay flat.

    soak.py BUILD [SOURCE] [-o FOLDER] [--model springs|smoothed] [--vertices N] [--hours H] [--wall S] [--seed N]
            [--depth-share X] [--step-share X] [--against CSV]
    soak.py --read FOLDER

BUILD is a build folder (build/release). SOURCE is whatever `palpate live` takes (a mesh, a scene, a fit), a name that
`palpate make` makes (kidney, liver, bean ...; the default is a kidney of 1500 vertices), or cube:N. --hours are simulated ones
(24); --wall ends it sooner, after so many seconds of the clock. FOLDER (made; soak by default) gets soak.csv, a line a cycle,
soak.json with the verdict, and soak.svg. --against holds the hash of each cycle against that of another record of the same soak.
--read judges a folder anew.

A cycle is 2 s: down in 0.2 s at a place and to a depth at random, held 0.3 s (in half of the cycles it slides meanwhile, lifted to a
third of its depth), up in 0.2 s, let go, 1.3 s alone. Time goes on in ticks of 1 ms, each of as many steps as stability asks for.

Exit code 0 if the record is flat, 1 if it is not, 2 for bad usage, 3 if something needed could not run. Flat means, all of:

whole    nothing is NaN or infinite, the body never broke, and no tetrahedron is inverted once it was let alone
enough   40 cycles or more: a slope needs them
energy   1.3 s after each release the energy is below 1e-6 of what it was under the finger (a thousandth of the displacement), and its
         slope over the record is within its noise
drift    after each release no displacement is above 1e-4 of the deepest press, and the offset from rest (the largest displacement, and
         the mean one along x, y and z) has no slope: over the record it changes by less than its noise, or by less than 1e-5 of the
         deepest press
clock    the body's own time is within a tick of 1 ms of the number of ticks
memory   resident memory grows by less than 1 MiB after the first tenth of the record (not asked of a build with sanitizers, which keeps
         what is freed for a while)

Noise: the record is cut into 20 blocks; the slope of their means by least squares is within its noise if it is below 3.92 of its
standard errors (Student's t at 18 degrees of freedom, 1 in 1000 by chance).
"""

import argparse
import csv
import json
import math
import pathlib
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
CYCLE_S = 2.0
FEWEST_CYCLES = 40
BLOCKS = 20
STUDENT_T = 3.92  # two-sided, 18 degrees of freedom, 0.001
REST_ENERGY_SHARE = 1e-6
OFFSET_SHARE, DRIFT_SHARE = 1e-4, 1e-5  # of the deepest press
TICK_S = 1e-3
MEMORY_GROWTH = 1 << 20
WORDS = {"hash"}
OFFSETS = ("rest_largest_m", "rest_mean_x_m", "rest_mean_y_m", "rest_mean_z_m")


class SoakError(Exception):
    """Something that the user has to know; the exit code is the second argument."""


def read_record(path):
    """The rows of soak.csv; all but the hash as numbers."""
    with open(path, newline="", encoding="ascii") as file:
        rows = [row for row in csv.DictReader(file)]
    if not rows or any(None in row or None in row.values() for row in rows):
        raise SoakError(f"{path}: expected a whole line a cycle, found {'a line cut off' if rows else 'none'}", 2)
    try:
        return [{key: value if key in WORDS else float(value) for key, value in row.items()} for row in rows]
    except ValueError as error:
        raise SoakError(f"{path}: expected numbers, found another thing: {error}", 2) from None


def energy_at_rest(row):
    return row["rest_kinetic_j"] + row["rest_elastic_j"] + row["rest_load_j"]


def energy_pressed(row):
    return row["pressed_kinetic_j"] + row["pressed_elastic_j"] + row["pressed_load_j"]


def slope_over_record(values):
    """By how much the values change from the first to the last, by the means of 20 blocks, and the standard error of that."""
    blocks = [values[len(values) * k // BLOCKS:len(values) * (k + 1) // BLOCKS] for k in range(BLOCKS)]
    means = [statistics.fmean(block) for block in blocks]
    places = [(k + 0.5) / BLOCKS - 0.5 for k in range(BLOCKS)]
    spread = sum(place * place for place in places)
    slope = sum(place * mean for place, mean in zip(places, means)) / spread
    middle = statistics.fmean(means)
    left = sum((mean - middle - slope * place) ** 2 for place, mean in zip(places, means))
    return slope, math.sqrt(left / (BLOCKS - 2) / spread)


def is_within_noise(values):
    change, error = slope_over_record(values)
    return abs(change) <= STUDENT_T * error, {"change": change, "standard_error": error}


def judge_energy(rows):
    shares = [energy_at_rest(row) / energy_pressed(row) if energy_pressed(row) > 0 else math.inf for row in rows]
    flat, figures = is_within_noise([energy_at_rest(row) for row in rows])
    # A change that is nothing beside the bound is none, however little noise there is.
    flat = flat or abs(figures["change"]) <= 0.01 * REST_ENERGY_SHARE * statistics.median(map(energy_pressed, rows))
    figures.update(worst_share=max(shares), bound=REST_ENERGY_SHARE, pressed_median_j=statistics.median(map(energy_pressed, rows)),
                   rest_median_j=statistics.median(map(energy_at_rest, rows)), rest_worst_j=max(map(energy_at_rest, rows)))
    return max(shares) <= REST_ENERGY_SHARE and flat, figures


def judge_drift(rows, deepest_m):
    worst_m = max(row["rest_largest_m"] for row in rows)
    good = worst_m <= OFFSET_SHARE * deepest_m
    figures = {"worst_m": worst_m, "worst_bound_m": OFFSET_SHARE * deepest_m, "change_bound_m": DRIFT_SHARE * deepest_m}
    for name in OFFSETS:
        flat, of_name = is_within_noise([row[name] for row in rows])
        of_name["flat"] = flat or abs(of_name["change"]) <= DRIFT_SHARE * deepest_m
        good = good and of_name["flat"]
        figures[name] = of_name
    return good, figures


def judge_clock(rows):
    off = max(abs(row["simulated_s"] - CYCLE_S * row["cycle"]) for row in rows)
    return off < TICK_S, {"worst_off_s": off, "bound_s": TICK_S}


def judge_memory(rows):
    settled = rows[len(rows) // 10:]
    growth = max(row["rss_bytes"] for row in settled) - settled[0]["rss_bytes"]
    return growth < MEMORY_GROWTH, {"settled_bytes": settled[0]["rss_bytes"], "growth_bytes": growth, "bound_bytes": MEMORY_GROWTH}


def judge(rows, deepest_m, is_sanitized=False):
    """The verdict: one entry a question, each with `good` and its figures; `flat` if all are good."""
    numbers = all(math.isfinite(value) for row in rows for value in row.values() if isinstance(value, float))
    whole = numbers and not any(row["broken"] or row["rest_inverted"] for row in rows)
    verdict = {"whole": {"good": whole, "inverted_pressed": sum(row["pressed_inverted"] > 0 for row in rows) if numbers else None},
               "enough": {"good": len(rows) >= FEWEST_CYCLES, "cycles": len(rows), "needed": FEWEST_CYCLES}}
    if verdict["whole"]["good"] and verdict["enough"]["good"]:
        for name, (good, figures) in {"energy": judge_energy(rows), "drift": judge_drift(rows, deepest_m), "clock": judge_clock(rows),
                                      "memory": judge_memory(rows)}.items():
            verdict[name] = {"good": good, **figures}
        if is_sanitized:
            del verdict["memory"]
    verdict["flat"] = all(part["good"] for part in verdict.values())
    return verdict


def compare_hashes(rows, others):
    """The first cycle whose state differs, or None; and how many were compared."""
    known = {row["cycle"]: row["hash"] for row in others}
    both = [row for row in rows if row["cycle"] in known]
    return next((int(row["cycle"]) for row in both if row["hash"] != known[row["cycle"]]), None), len(both)


def draw(rows, folder, title):
    """soak.svg and .png: energies, offsets from rest and memory over simulated time."""
    sys.path.insert(0, str(ROOT / "report"))
    from shared import chart_style  # noqa: E402  # matplotlib is slow to load
    import matplotlib.pyplot as plt
    hours = [row["simulated_s"] / 3600 for row in rows]
    with plt.rc_context(chart_style.STYLE):
        fig, axes = plt.subplots(3, 1, figsize=(8, 7.5), sharex=True, layout="constrained")
        lines = [(axes[0], "under the finger", chart_style.BETTER, [energy_pressed(row) for row in rows]),
                 (axes[0], "let go", chart_style.THAN, [energy_at_rest(row) for row in rows]),
                 (axes[1], "largest", chart_style.THAN, [1e9 * row["rest_largest_m"] for row in rows])]
        lines += [(axes[1], f"mean {name}", colour, [1e9 * row[f"rest_mean_{name}_m"] for row in rows])
                  for name, colour in zip("xyz", (chart_style.BETTER, chart_style.OTHERS, chart_style.SPREAD))]
        lines += [(axes[2], None, chart_style.BETTER, [row["rss_bytes"] / 2**20 for row in rows])]
        for ax, label, colour, values in lines:
            ax.plot(hours, values, color=colour, label=label, linewidth=0.6)
        axes[0].set_yscale("log")
        for ax, name in zip(axes, ("energy, J", "offset from rest, nm", "resident memory, MiB")):
            ax.set_ylabel(name)
            ax.grid(True)
        for ax in axes[:2]:
            ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1)
        axes[2].set_ylim(bottom=0)
        axes[2].set_xlabel("simulated time, hours")
        fig.suptitle(title)
        chart_style.save(fig, folder, "soak")


def body_source(program, source, vertices, folder):
    """SOURCE as palpate_soak takes it: what `palpate make` knows by name is made."""
    if source.startswith("cube:") or pathlib.Path(source).exists():
        return source
    if not source.isalpha():
        raise SoakError(f"SOURCE: expected a file, a name that `palpate make` knows or cube:N, found '{source}'", 2)
    path = folder / f"{source}.mesh"
    done = subprocess.run([program, "make", source, "-o", path, "--vertices", str(vertices)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SoakError(f"palpate make {source}: {done.stderr.strip()}", done.returncode if done.returncode in (2, 3) else 3)
    return str(path)


def run(options):
    folder, build = pathlib.Path(options.output), pathlib.Path(options.build).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    program = build / "bin" / "palpate_soak"
    if not program.exists():
        raise SoakError(f"{program} is not there: cmake --build {options.build} --target palpate_soak", 3)
    cycles = max(1, round(options.hours * 3600 / CYCLE_S))
    wish = {"source": body_source(build / "bin" / "palpate", options.source, options.vertices, folder), "model": options.model,
            "cycles": cycles, "wall_s": options.wall, "seed": options.seed, "depth_share": options.depth_share,
            "step_share": options.step_share}
    done = subprocess.run([program, json.dumps(wish), folder / "soak.csv"], stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode not in (0, 1):
        raise SoakError(f"palpate_soak ended with {done.returncode}", done.returncode if done.returncode in (2, 3) else 3)
    about = {"source": options.source, "model": options.model, "seed": options.seed, "cycles_wanted": cycles, **json.loads(done.stdout)}
    (folder / "body.json").write_text(json.dumps(about, indent=1) + "\n")


def flattened(part, before=""):
    """The figures of a part of the verdict, those of its own parts with their names in front."""
    for key, value in part.items():
        if isinstance(value, dict):
            yield from flattened(value, f"{before}{key} ")
        elif key not in ("good", "flat"):
            yield before + key, value


def show(about, rows, verdict):
    last = rows[-1]
    print(f"{about['source']}, {about['model']} ({about['engine']}): {about['vertices']} vertices, {about['tets']} tetrahedra, "
          f"{about['springs']} springs")
    print(f"{len(rows)} of {about['cycles_wanted']} cycles, {last['simulated_s'] / 3600:.3g} simulated hours, {last['steps']:.4g} steps of "
          f"{1e3 * about['step_s']:.3g} ms in {last['wall_s']:.0f} s")
    for name, part in verdict.items():
        if isinstance(part, dict):
            figures = [f"{key} {value:.3g}" for key, value in flattened(part) if isinstance(value, float | int) and not isinstance(value, bool)]
            print(f"{name:7} {'good' if part['good'] else 'NOT GOOD'}: {', '.join(figures)}")
    print("flat" if verdict["flat"] else "NOT FLAT")


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("build", nargs="?")
    parser.add_argument("source", nargs="?", default="kidney")
    parser.add_argument("-o", "--output", default="soak")
    parser.add_argument("--model", choices=("springs", "smoothed"), default="springs")
    parser.add_argument("--vertices", type=int, default=1500)
    parser.add_argument("--hours", type=float, default=24.0)
    parser.add_argument("--wall", type=float, default=1e9)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--depth-share", type=float, default=0.05, help="the deepest press over the body's longest side")
    parser.add_argument("--step-share", type=float, default=0.9, help="the longest step over the predicted bound")
    parser.add_argument("--against", help="soak.csv of another run of the same soak")
    parser.add_argument("--read", help="judge a folder anew")
    options = parser.parse_args(arguments)
    for name, low, high in (("hours", 1e-6, 1e5), ("wall", 1e-3, 1e9), ("depth_share", 1e-6, 0.2), ("step_share", 1e-3, 0.999), ("vertices", 10, 1e6), ("seed", 0, 2**63)):
        if not low <= getattr(options, name) <= high:
            parser.error(f"--{name.replace('_', '-')}: expected a number from {low:g} to {high:g}")
    if (options.build is None) == (options.read is None):
        parser.error("expected either BUILD or --read FOLDER")
    try:
        if options.read is None:
            run(options)
        folder = pathlib.Path(options.read or options.output)
        about = json.loads((folder / "body.json").read_text())
        rows = read_record(folder / "soak.csv")
        verdict = judge(rows, about["deepest_m"], about.get("sanitized", False))
        if options.against:
            differs, compared = compare_hashes(rows, read_record(options.against))
            verdict["same"] = {"good": differs is None and compared > 0, "cycles_compared": compared, "first_that_differs": differs}
            verdict["flat"] = verdict["flat"] and verdict["same"]["good"]
        (folder / "soak.json").write_text(json.dumps({"body": about, "verdict": verdict}, indent=1) + "\n")
        show(about, rows, verdict)
        if all(math.isfinite(value) for row in rows for value in row.values() if isinstance(value, float)):
            draw(rows, folder, f"{about['source']}, {about['model']}: {len(rows)} presses, {rows[-1]['simulated_s'] / 3600:.3g} simulated hours")
    except SoakError as error:
        print(f"soak: {error.args[0]}", file=sys.stderr)
        return error.args[1]
    except OSError as error:
        print(f"soak: {error}", file=sys.stderr)
        return 3
    return 0 if verdict["flat"] else 1


if __name__ == "__main__":
    sys.exit(main())

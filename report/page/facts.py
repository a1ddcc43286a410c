"""Where a run's figures come from, and the command that repeats them."""

import pathlib
import shlex

from page.markup import join, tag
from page.table_html import facts_html
from shared.run_file import BadRun, read_text

ROOT = pathlib.Path(__file__).resolve().parents[2]
PLANS = ROOT / "experiments" / "plans"
PROGRAM = "./palpate" if (ROOT / "palpate").is_file() else "palpate"  # as a reader would type it: in the sources, or installed
MOST_PLAN_BYTES = 60_000  # of the plan's text
MOST_PLAN_FILE_BYTES = 2**20  # as plans are read


def text_of(value):
    """A fact in words: a list with commas, a block as name value pairs."""
    if isinstance(value, dict):
        return ", ".join(f"{key} {text_of(each)}" for key, each in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(text_of(each) for each in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    return "" if value is None else str(value)


# What of a provenance is said, in words.
SAID = [("version", "Palpate"), ("commit", "Commit"), ("started_at", "Started (UTC)"), ("processor", "Processor"), ("processors", "Processors"),
        ("memory", "Memory"), ("system", "System"), ("load", "Load averages"), ("compiler", "Compiler"), ("flags", "Flags"), ("build_type", "Build"),
        ("libraries", "Libraries"), ("threads", "Threads"), ("repeats", "Repeats"), ("warmup", "Warm-up"), ("seeds", "Seeds"), ("order_seed", "Seed of the rounds"),
        ("timeout_s", "Time-out, s"), ("memory_mib", "Memory bound, MiB"), ("plan_hash", "Hash of the plan")]


def repeat_command(run):
    """The command that repeats a run: by the plan's name where it is one of ours, else by the file beside the page."""
    name = run.plan.removesuffix(".yaml")
    return f"{PROGRAM} run {shlex.quote(name)}" if "/" not in name and (PLANS / f"{name}.yaml").is_file() else f"{PROGRAM} run plan.yaml"


def chosen_words(chosen):
    """The words by which a run chose its cases: --only and --case, each as often as it was given."""
    if not isinstance(chosen, dict):
        return ""
    named = [(key, each) for key in ("only", "case") for each in (chosen.get(key) if isinstance(chosen.get(key), list) else [chosen.get(key)]) if isinstance(each, str)]
    return "".join(f" --{key} {shlex.quote(each)}" for key, each in named)


def case_command(run, case):
    return f"{repeat_command(run)} --case {shlex.quote(str(case))}"


def commit_text(provenance):
    commit = text_of(provenance.get("commit"))
    source = provenance.get("source")  # older runs do not say: theirs was a checkout
    if source == "unknown" or commit == "unknown":
        return "unknown: the sources were no checkout, nor an archive or a package that names its commit"
    said = {"archive": ", by the source archive; whether it was changed since, nobody can tell", "package": ", by the installed package"}.get(source, "")
    return f"{commit}{said}{', with changes that are not committed' if commit and provenance.get('dirty') else ''}"


def plan_html(run):
    """The plan as it was run, if its copy is there."""
    try:
        text = read_text(run.folder / "plan.yaml", MOST_PLAN_FILE_BYTES)
    except BadRun:
        return ""
    cut = text[:MOST_PLAN_BYTES]
    return tag("details", tag("summary", "The plan"), tag("pre", tag("code", cut + ("\n..." if len(text) > len(cut) else ""))))


def provenance_html(run):
    provenance = run.provenance
    said = [(title, commit_text(provenance) if key == "commit" else text_of(provenance.get(key))) for key, title in SAID]
    sittings = provenance.get("sittings")
    if isinstance(sittings, list) and len(sittings) > 1:
        said.append(("Sittings", f"{len(sittings)}: the run was taken up again"))
    chosen = sittings[-1].get("chosen") if isinstance(sittings, list) and sittings and isinstance(sittings[-1], dict) else None
    if chosen:
        said.append(("Cases", f"not all of the plan: {text_of(chosen)}"))
    records = sum(len(group.records) for group in run.groups) + len(run.inputs) + len(run.references)
    said.append(("Records", f"{records:,} in records.jsonl, which all of this was worked out from"))
    return join([tag("p", "The command that repeats it:"), tag("pre", tag("code", repeat_command(run) + chosen_words(chosen)), class_="command"), facts_html(said), plan_html(run)])

#!/usr/bin/env python3
"""Tables, charts, page and verdict of a run, from its folder alone.

    make_report.py RUN_DIR [--no-charts] [-o FILE] [--scripts DIR]

Writes RUN_DIR/tables/*.csv, RUN_DIR/charts/*.svg|png and the page RUN_DIR/report.html (or FILE), and prints a summary. DIR is where the
build left the page's scripts (else build/*/page). Exit codes: 0 done; 1 done, but a comparison, a
target or a claim that the plan marks `required: true` does not hold (the last lines say which); 2 the folder is no run folder, a
record is broken, or FILE is no place for a page; 3 matplotlib is missing, a file could not be written, or a fault of the report itself.
"""

import argparse
import gc
import pathlib
import sys
from dataclasses import dataclass

from deform import convergence, cost, counts, deform, deform_page, deform_tables, element_steps, frontier, standing, targets
from engine import engine, engine_page
from motion import motion, motion_page, stages
from page import write_page
from shared import equal_count, load, records, run_file, tables
from shared.exit_codes import guarded
from shared.terminal import say
from simplify import comparisons, contest, scaling, simplify_page, verdict
from stability import stability, stability_page
from verify import verification, verification_page


MOST_MESHES = 100  # whose lines the summary of a contest of simplifiers has


@dataclass
class Findings:
    verdicts: list  # of the claim, mesh by mesh
    sections: list  # of the contest, if the plan ranks answers at equal count
    comparisons: list
    scaling: list  # growth of each label with the mesh, if the plan asks for that chart


def print_summary(whole, claim, found):
    """What a reader can take in: of very many meshes the first ones, all are in the tables."""
    run = whole.of_first_meshes(MOST_MESHES)
    if run is not whole:
        whole.notes.append(f"the summary has the first {MOST_MESHES} of {len(whole.meshes()):,} meshes; tables/ has all")
    if run.plan_data.get("question"):
        say(f"{run.plan_data['question']}\n")
    if found.sections:
        meshes = set(run.meshes())
        say(contest.contest_text(run, [section for section in found.sections if section.mesh in meshes]))
    else:
        say("Quality: median over seeds [least, greatest]\n")
        say(tables.quality_summary(run))
        say(f"\n{tables.TIMING_TITLE}\n")
        say(tables.timing_summary(run))
    if found.scaling:
        say(f"\n{scaling.scaling_text(found.scaling)}")
    if found.comparisons:
        say(f"\n{comparisons.comparisons_text(run, found.comparisons, with_shortfalls=False)}")
    if claim:
        variants = verdict.variant_summary(run, claim)
        if variants:
            say(f"\n{claim.measure}: change against {claim.better}, largest first; only between answers whose tetrahedra are "
                f"within {100 * equal_count.tolerance_of(run):g}%\n")
            say(variants)
        say()
        say(verdict.verdict_text(claim, found.verdicts))


def refuse_links(folder):
    """Raises: BadRun where a folder that is written to, and emptied, is a link: a run that somebody else packed could name any place."""
    for name in ("tables", "charts"):
        if (folder / name).is_symlink():
            raise run_file.BadRun(f"{folder / name}: expected a folder of the run, found a link")


def remove_old(folder, names):
    """Takes away what an earlier report left and this one does not write."""
    for path in folder.glob("*"):
        if path.is_file() and path.name not in names:
            path.unlink()


def find(run, claim):
    """Everything that is worked out from the records, before anything is written."""
    return Findings(verdict.judge_run(run, claim) if claim else [],
                    contest.read_sections(run) if "equal_count" in run.plan_data else [], comparisons.compare_all(run),
                    scaling.read_series(run) if "scaling" in (run.plan_data.get("charts") or []) else [])


def write_tables(run, claim, found):
    """Writes all tables; takes away those of a former report."""
    folder = run.folder / "tables"
    names = {path.name for path in tables.write_tables(run, folder)}
    if claim:
        verdict.write_verdict(claim, found.verdicts, folder)
        names |= {"verdict.csv", "verdict.txt"}
        if verdict.write_variants(run, claim, folder):
            names.add("variants.csv")
    if found.sections:
        names |= contest.write_contest(run, found.sections, folder)
    if found.comparisons:
        names |= comparisons.write_comparisons(run, found.comparisons, folder)
    if found.scaling:
        names |= scaling.write_scaling(found.scaling, folder)
    remove_old(folder, names)


def report_displacements(run):
    """Tables and summary of a contest of displacements; returns what its charts are drawn from, and what is required and missed."""
    sections = deform.read_sections(run)
    series = convergence.read_series(sections)
    outcomes = targets.judge_targets(run, sections)
    costs = cost.cost_rows(run, sections)
    folder = run.folder / "tables"
    points = frontier.read_points(run) if frontier.asked(run) else {}
    equals = frontier.equal_error_rows(run, points) if points else []
    standings = standing.read_standings(run, points) if points else []
    steps = element_steps.read_rows(run, points) if points else []
    names = deform_tables.write_tables(run, sections, folder)
    names |= frontier.write_frontier(points, equals, folder) | standing.write_standings(standings, folder) if points else set()
    names |= element_steps.write_rows(steps, folder) if steps else set()
    names |= cost.write_cost(costs, folder) if costs else set()
    names |= convergence.write_convergence(series, folder) if series else set()
    curves = counts.read_curves(run, sections)
    names |= counts.write_counts(curves, folder) | counts.write_gradings(curves, folder) if curves else set()
    names |= targets.write_targets(outcomes, folder) if outcomes else set()
    remove_old(folder, names)
    if run.plan_data.get("question"):
        say(f"{run.plan_data['question']}\n")
    # With a frontier its points are many: the tables have them one by one.
    say(frontier.frontier_text(run, points, equals) if points else deform_tables.summary_text(run, sections))
    if steps:
        say(f"\n{element_steps.rows_text(run, steps)}")
    if standings:
        say(f"\n{standing.standing_text(standings)}")
    if costs and not points:
        say(f"\n{cost.cost_text(costs, run.plan_data.get('beside'))}")
    if series:
        say(f"\n{convergence.convergence_text(series)}")
    if outcomes:
        say(f"\n{targets.targets_text(outcomes)}")
    return (sections, series, points), list(targets.failed_requirements(outcomes))


def draw_displacements(run, found):
    from deform import deform_charts  # needs matplotlib
    return deform_charts.draw_charts(run, *found, run.folder / "charts")


def report_cases(read, write, text):
    """A report that reads what it is about, writes its tables and prints its summary; it returns what it read. Its plans require
    nothing."""
    def report(run):
        found = read(run)
        remove_old(run.folder / "tables", write(found, run.folder / "tables"))
        if run.plan_data.get("question"):
            say(f"{run.plan_data['question']}\n")
        say(text(found) if found else "no records")
        return found, []
    return report


def draw_known_answers(run, rows):
    from verify import verification_charts  # needs matplotlib
    return verification_charts.draw_charts(rows, run.folder / "charts")


def draw_extremes(run, cases):
    from stability import stability_charts  # needs matplotlib
    return stability_charts.draw_charts(cases, run.folder / "charts")


def draw_motions(run, sections):
    from motion import motion_charts  # needs matplotlib
    return motion_charts.draw_charts(run, sections, run.folder / "charts")


def draw_simplifiers(run, found):
    from simplify import charts  # needs matplotlib
    return charts.draw_charts(run, found[0], run.folder / "charts")


def report_motions(run):
    """Tables and summary of a contest of motions; where meshes were simplified, also what each stage costs and adds."""
    found = motion.read_sections(run)
    staged = stages.read_stages(run)
    names = motion.write_tables(found, run.folder / "tables")
    names |= stages.write_stages(staged, run.folder / "tables") if staged else set()
    remove_old(run.folder / "tables", names)
    if run.plan_data.get("question"):
        say(f"{run.plan_data['question']}\n")
    say(motion.table_text(found) if found else "no records")
    if staged:
        say(f"\n{stages.stages_text(staged)}")
    return found, []


def report_simplifiers(run):
    """Tables and summary of a contest of simplifiers; returns its claim and what it found, and what is required and does not hold."""
    claim = verdict.read_claim(run.plan_data)
    equal_count.add_count_notes(run, claim)
    found = find(run, claim)
    write_tables(run, claim, found)
    print_summary(run, claim, found)
    failed = [*comparisons.failed_requirements(run, found.comparisons), *verdict.failed_requirements(claim, found.verdicts)]
    return (claim, found), failed


def draw_engine(run, found):
    from engine import engine_charts  # needs matplotlib
    return engine_charts.draw_charts(run, found, run.folder / "charts")


@dataclass(frozen=True)
class ContestReport:
    """What a contest's room does: `tables` writes and prints them and returns (found, failed requirements), `draw` draws the charts, and
    `page` says what the page has, both from what was found."""

    tables: object
    draw: object
    page: object


def choose_report(run):
    """The report of this contest."""
    of_contest = {
        "engine": ContestReport(report_cases(engine.read_cases, engine.write_tables, engine.engine_text), draw_engine, engine_page.page_parts),
        "motion": ContestReport(report_motions, draw_motions, motion_page.page_parts),
        "stability": ContestReport(report_cases(stability.read_cases, stability.write_tables, stability.summary_text), draw_extremes,
                                   stability_page.page_parts),
        "verify": ContestReport(report_cases(verification.read_rows, verification.write_tables, verification.verification_text), draw_known_answers,
                                verification_page.page_parts),
    }.get(run.plan_data.get("contest"))
    if of_contest is not None:
        return of_contest
    if run.judges_displacements:
        return ContestReport(report_displacements, draw_displacements, deform_page.page_parts)
    return ContestReport(report_simplifiers, draw_simplifiers, lambda run, found: simplify_page.page_parts(run, *found))


def print_notes(notes):
    for note in notes:
        say(f"\nnote: {note}")


def read_without_collecting(folder):
    """The run. Its records have no circles for the collector to find, and are too many to be looked through again and again."""
    gc.disable()
    try:
        return records.read_run(folder)
    finally:
        gc.enable()
        gc.freeze()


def make_report(options):
    """Does all of it; returns the exit code. What is required and does not hold is said last."""
    named = write_page.output_place(options.output) if options.output else None
    run = read_without_collecting(options.run_dir)
    refuse_links(run.folder)
    page = named or run.folder / "report.html"
    write_page.require_place(page)
    contest_report = choose_report(run)
    found, failed = contest_report.tables(run)
    run.notes += load.run_notes(run)
    said = len(run.notes)
    print_notes(run.notes)
    if not options.no_charts:
        try:
            drawn = contest_report.draw(run, found)
        except ImportError as error:
            print(f"report: no charts: {error} (packages.txt: python3-matplotlib)", file=sys.stderr)
            return 3
        remove_old(run.folder / "charts", set(drawn))
        print_notes(run.notes[said:])
        said = len(run.notes)
        if not drawn:
            say("\nnote: no accepted answers: no charts")
    write_page.write_page(run, contest_report.page(run, found), page, options.scripts, failed)
    print_notes(run.notes[said:])
    for what in failed:
        say(f"\nrequired, and does not hold: {what}")
    return 1 if failed else 0


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="make_report.py", description="Tables, charts and verdict of a run.")
    parser.add_argument("run_dir", metavar="RUN_DIR")
    parser.add_argument("--no-charts", action="store_true", help="tables, summary and page only")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="FILE", help="the page, instead of RUN_DIR/report.html")
    parser.add_argument("--scripts", metavar="DIR", help="where the build left the page's scripts")
    options = parser.parse_args(arguments)
    return guarded(lambda: make_report(options), name="report: ")


if __name__ == "__main__":
    sys.exit(main())

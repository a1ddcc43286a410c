"""One HTML file of a run: question, verdict, what was not accepted, charts, tables, bodies in 3D, provenance. It opens offline, asks no
network for anything (its own policy forbids it), and the same run gives the same bytes.
"""

import os
import pathlib

from page import facts
from page.chart_html import MOST_POINTS, chart_html, drawn_html
from page.markup import Markup, join, json_block, script_text, tag, void
from page.table_html import rows_within, table_html
from shared.page_parts import Chart, Column, Note, Section, Table
from shared.run_file import BadRun, open_file
from shared.tables import first_reason, write_atomically
from shared.whole_file import has_file

HERE = pathlib.Path(__file__).resolve().parent
DOCTYPE = b"<!doctype html"
MOST_CELLS = 24_000  # of all tables together
MOST_ROWS = 12_000  # of all charts together
FEWEST_ROWS = 50  # of a chart where the page is full
MOST_PICTURE_BYTES = 1_100_000  # of all pictures of charts together
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'"


class Scripts:
    """The script bundle that the build left, or why there is none."""

    def __init__(self, folder):
        self.script = self.style = ""
        self.missing = ""
        folders = [pathlib.Path(folder)] if folder else sorted((HERE.parents[1] / "build").glob("*/page"))
        found = [each for each in folders if (each / "built.txt").is_file()]
        if not found:
            self.missing = ("This page has no scripts: the build found no node, or could not get the packages of page/package-lock.json. Charts are pictures, "
                            "tables do not sort, and there is no 3D.")
            return
        # The release build's, where it is not said whose.
        chosen = next((each for each in found if each.parent.name == "release"), found[0])
        self.script = (chosen / "report.js").read_text(encoding="utf-8")
        self.style = (chosen / "report.css").read_text(encoding="utf-8")


class Pictures:
    """The charts of a run as pictures; each is given once, as long as there is room."""

    def __init__(self, folder):
        self.folder = folder
        self.room = MOST_PICTURE_BYTES
        self.left = []
        self.stems = sorted({path.stem for path in folder.glob("*") if path.suffix in (".svg", ".png")}) if folder and folder.is_dir() else []
        self.taken = set()

    def endings(self, stem):
        return [ending for ending in ("svg", "png") if stem and self.folder and (self.folder / f"{stem}.{ending}").is_file()]

    def take(self, stem):
        """The PNG, or None without one or without room."""
        path = self.folder / f"{stem}.png"
        self.taken.add(stem)
        if not stem or not path.is_file():
            return None
        content = path.read_bytes()
        if len(content) * 4 / 3 > self.room:
            self.left.append(stem)
            return None
        self.room -= len(content) * 4 / 3
        return content


def not_accepted_table(run):
    """Every group with an answer that was not accepted, how it ended, and why."""
    rows = []
    for group in run.groups:
        bad = {outcome: count for outcome, count in group.outcomes().items() if outcome != "accepted"}
        if bad:
            rows.append([group.mesh, group.label, group.sweep, ", ".join(f"{count} {outcome}" for outcome, count in bad.items()),
                         sum(group.outcomes().values()), first_reason(group) or ""])
    return Table("What was not accepted, and why", [Column("on"), Column("label"), Column("at"), Column("ended"), Column("of"), Column("why")], rows)


def not_accepted_html(run, room):
    counts = [group.outcomes() for group in run.groups]
    total, accepted = (sum(sum(each.values()) for each in counts), sum(each.get("accepted", 0) for each in counts))
    table = not_accepted_table(run)
    if not table.rows:
        return tag("p", f"All {total:,} answers were accepted by the judge." if total else "There are no answers."), 0
    shown = rows_within(table, room)
    was = "was" if total - accepted == 1 else "were"
    return (join([tag("p", f"{total - accepted:,} of {total:,} answers {was} not accepted. None of them counts in a figure or a time."), table_html(table, "not-accepted-table", shown)]),
            shown * len(table.columns))


class PageWriter:
    """Puts a page together; keeps what there is room for."""

    def __init__(self, run, parts, scripts, pictures):
        self.run, self.parts, self.scripts, self.pictures = run, parts, scripts, pictures
        self.cells, self.rows = MOST_CELLS, MOST_ROWS
        self.number = 0
        self.shown_cases = []  # whose bodies are in 3D

    def name(self, kind):
        self.number += 1
        return f"{kind}-{self.number}"

    def part_html(self, part):
        if isinstance(part, Chart):
            picture = self.pictures.take(part.drawn) if part.drawn else None
            most = min(MOST_POINTS, max(FEWEST_ROWS, self.rows))
            self.rows -= min(most, len(part.rows))
            return chart_html(part, self.name("chart"), picture, self.pictures.endings(part.drawn), bool(self.scripts.script), most)
        if isinstance(part, Table):
            rows = rows_within(part, self.cells)
            self.cells -= rows * len(part.columns)
            return table_html(part, self.name("table"), rows)
        return tag("p", part.text) if isinstance(part, Note) else ""

    def section_html(self, section, kind):
        parts = [part for part in section.parts if isinstance(part, kind)]
        if not parts:
            return ""
        shown = [self.part_html(part) for part in parts]
        heading = tag("h3", section.title) if section.title else ""
        if Chart in kind:
            return join([heading, tag("div", *shown, class_="charts")])
        return join([heading, *shown])

    def charts_html(self):
        found = [self.section_html(section, (Chart,)) for section in self.parts.sections]
        others = []
        for stem in self.pictures.stems:
            if stem in self.pictures.taken:
                continue
            picture = self.pictures.take(stem)
            if picture:
                others.append(drawn_html(stem, self.name("chart"), picture, self.pictures.endings(stem)))
        if others:
            found.append(tag("details", tag("summary", f"As drawn for print ({len(others)})"), tag("div", *others, class_="charts"), open=not any(found)))
        if self.pictures.left:
            found.append(tag("p", f"Not shown here, so that the page stays small; they are in charts/: {', '.join(self.pictures.left)}.", class_="note"))
        return join(found) or tag("p", "There is nothing to draw: no accepted answers.")

    def tables_html(self):
        return join([self.section_html(section, (Table, Note)) for section in self.parts.sections]) or tag("p", "There are no tables.")

    def bodies_html(self):
        """The bodies in 3D, or why there are none."""
        if self.parts.bodies is None:
            return tag("p", "This contest keeps no meshes.")
        try:
            from page.bodies_json import choose_bodies  # needs numpy
        except ImportError as error:
            return tag("p", f"No 3D: {error} (packages.txt: python3-matplotlib brings it).")
        chosen = choose_bodies(self.parts.bodies())
        notes = [tag("p", chosen.note, class_="note")] if chosen.note else []
        if not chosen.bodies:
            return join([tag("p", "The run's folder has no meshes to show."), *notes])
        if not self.scripts.script:
            return tag("p", f"{len(chosen.bodies)} meshes could be shown here in 3D; this page was written without its scripts. They are in the run's folder.")
        groups = list(dict.fromkeys(body["group"] for body in chosen.bodies))
        self.shown_cases = [body["case"] for body in chosen.bodies if "case" in body]
        return join([tag("div", tag("p", f"{len(chosen.bodies)} meshes in 3D take JavaScript and WebGL: {'; '.join(groups)}."), id="bodies", data_bodies="bodies-data"), *notes,
                     json_block("bodies-data", {"meshes": chosen.meshes, "bodies": chosen.bodies})])


def page_html(run, parts, scripts, failed=()):
    """The whole page as text."""
    writer = PageWriter(run, parts, scripts, Pictures(run.folder / "charts"))
    question = str(run.plan_data.get("question") or f"The run of {run.plan}")
    refused, cells = not_accepted_html(run, writer.cells)
    writer.cells -= cells
    chapters = [("verdict", "Verdict", verdict_html(run, parts, failed)), ("not-accepted", "What was not accepted", refused),
                ("charts", "Charts", writer.charts_html()), ("tables", "Tables", writer.tables_html()), ("organs", "In 3D", writer.bodies_html()),
                ("provenance", "Provenance", facts.provenance_html(run))]
    warning = tag("p", scripts.missing, class_="warning") if scripts.missing else ""
    return document(f"plan {run.plan}", question, chapters, warning, scripts, facts.repeat_command(run), writer.shown_cases)


def verdict_html(run, parts, failed):
    more = [tag("p", f"Required, and does not hold: {what}.") for what in failed]
    notes = [tag("p", note[:1].upper() + note[1:] + ("" if note.endswith((".", "!", "?")) else "."), class_="warning") for note in run.notes]
    return join([tag("div", tag("p", parts.verdict), *more, class_=f"verdict {parts.state}"), *notes])


def document(kind, question, chapters, warning, scripts, command, shown_cases=()):
    base = (HERE / "page.css").read_text(encoding="utf-8")
    head = [void("meta", charset="utf-8"), void("meta", name="viewport", content="width=device-width, initial-scale=1"),
            void("meta", http_equiv="Content-Security-Policy", content=POLICY), void("meta", name="color-scheme", content="light dark"),
            tag("title", f"{question} - {kind}"), tag("style", Markup(base)), tag("style", Markup(scripts.style)) if scripts.style else ""]
    links = [tag("a", title, href=f"#{place}") for place, title, _ in chapters]
    body = [tag("a", "To the verdict", href="#verdict", class_="skip"), tag("header", tag("p", f"Palpate, {kind}", class_="kind"), tag("h1", question), warning),
            tag("nav", tag("div", *links, id="tools"), aria_label="Parts of the page"),
            tag("main", *(tag("section", tag("h2", title), content, id=place) for place, title, content in chapters)),
            tag("footer", "Written by palpate report from the files of runs alone. docs/report_page.md says how to read it."),
            json_block("run-data", {"plan": kind, "command": command, "shown_cases": list(shown_cases)}) if scripts.script else "",
            tag("script", script_text(scripts.script)) if scripts.script else ""]
    return "<!doctype html>\n" + tag("html", tag("head", *head), "\n", tag("body", *(join([part, "\n"]) for part in body)), lang="en") + "\n"


def write_page(run, parts, path, scripts_folder=None, failed=()):
    """Writes the page."""
    write_new_page(path, page_html(run, parts, Scripts(scripts_folder), failed))


def output_place(path):
    """Where the page goes that a user names: what a link leads to is written, the link stays. Raises: BadRun, before any work is done, unless a
    page can be written there."""
    place = pathlib.Path(os.path.realpath(path))
    require_place(place)
    return place


def require_place(path):
    """Raises: BadRun unless a page can be written there, in the place of nothing or of an earlier page: records or a plan that a name stands for
    by mistake stay what they are."""
    if not path.parent.is_dir():
        raise BadRun(f"{path}: expected a file in a folder that exists, found no folder {path.parent}")
    if not os.access(path.parent, os.W_OK):
        raise BadRun(f"{path}: expected a file in a folder that can be written, found {path.parent}")
    if has_file(path):
        with open_file(path) as file:
            start = file.read(len(DOCTYPE))
        if start and start != DOCTYPE:
            raise BadRun(f"{path}: expected a new file or an earlier page, found a file that is no page")


def write_new_page(path, text):
    require_place(path)
    write_atomically(path, text)


def write_parts(parts, question, path, scripts_folder=None):
    """Writes a page of parts that belong to no single run: verdict, charts and tables."""
    scripts = Scripts(scripts_folder)
    writer = PageWriter(None, parts, scripts, Pictures(None))
    verdict = tag("div", tag("p", parts.verdict), class_=f"verdict {parts.state}")
    chapters = [("verdict", "Verdict", verdict), ("charts", "Charts", writer.charts_html()), ("tables", "Tables", writer.tables_html())]
    warning = tag("p", scripts.missing, class_="warning") if scripts.missing else ""
    write_new_page(path, document("runs compared", question, chapters, warning, scripts, f"{facts.PROGRAM} run PLAN"))

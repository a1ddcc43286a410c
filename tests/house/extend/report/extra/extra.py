"""The table of the contest extra."""

from shared.page_parts import Column, PageParts, Section, Table
from shared.records import figure
from shared.tables import align, write_csv


def read_rows(run):
    return [[group.label, f"{figure(record, 'judge', 'tets'):.0f}"] for group in run.groups for record in group.judged()[:1]]


def write_tables(rows, folder):
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(folder / "extra.csv", ["label", "tets"], rows)
    return {"extra.csv"}


def table_text(rows):
    return "extra contest\n" + align(["label", "tets"], rows)


def page_parts(run, rows):
    return PageParts(f"The extra contest has {len(rows)} answer{'s' if len(rows) != 1 else ''}.", sections=[
        Section("", [Table("Tetrahedra", [Column("label"), Column("tetrahedra")], rows, file="tables/extra.csv")])])

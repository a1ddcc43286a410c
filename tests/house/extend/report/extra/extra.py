"""The table of the contest extra."""

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

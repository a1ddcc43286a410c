"""What a contest with known answers has for the page of its run."""

from shared.page_parts import BAD, GOOD, Axis, Chart, Column, PageParts, Section, Table
from verify.verification import BROKEN, KEPT


def verdict_of(rows):
    states = [row.state for row in rows]
    kept, broken = states.count(KEPT), states.count(BROKEN)
    methods = len({row.label for row in rows})
    text = f"Of {kept + broken} bounds on known answers {kept} are kept and {broken} are not, by {methods} method{'s' if methods > 1 else ''}"
    worst = [row for row in rows if row.state == BROKEN]
    return text + (f"; the first that is not: {worst[0].case} by {worst[0].label}." if worst else "."), BAD if worst else GOOD


def error_chart(rows):
    points = [{"case": None, "problem": row.case, "label": row.label, "cells": row.cells, "error": row.values["solution_l2"], "order": row.values["solution_order"],
               "worst": row.values["solution_max"], "note": "; ".join(text for text in (row.bounds, row.note) if text)}
              for row in rows if row.values["solution_l2"] and row.cells]
    if not points:
        return None
    return Chart("Error against the known answer", "lines", Axis("cells", "cells along the longest side", "", True), Axis("error", "relative error, L2", "", True), points,
                 series="label", facet="problem", shown=[Axis("order", "order"), Axis("worst", "error at the worst vertex")],
                 note="A panel a problem; finer meshes to the right. Errors near rounding stay where they are.")


def value_chart(rows):
    points = [{"problem": row.case, "label": row.label, "name": f"{row.label}, {row.cells:g} cells", "off": row.values["value_error"], "value": row.values["value"],
               "known": row.values["value_known"], "note": row.bounds} for row in rows if row.values["value_error"]]
    if not points:
        return None
    return Chart("Single figures against what is known", "ranges", Axis("off", "off by", "%", True, 100.0), Axis("name", "method"), points, series="label", facet="problem",
                 shown=[Axis("value", "found"), Axis("known", "known")])


def page_parts(run, rows):
    columns = [Column("case"), Column("method"), Column("cells"), Column("error, L2", digits=3), Column("error, worst vertex", digits=3), Column("order", digits=3), Column("value", digits=5),
               Column("known", digits=5), Column("off by", "%", 3), Column("kernel", "ms"), Column("bounds"), Column("kept"), Column("note")]
    scaled = lambda value, factor: None if value is None else factor * value
    table = Table("Known answers", columns,
                  [[row.case, row.label, row.cells, row.values["solution_l2"], row.values["solution_max"], row.values["solution_order"], row.values["value"],
                    row.values["value_known"], scaled(row.values["value_error"], 100.0), scaled(row.seconds, 1000.0), row.bounds, row.state, row.note] for row in rows],
                  note="Relative errors; order: against the next coarser mesh. Bounds hold on the finest mesh.", file="tables/verification.csv")
    sentence, state = verdict_of(rows)
    return PageParts(sentence, state, [Section("", [chart for chart in (error_chart(rows), value_chart(rows)) if chart]), Section("", [table])])

"""A chart as a figure: the picture that the run's charts/ have of it, and the data from which the script makes one that answers."""

from page.markup import data_uri, json_block, join, tag, void

MOST_POINTS = 4000  # of a chart


def axis_data(axis):
    return {"key": axis.key, "title": axis.title, "unit": axis.unit, "log": axis.is_log, "factor": axis.factor}


def keys_of(chart):
    """The keys of a row that the script reads."""
    axes = [chart.x, chart.y, *chart.shown]
    keys = [axis.key for axis in axes] + [f"{axis.key}_{end}" for axis in axes for end in ("low", "high", "to")]
    return [*keys, *(key for key in (chart.series, chart.facet) if key), "hollow", "note", "case", "name"]


def chart_data(chart, most=MOST_POINTS):
    """What the script needs, column by column; columns without anything in them are left out."""
    rows = chart.rows[:most]
    columns = {}
    for key in dict.fromkeys(keys_of(chart)):
        values = [row.get(key) for row in rows]
        if any(value is not None and value is not False and value != "" for value in values):
            columns[key] = values
    return {"kind": chart.kind, "title": chart.title, "x": axis_data(chart.x), "y": axis_data(chart.y), "series": chart.series,
            "facet": chart.facet, "shown": [axis_data(axis) for axis in chart.shown], "marks": chart.marks, "rows": len(rows), "columns": columns}


def links_html(name, endings):
    return tag("p", "For a paper: ", join([tag("a", f"{name}.{ending}", href=f"charts/{name}.{ending}") for ending in endings], ", "), " beside this page.",
               class_="files") if endings else ""


def picture_html(content, title):
    return void("img", src=data_uri("image/png", content), alt=title, class_="drawn")


def chart_html(chart, name, picture, endings, with_scripts, most=MOST_POINTS):
    """A figure of at most so many rows. `picture` is the PNG of the same chart, or None; with scripts it is for readers without them."""
    notes = [chart.note, f"The first {most:,} of {len(chart.rows):,} points." if len(chart.rows) > most else ""]
    note = " ".join(text for text in notes if text)
    shown = picture_html(picture, chart.title) if picture else ""
    if with_scripts:
        shown = join([tag("noscript", shown or tag("p", "This chart takes JavaScript; its figures are in the tables below."))])
    return tag("figure", tag("figcaption", tag("strong", chart.title), tag("span", note, class_="note") if note else ""),
               tag("div", shown, class_="plot", data_chart=f"{name}-data" if with_scripts else None), links_html(chart.drawn, endings),
               json_block(f"{name}-data", chart_data(chart, most)) if with_scripts else "", class_="chart", id=name)


def drawn_html(stem, name, picture, endings):
    """A chart that is there as a picture alone."""
    title = stem.replace("_", " ")
    return tag("figure", tag("figcaption", tag("strong", title)), tag("div", picture_html(picture, title), class_="plot"), links_html(stem, endings),
               class_="chart drawn-alone", id=name)

"""Tables as HTML: a caption, heads with units, numbers to the right; what the script sorts and filters by stands in data-value."""

import math

from page.markup import Markup, escape, join, tag
from shared.run_file import is_number

MOST_ROWS = 400  # of a table; the rest is in its file
FEWEST_ROWS = 20  # of a table where the page is full
LONG_TEXT = 40  # letters: from here on a cell is broad, so that its row does not become high


def number_text(value, digits):
    """To `digits` digits; very large and very small ones with a power of ten."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int) or float(value).is_integer() and abs(value) < 1e15:
        return f"{int(value):,}"
    size = abs(value)
    if size >= 10 ** max(7, digits) or size < 1e-4:
        return f"{value:.{digits - 1}e}"
    return f"{float(f'{value:.{digits}g}'):,.15g}"


def cell(value, column, is_first):
    if is_number(value):
        return tag("td", number_text(value, column.digits), class_="number", data_value=repr(value))
    text = "" if value is None or (isinstance(value, float) and not math.isfinite(value)) else "yes" if value is True else "no" if value is False else value
    long = "long" if len(str(text)) > LONG_TEXT else None
    return tag("th", text, scope="row", class_=long) if is_first else tag("td", text, class_=long)


def rows_within(table, cells):
    """How many of the rows are shown where there is room for `cells` more cells."""
    return min(len(table.rows), MOST_ROWS, max(FEWEST_ROWS, cells // max(1, len(table.columns))))


def has_numbers(rows, place):
    """Whether a column's cells that say something are numbers."""
    said = [row[place] for row in rows if row[place] not in (None, "") and row[place] == row[place]]
    return bool(said) and all(is_number(value) for value in said)


def table_html(table, name, most_rows=MOST_ROWS):
    """A table with its title, its note, and what was left out."""
    rows = table.rows[:most_rows]
    left = len(table.rows) - len(rows)
    heads = [tag("th", column.title, tag("span", f" {column.unit}", class_="unit") if column.unit else "", scope="col",
                 class_="number" if has_numbers(rows, place) else None) for place, column in enumerate(table.columns)]
    body = [tag("tr", *(cell(value, column, place == 0) for place, (value, column) in enumerate(zip(row, table.columns)))) for row in rows]
    notes = [table.note if table.note.endswith((".", "!", "?")) else f"{table.note}."] if table.note else []
    if left > 0:
        where = f"; all are in {table.file}" if table.file else ""
        notes.append(f"The first {len(rows):,} of {len(table.rows):,} rows{where}.")
    elif table.file:
        notes.append(f"Also in {table.file}.")
    return tag("div",
               tag("div", tag("table", tag("caption", table.title), tag("thead", tag("tr", *heads)), tag("tbody", join(body, "\n"))), class_="table-scroll",
                   tabindex="0", role="region", aria_label=table.title),
               tag("p", " ".join(notes), class_="note") if notes else "", class_="table", id=name)


def facts_html(facts):
    """A list of facts: (name, text)."""
    return tag("dl", *(Markup(tag("dt", name) + tag("dd", escape(text))) for name, text in facts if text not in (None, "")), class_="facts")

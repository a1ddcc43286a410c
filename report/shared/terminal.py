"""Text for a terminal: tables that are wider than it are folded, prose is wrapped. Files always have the whole width.

A table is what `tables.align` and `pad_columns` write: a header, a ruler of dashes, rows whose cells stand below the ruler's parts, and
behind the ruler perhaps one more column (notes). One that is too wide becomes blocks of columns, one below the other, each with the row
names again; where the names alone take more than half of the width, each row becomes a record of "column value" pairs.
"""

import re
import shutil
import textwrap

RULER = re.compile(r"-+(  -+)+$")
LEAST = 40  # columns: no terminal is taken as narrower
LEAST_NOTE = 24  # columns that a column of words is worth having
INDENT = "    "
DIGITS = "0123456789+-"
MOST_NAMES = 5  # columns


def width():
    """Columns of standard output: the environment's COLUMNS, else the terminal's, else 80."""
    return max(LEAST, shutil.get_terminal_size((80, 24)).columns)


def say(text=""):
    """Prints text, folded to the terminal."""
    print(fold(text, width()))


def fold(text, most):
    """The text in lines of at most `most` characters, as far as its words allow."""
    lines, out, place = text.split("\n"), [], 0
    while place < len(lines):
        if place + 1 < len(lines) and RULER.match(lines[place + 1]):
            end = end_of_table(lines, place)
            out += fold_table(lines[place:end], most)
            place = end
        else:
            out += wrap(lines[place], most)
            place += 1
    return "\n".join(out)


def wrap(line, most):
    if len(line) <= most:
        return [line]
    indent = line[:len(line) - len(line.lstrip())]
    return textwrap.wrap(line, most, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False) or [line]


def spans_of(lines):
    """Where each column starts and ends; the last one may go on to the end of the line."""
    ruler = lines[1]
    spans = [match.span() for match in re.finditer("-+", ruler)]
    if any(is_row(line, spans) and len(line) > len(ruler) for line in [lines[0], *lines[2:]]):
        spans.append((len(ruler) + 2, max(map(len, lines))))
    return spans


def is_row(line, spans):
    """Whether nothing stands between the columns, and something in at least two places or below the first."""
    gaps = [line[end:start] for (_, end), (start, _) in zip(spans, spans[1:])]
    gaps.append(line[spans[-1][1]:spans[-1][1] + 2])
    return bool(line.strip()) and not any(gap.strip() for gap in gaps)


def end_of_table(lines, start):
    """The line behind the table's last row. Lines between rows that are no rows (titles, blank ones) belong to it."""
    spans = [match.span() for match in re.finditer("-+", lines[start + 1])]
    end = start + 2
    for place in range(start + 2, len(lines)):
        if RULER.match(lines[place]):
            return min(end, place - 1)
        if is_row(lines[place], spans) and len(cells_of(lines[place], spans)) > 1:
            end = place + 1
    return end


def cells_of(line, spans):
    """What of the columns has something in it."""
    return [line[start:end] for start, end in [*spans, (spans[-1][1], len(line))] if line[start:end].strip()]


def fold_table(lines, most):
    if max(map(len, lines)) <= most:
        return lines
    spans = spans_of(lines)
    names = count_names(lines, spans, most)
    out, rows = [], []
    for line in lines[2:]:
        if is_row(line, spans) and (rows or len(cells_of(line, spans)) > 1):  # a short title lies below the first column alone
            rows.append(line)
            continue
        out += fold_rows(lines, rows, spans, names, most)
        out += wrap(line, most)
        rows = []
    return out + fold_rows(lines, rows, spans, names, most)


def count_names(lines, spans, most):
    """How many of the first columns name the row: those of words, two at most; and as many more as tell the rows apart, where there is room."""
    rows = [line for line in lines[2:] if is_row(line, spans)]
    count = 0
    for start, end in spans[:min(2, len(spans) - 1)]:
        if any(line[start:end].strip()[:1] in DIGITS for line in rows if line[start:end].strip()):
            break
        count += 1
    count = max(1, count)
    for more in range(count, min(MOST_NAMES, len(spans) - 1) + 1):
        if spans[more - 1][1] <= most // 2 and len({line[:spans[more - 1][1]] for line in rows}) == len(rows):
            return more
    return count


def fold_rows(lines, rows, spans, names, most):
    """Header, ruler and these rows, in as many blocks as it takes; a column that has nothing in them is left out."""
    if not rows:
        return []
    head = spans[names - 1][1]
    if head > most // 2:
        return [line for row in rows for line in record_of(lines[0], row, spans, names, most)]
    filled = spans[:names] + [span for span in spans[names:] if any(row[span[0]:span[1]].strip() for row in rows)]
    blocks = blocks_of(filled, names, head, most)
    out = []
    for number, block in enumerate(blocks):
        if number:
            out.append("")
        for line in [lines[0], lines[1], *rows]:
            out += block_line(line, head, block, most)
    return out


def blocks_of(spans, names, head, most):
    """Columns that stand beside the names together. One that is wider than the room has a block of its own."""
    blocks, used = [[]], head
    for start, end in spans[names:]:
        if blocks[-1] and used + 2 + min(end - start, most) > most:
            is_last = (start, end) == spans[-1]
            if not (is_last and most - used - 2 >= LEAST_NOTE):  # the last is wrapped where there is room
                blocks.append([])
                used = head
        blocks[-1].append((start, end))
        used += 2 + end - start
    return blocks


def block_line(line, head, block, most):
    """One line of a block; a last cell of words is wrapped below itself."""
    if not block:
        return [line[:head].rstrip()]
    text = line[:head].ljust(head)
    for start, end in block[:-1]:
        text += "  " + line[start:end].ljust(end - start)
    room = most - len(text) - 2
    cell = line[block[-1][0]:block[-1][1]].rstrip()
    if len(cell) <= room:
        return [(text + "  " + cell).rstrip()]
    if set(cell) == {"-"}:
        return [text + "  " + cell[:room]]
    parts = textwrap.wrap(cell, max(room, 10), break_long_words=False, break_on_hyphens=False)
    return [(text + "  " + parts[0]).rstrip(), *(" " * (len(text) + 2) + part for part in parts[1:])]


def record_of(header, row, spans, names, most):
    """The name of a row in a line of its own, then its cells with the names of their columns."""
    pairs = [f"{header[start:end].strip()} {row[start:end].strip()}".strip() for start, end in spans[names:] if row[start:end].strip()]
    out, line = wrap(" ".join(row[:spans[names - 1][1]].split()), most), INDENT
    for pair in pairs:
        if line != INDENT and len(line) + 2 + len(pair) > most:
            out.append(line)
            line = INDENT
        line += ("" if line == INDENT else "  ") + pair
    return [*out, *wrap(line, most)]

"""What a contest says on the page of its run: sections of charts, tables and notes, and the bodies that are shown in 3D. How they look is
the page's business (report/page).
"""

from dataclasses import dataclass, field

GOOD, BAD, OPEN, PLAIN = "good", "bad", "open", "plain"  # how a verdict stands


@dataclass
class Column:
    """A column of a table. `unit` stands in its head; numbers are shown to `digits` digits and sorted by their whole value."""

    title: str
    unit: str = ""
    digits: int = 4


@dataclass
class Table:
    """Rows of cells: texts, numbers, or None for nothing."""

    title: str
    columns: list
    rows: list
    note: str = ""
    file: str = ""  # in the run's folder, with all columns and rows


@dataclass
class Axis:
    """An axis: which key of a row it shows."""

    key: str
    title: str
    unit: str = ""
    is_log: bool = False
    factor: float = 1.0  # a row's value times this is in the unit


@dataclass
class Chart:
    """A chart of rows, one record or one median each. Kinds:

    ranges   a dot a row on `x`, its interval low..high from keys X_low and X_high, rows named by `y`
    points   a dot a row at `x` and `y`, with both intervals where a row has them
    lines    rows of one `series` joined in their order
    bars     a bar from `x` to X_to of the height `y`

    `series` is the key that the colour stands for, `facet` the one that has a panel each. A row may have `hollow` (not to be compared), `note`
    and `case`, the ID by which one repeats it. What a reader sees of a row: x, y, series, facet and `shown`.
    """

    title: str
    kind: str
    x: Axis
    y: Axis
    rows: list
    series: str = ""
    facet: str = ""
    shown: list = field(default_factory=list)  # Axis of more figures
    marks: list = field(default_factory=list)  # {"value", "title", "axis"}: lines at a value
    note: str = ""
    drawn: str = ""  # the name of the same chart below charts/, without its ending


@dataclass
class Note:
    text: str


@dataclass
class Section:
    title: str
    parts: list  # Chart, Table, Note


@dataclass
class Field:
    """A figure at each vertex or tetrahedron of a body."""

    title: str
    unit: str
    on: str  # "vertex" or "tet"
    values: object  # a sequence of floats
    range: tuple = None
    scale: str = "viridis"


@dataclass
class Body:
    """A mesh in 3D. `moves` has (time in s, displacement of each vertex) of a motion."""

    title: str
    group: str  # bodies of one group are looked at side by side
    mesh: object  # shared.mesh_file.Mesh
    fields: list = field(default_factory=list)
    moves: list = field(default_factory=list)
    unit: str = ""
    displacement: object = None  # n x 3, in the unit of the mesh: the shape that a load gives it
    note: str = ""
    case: str = ""  # the ID that the rows of charts have as `case`: a point opens its body by it


@dataclass
class PageParts:
    """All that a contest has for the page. `bodies` is called when the page is written: reading meshes takes time."""

    verdict: str
    state: str = PLAIN
    sections: list = field(default_factory=list)
    bodies: object = None  # () -> iterable of Body

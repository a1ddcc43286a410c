"""Which labels of a plan belong together, and how each is drawn: one mark and colour a method, the same in every chart.

Labels of one method that differ in a single numeric option (effort, iterations) form a curve, in the order of that option.
Marks tell methods apart in grey print; filled ones stand for answers that count, hollow ones for those that do not.
"""

from dataclasses import dataclass

# After Okabe and Ito, told apart by colour-blind eyes; the marks do without colour.
COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#7a5195", "#8c6d1f", "#56B4E9", "#444444", "#b22222", "#2f4f4f",
          "#808000", "#000080"]
MARKS = ["o", "s", "^", "D", "v", "P", "X", "p", "<", ">", "h", "*"]
OWN = "palpate."


@dataclass
class Family:
    """A method with its labels, in the order in which a curve joins them."""

    method: str
    labels: list
    option: str  # the numeric option that tells the labels apart, or "" where no curve joins them
    values: dict  # label -> that option's value
    color: str
    mark: str

    @property
    def is_own(self):
        return self.method.startswith(OWN)


def options_of(run, label):
    for group in run.groups:
        if group.label == label and group.records:
            options = group.records[0].get("options")
            return options if isinstance(options, dict) else {}
    return {}


def differing_option(options):
    """The one numeric option in which all of these differ, or ""."""
    names = set().union(*options)
    differing = [name for name in names if any(other.get(name) != options[0].get(name) for other in options)]
    if len(options) < 2 or len(differing) != 1:
        return ""
    values = [other.get(differing[0]) for other in options]
    numeric = all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in values)
    return differing[0] if numeric and len(set(values)) == len(values) else ""


def read_families(run):
    """The families of a run, in the order of the plan."""
    labels = {}
    for group in run.groups:
        labels.setdefault(group.contestant, dict.fromkeys([])).setdefault(group.label)
    families = []
    for place, (method, own) in enumerate(labels.items()):
        own = list(own)
        options = {label: options_of(run, label) for label in own}
        option = differing_option(list(options.values()))
        values = {label: options[label][option] for label in own} if option else {}
        ordered = sorted(own, key=values.get) if option else own
        families.append(Family(method, ordered, option, values, COLORS[place % len(COLORS)], MARKS[place % len(MARKS)]))
    return families


def family_of(families, label):
    return next((family for family in families if label in family.labels), None)

"""Which labels of a plan belong together, and how each is drawn: one mark and colour a method, the same in every chart.

Labels of one method that differ in a single option of whole numbers (effort, iterations) form a curve, in its order.
Marks tell methods apart in grey print; filled ones stand for answers that count, hollow ones for those that do not.
"""

import os
from dataclasses import dataclass

# Own methods have cold colours and the plain marks, peers warm colours and the others; told apart by colour-blind eyes too.
OWN_COLORS = ["#0072B2", "#009E73", "#56B4E9", "#2f4f4f"]
OWN_MARKS = ["o", "s", "^", "D"]
PEER_COLORS = ["#7a5195", "#8c6d1f", "#D55E00", "#CC79A7", "#b22222", "#444444", "#E69F00", "#808000", "#a0522d", "#c71585"]
PEER_MARKS = ["v", "P", "X", "p", "<", ">", "h", "*", "d", "8"]
OWN = "palpate."


@dataclass
class Family:
    """A method with its labels, in the order in which a curve joins them."""

    method: str
    labels: list
    option: str  # the option that tells the labels apart by whole numbers, or "" where no curve joins them
    names: dict  # label -> what tells it apart from the others: that option's value, or the end of the label
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
    """The one option in which all of these differ, if its values are whole numbers (effort, iterations), or ""."""
    names = set().union(*options)
    differing = [name for name in names if any(other.get(name) != options[0].get(name) for other in options)]
    if len(options) < 2 or len(differing) != 1:
        return ""
    values = [other.get(differing[0]) for other in options]
    numeric = all(isinstance(value, int) and not isinstance(value, bool) for value in values)
    return differing[0] if numeric and len(set(values)) == len(values) else ""


def read_families(run):
    """The families of a run, in the order of the plan."""
    labels = {}
    for group in run.groups:
        labels.setdefault(group.contestant, dict.fromkeys([])).setdefault(group.label)
    families = []
    for method, own in labels.items():
        options = {label: options_of(run, label) for label in own}
        option = differing_option(list(options.values()))
        values = {label: options[label][option] for label in own} if option else {}
        ordered = sorted(own, key=values.get) if option else list(own)
        names = {label: str(values[label]) if option else label[common_start(ordered):] for label in ordered}
        is_own = method.startswith(OWN)
        place = sum(family.is_own == is_own for family in families)
        colors, marks = (OWN_COLORS, OWN_MARKS) if is_own else (PEER_COLORS, PEER_MARKS)
        families.append(Family(method, ordered, option, names, colors[place % len(colors)], marks[place % len(marks)]))
    return families


def common_start(labels):
    """How much of the labels is the same in all, up to the last "_"; all of a single one."""
    if len(labels) == 1:
        return len(labels[0])
    return os.path.commonprefix(labels).rfind("_") + 1


def family_of(families, label):
    return next((family for family in families if label in family.labels), None)

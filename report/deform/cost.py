"""What an answer costs beside how far it is off: over sets of scenes, for the labels whose methods report their cost."""

from deform.deform import COARSE, labels_of, root_mean_square, scene_sets, setting_of, setting_text, settings_of
from shared.records import median
from shared.tables import align, percent_text, seconds_text, write_csv

ERROR = "displacement_deformation"
COSTS = [("unknowns", "unknowns"), ("stiffness_entries", "stiffness"), ("factor_entries", "factor"), ("product_s", "product"),
         ("answer_s", "answer"), ("identify_s", "identify")]
PRODUCT = "stiffness_entries"


def cost_rows(run, sections):
    """One entry a set, setting and label that reports its cost: errors over the scenes, medians of the costs, and the median
    ratio of products to the plan's `beside` on the same scene."""
    found = []
    for name, scenes in scene_sets(run, sections).items():
        for setting in settings_of(sections):
            own = [section for section in sections if setting_of(section) == setting and section.problem.scene in scenes]
            for label in labels_of(own):
                pairs = [(section.find(label), section.peer) for section in own]
                pairs = [(row, peer) for row, peer in pairs
                         if row is not None and row.values.get(PRODUCT) is not None and row.values.get(ERROR) is not None]
                if not pairs:
                    continue
                errors = [row.values[ERROR] for row, _ in pairs]
                ratios = [row.values[PRODUCT] / peer.values[PRODUCT] for row, peer in pairs if peer and peer.values.get(PRODUCT)]
                found.append({"set": name, "setting": setting, "label": label, "scenes": len(pairs),
                              "rms": root_mean_square(errors), "worst": max(errors),
                              "coarse": sum(row.is_coarse(ERROR) for row, _ in pairs), "products": median(ratios),
                              **{cost: median([row.values[cost] for row, _ in pairs if row.values.get(cost) is not None])
                                 for cost, _ in COSTS}})
    return found


def count_text(value):
    return "" if value is None else f"{value:,.0f}"


def cost_text(rows, beside):
    """The table, or nothing where no label reports a cost."""
    if not rows:
        return ""
    shown = []
    for row in rows:
        errors = f"{percent_text(row['rms'])} / {percent_text(row['worst'])}{COARSE if row['coarse'] else ''}"
        ratio = "" if row["products"] is None else f"{row['products']:.2f}"
        shown.append([row["set"], setting_text(row["setting"]), row["label"], errors, ratio,
                      *(seconds_text(row[name]) if name.endswith("_s") else count_text(row[name]) for name, _ in COSTS)])
    header = ["scenes", "problem", "label", "deform %", f"x {beside}" if beside else "", *(title for _, title in COSTS)]
    return ("Error of the deformation (root mean square / worst) and what one answer costs (medians over the scenes). stiffness, factor:\n"
            f"numbers in them; x {beside}: stiffness over that of {beside}, so many products at the cost of one. product, answer: times once all is prepared\n\n"
            + align(header, shown))


def write_cost(rows, folder):
    """Writes cost.csv; returns its name."""
    names = ["rms", "worst", "coarse", "scenes", "products", *(name for name, _ in COSTS)]
    write_csv(folder / "cost.csv", ["set", "poisson_ratio", "vertices", "simplify", "tets_removed_ratio", "label", *names],
              [[row["set"], *row["setting"], row["label"], *(row[name] for name in names)] for row in rows])
    return {"cost.csv"}

"""The load of the machine while a run's repeats were measured, as their records have it.

A record says the load average before the repeat (`load_1min`), the processor time that passed on all processors (`processor_s`) and what
others took of it (`others_s`), in ticks of 10 ms. So the share of others is that of sums, or of repeats that were long enough.
"""

from dataclasses import dataclass

from shared.records import figure, median, present

BUSY = 0.10  # others' share of all processors beyond which a repeat's time is of a busy machine
ENOUGH_S = 0.4  # processor time from which one repeat's share is good to some percent


@dataclass(frozen=True, slots=True)
class Load:
    load_1min: float
    processor_s: float
    others_s: float

    @property
    def share(self):
        """Of others; None if it cannot be told from this repeat alone."""
        if self.processor_s is None or self.others_s is None or self.processor_s < ENOUGH_S:
            return None
        return min(1.0, max(0.0, self.others_s / self.processor_s))


def load_of(record):
    return Load(figure(record, "load_1min"), figure(record, "processor_s"), figure(record, "others_s"))


def loads_of(group):
    """Of each accepted repeat of a group."""
    return group.once("loads", lambda: [load_of(record) for record in group.accepted()])


def share_of(loads):
    """Others' share over all repeats together, or None."""
    known = [load for load in loads if load.processor_s is not None and load.others_s is not None]
    total = sum(load.processor_s for load in known)
    return min(1.0, max(0.0, sum(load.others_s for load in known) / total)) if total >= ENOUGH_S else None


def busy_count(loads):
    return sum(1 for load in loads if load.share is not None and load.share > BUSY)


def load_text(loads):
    """"load 0.9 (most 1.4); others took 2% (most 11%), more than 10% in 1 of 90 repeats"; empty if nothing is known."""
    averages = present(load.load_1min for load in loads)
    if not averages:
        return ""
    text = f"load {median(averages):.2f} (most {max(averages):.2f})"
    share = share_of(loads)
    if share is not None:
        text += f"; others took {100 * share:.0f}%"
        shares = present(load.share for load in loads)
        if shares:
            text += f" (most {100 * max(shares):.0f}%), over {100 * BUSY:.0f}% in {busy_count(loads)} of {len(loads)} repeats"
    return text


def run_notes(run):
    """A warning where others took much of the machine while a run's times were measured; nothing where they did not, or nobody knows."""
    loads = [one for group in run.groups for one in loads_of(group)]
    share = share_of(loads)
    if share is None or (share <= BUSY and busy_count(loads) == 0):
        return []
    return [f"times were measured on a busy machine: {load_text(loads)}"]

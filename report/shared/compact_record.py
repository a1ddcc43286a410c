"""Records as a run of a million of them can be held: what many have in common is read once and stands in memory once.

A record as json reads it takes some 12 kB, most of it names. The lines of a case's repeats are alike but for their times, memory and
numbers; so a line's text without these is its form, and a form that was met before is not read again. Beyond that equal texts and settings are one
object, and the judge's block and the contestant's are packed to some hundred bytes. A packed block is opened when it is asked for; the
latest opened stay open, so that a run of usual size opens each once.
"""

import collections
import hashlib
import json
import marshal
import sys

from shared.run_file import BadRun, is_number, refuse_constant

MOST_OPEN = 20_000  # packed blocks that stay open
MOST_SHARED = 400_000  # forms, texts and blocks that are looked for to be shared: beyond, each record has its own
PACKED_KEYS = ("judge", "report")  # blocks of figures: another one in nearly every case
FLAT_FORM = 2  # of marshal: plain values, without references to earlier ones
NOT_KEPT = ("finished_at", "position")  # no report says when, or in which place of its round, a repeat ran
# What repeats of a case have of their own, in the order in which the runner writes it. Where another order is met the whole line is read.
OWN_KEYS = ("finished_at", "kernel_s", "load_1min", "others_s", "peak_rss_bytes", "position", "processor_s", "repeat", "user_s", "wall_s")
# Each key, how it opens and how long that is, and what stands in a form for its value.
OWN_MARKS = [(key, f'"{key}":'.encode(), len(key) + 3, json.dumps(f"\0{key}\0").encode()) for key in OWN_KEYS]
read_next = json.JSONDecoder(parse_constant=refuse_constant).scan_once
OUTCOMES = ("accepted", "rejected", "bad_input", "error", "crashed", "timed_out", "out_of_memory", "bad_answer", "unavailable", "not_judged")
MOST_COUNT = 10**9  # as gates have it
MOST_NUMBER = sys.float_info.max


def is_from_zero(value):
    return value is None or (type(value) in (float, int) and 0 <= value <= MOST_NUMBER)


TIME = ("a number from 0, or null", is_from_zero)
FLAG = ("true or false", lambda value: type(value) is bool)
# What may stand under a key of a record that figures and tables are taken by (experiments/schema/record.schema.json), where it is there.
FORMS = {
    "case": ("a text", lambda value: type(value) is str),
    "outcome": ("one of " + ", ".join(OUTCOMES), lambda value: type(value) is str and value in OUTCOMES),
    "repeat": (f"a whole number from 0 to {MOST_COUNT}", lambda value: type(value) is int and 0 <= value <= MOST_COUNT),
    "required": FLAG, "warmup": FLAG, "searched": FLAG,
    "kernel_s": TIME, "wall_s": TIME, "user_s": TIME, "peak_rss_bytes": TIME, "load_1min": TIME, "processor_s": TIME,
    "others_s": ("a number or null", lambda value: value is None or is_number(value)),
}
NEEDED = ("case", "outcome", "repeat")
ABSENT = object()


class Packed:
    """A block of JSON as bytes, its keys apart."""

    __slots__ = ("keys", "data", "block")
    latest = collections.deque()  # of those that are open, the first opened first

    def __init__(self, keys, data):
        self.keys, self.data, self.block = keys, data, None

    def opened(self):
        if self.block is None:
            values = marshal.loads(self.data)
            self.block = values if self.keys is None else dict(zip(self.keys, values))
            Packed.latest.append(self)
            if len(Packed.latest) > MOST_OPEN:
                Packed.latest.popleft().block = None
        return self.block


class Record:
    """One record, read like the dict that json makes of its line. It cannot be changed. (No abc.Mapping: `isinstance` would take long.)"""

    __slots__ = ("places", "shared", "own")

    def __init__(self, places, shared, own=()):
        self.places, self.shared, self.own = places, shared, own  # a place below zero counts from the end of `own`

    def get(self, key, default=None):
        place = self.places.get(key)
        if place is None:
            return default
        if place < 0:
            return self.own[place]
        value = self.shared[place]
        return value.opened() if type(value) is Packed else value

    def __getitem__(self, key):
        if key not in self.places:
            raise KeyError(key)
        return self.get(key)

    def __contains__(self, key):
        return key in self.places

    def __iter__(self):
        return iter(self.places)

    def __len__(self):
        return len(self.places)

    def keys(self):
        return self.places.keys()

    def items(self):
        return [(key, self.get(key)) for key in self.places]


class RecordPacker:
    """Makes compact records of one file's lines; what they share is known to it."""

    def __init__(self):
        self.forms = {}  # digest of a form -> (places, shared values, which of its own values are kept), or None of one that cannot be used
        self.places = {}  # keys of a block -> their places
        self.texts = {}
        self.blocks = {}  # bytes -> the block that has them

    def read(self, line):
        """The value in a line of JSON: a Record of an object with a label, anything else as json gives it. Throws what json throws, and NoNumber
        for NaN and infinities."""
        form, keys, texts = split(line)
        digest = hashlib.blake2b(form, digest_size=16).digest()
        known = self.forms.get(digest, self)
        if known is self:
            known = self.read_form(form, keys) if keys else None
            if len(self.forms) < MOST_SHARED:
                self.forms[digest] = known
        own = read_values(texts) if known else None
        if own is None:
            return self.read_whole(line)
        places, shared, kept = known
        return Record(places, shared, tuple([own[place] for place in kept]))

    def read_whole(self, line):
        value = json.loads(line, parse_constant=refuse_constant)
        if not isinstance(value, dict) or not isinstance(value.get("label"), str):
            return value
        for key in NOT_KEPT:
            value.pop(key, None)
        return Record(self.places_of(value), tuple([self.share(key, each) for key, each in value.items()]))

    def read_form(self, form, keys):
        """What lines of this form have in common; None if a mark stands where no record's own key has its value."""
        try:
            value = json.loads(form, parse_constant=refuse_constant)
        except (ValueError, RecursionError):  # so is the line: reading it says where
            return None
        if not isinstance(value, dict) or not isinstance(value.get("label"), str) or any(value.get(key) != f"\0{key}\0" for key in keys):
            return None
        kept = [key for key in keys if key not in NOT_KEPT]
        places, shared = {}, []
        for key, each in value.items():
            if key in kept:
                places[key] = kept.index(key) - len(kept)
            elif key not in keys:
                places[key] = len(shared)
                shared.append(self.share(key, each))
        known = self.places.setdefault(tuple(places.items()), places)
        return known, tuple(shared), tuple(keys.index(key) for key in kept)

    def places_of(self, block):
        """Where each key of a block has its value; one dict for all blocks with these keys."""
        keys = tuple(block)
        found = self.places.get(keys)
        if found is None:
            found = self.places[keys] = {key: place for place, key in enumerate(keys)}
        return found

    def share(self, key, value):
        """An equal value that was met before, or this one; blocks of figures packed."""
        kind = type(value)
        if kind is str:
            return self.texts.setdefault(value, value) if len(self.texts) < MOST_SHARED else self.texts.get(value, value)
        if kind is not dict and kind is not list:
            return value
        if key in PACKED_KEYS and value:
            return self.pack(value)
        data = marshal.dumps(value, FLAT_FORM)
        found = self.blocks.get(data)
        if found is None:
            if len(self.blocks) >= MOST_SHARED:
                return self.pack(value)
            found = self.blocks[data] = value
        return found

    def pack(self, value):
        if type(value) is list:
            return Packed(None, marshal.dumps(value, FLAT_FORM))
        return Packed(self.places_of(value), marshal.dumps(list(value.values()), FLAT_FORM))


def split(line):
    """A line's form, the keys whose values were taken out of it, and the texts of these values."""
    pieces, keys, texts, end = [], [], [], 0
    for key, opening, length, mark in OWN_MARKS:
        start = line.find(opening, end)
        if start < 0:
            continue
        start += length
        stop = line.find(b",", start)
        if stop < 0:
            break
        pieces += line[end:start], mark
        keys.append(key)
        texts.append(line[start:stop])
        end = stop
    pieces.append(line[end:])
    return b"".join(pieces), keys, texts


def read_values(texts):
    """The values that the texts are, one each; None if one of them is no whole value. No text has a comma in it, so that as many values as
    texts are one a text."""
    try:
        text = f"[{b','.join(texts).decode()}]"
        values, end = read_next(text, 0)
    except (ValueError, StopIteration, RecursionError):
        return None
    return values if end == len(text) and len(values) == len(texts) else None


def check_forms(record, where):
    """Throws BadRun for the first key that has something else than it may have, or that is needed and absent."""
    for key, (expected, fits) in FORMS.items():
        value = record.get(key, ABSENT)
        if value is ABSENT:
            if key in NEEDED:
                raise BadRun(f"{where}: {key}: expected {expected}, found nothing")
        elif not fits(value):
            raise BadRun(f"{where}: {key}: expected {expected}, found {json.dumps(value)[:80]}")

"""A run's records in a folder that is small enough to be kept for good: archive.json, plan.yaml, provenance.json, records.jsonl.xz.

archive.json, schema palpate/archive/1: {"schema", "plan" (its name), "records" (lines), "bytes" and "sha256" of records.jsonl}. What a report
is made from is in there, bodies and fields are not: a page of an archive has no 3D.
"""

import contextlib
import hashlib
import json
import lzma
import pathlib

from shared.records import each_record
from shared.run_file import BadRun, open_file, read_bytes, read_object
from shared.whole_file import replacing

ARCHIVE = "palpate/archive/1"  # docs/schemas.md
NOTE, RECORDS, PACKED = "archive.json", "records.jsonl", "records.jsonl.xz"
COPIED = ("plan.yaml", "provenance.json")
READ_BYTES = 2**20
MOST_DICTIONARY_BYTES = 256 * 2**20  # that a reader has to have for the records, whatever the file asks for
KEYS = {"schema": str, "plan": str, "records": int, "bytes": int, "sha256": str}


def is_archive(folder):
    return (pathlib.Path(folder) / NOTE).exists()


def blocks_of(stream):
    return iter(lambda: stream.read(READ_BYTES), b"")


def pack(run, folder):
    """Writes an archive of the run into a folder that is new or empty; returns what archive.json says. The same records make the same bytes. The
    note comes last: without it nobody takes the folder for an archive. Raises: BadRun if it is no whole run, a record is broken, or the folder holds something."""
    run, folder = pathlib.Path(run), pathlib.Path(folder)
    for name in (*COPIED, RECORDS):
        if not (run / name).is_file():
            raise BadRun(f"{run / name}: expected a file of a run, found none")
    require_empty(folder)
    plan = read_object(run / "provenance.json").get("plan")
    if not isinstance(plan, str):
        raise BadRun(f"{run / 'provenance.json'}: expected the plan's name, found {plan!r}")
    count = count_records(run / RECORDS)
    with emptied_on_failure(folder):
        for name in COPIED:
            (folder / name).write_bytes(read_bytes(run / name))
        note = {"schema": ARCHIVE, "plan": plan, **pack_records(run / RECORDS, folder / PACKED)}
        if note["records"] != count:
            raise BadRun(f"{run / RECORDS}: expected a record a line, found {count:,} in {note['records']:,} lines")
        (folder / NOTE).write_text(json.dumps(note, indent=2) + "\n")
    return note


def count_records(records):
    """How many records there are. Raises: BadRun if there are none, or if one is none."""
    notes = []
    count = sum(1 for _ in each_record(records, notes))
    if notes:
        raise BadRun(f"{records}: its last record is cut; --resume mends that")
    if count == 0:
        raise BadRun(f"{records}: expected the records of a run, found none")
    return count


def pack_records(records, place):
    """Packs the records; returns how many lines there are, their bytes and their sum. Raises: BadRun if the last one is cut."""
    digest, lines, size, last = hashlib.sha256(), 0, 0, b"\n"
    with open_file(records) as source, lzma.open(place, "wb", preset=9) as packed:
        for block in blocks_of(source):
            digest.update(block)
            lines, size, last = lines + block.count(b"\n"), size + len(block), block[-1:]
            packed.write(block)
    if last != b"\n":
        raise BadRun(f"{records}: its last record is cut; --resume mends that")
    return {"records": lines, "bytes": size, "sha256": digest.hexdigest()}


@contextlib.contextmanager
def emptied_on_failure(folder):
    """Of a folder that was empty: if anything fails, it is empty again, and takes the next try."""
    try:
        yield
    except BaseException:
        for path in folder.iterdir():
            path.unlink()
        raise


def require_empty(folder):
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()):
        raise BadRun(f"{folder}: expected a new or an empty folder, found files")


def read_note(folder):
    """What archive.json says. Raises: BadRun if it is not what it has to be."""
    path = folder / NOTE
    note = read_object(path)
    if note.get("schema") != ARCHIVE:
        raise BadRun(f"{path}: expected the schema {ARCHIVE}, found {note.get('schema')!r}")
    for key, kind in KEYS.items():
        if type(note.get(key)) is not kind:
            raise BadRun(f"{path}: {key}: expected {'a whole number' if kind is int else 'a text'}, found {note.get(key)!r}")
    return note


def unpack(archive, folder):
    """Makes a run folder of an archive, in a folder that is new or empty. No more bytes are written than archive.json announces, and they have to be
    those that were packed. Raises: BadRun if anything is not as it says; the folder is then left without records."""
    archive, folder = pathlib.Path(archive), pathlib.Path(folder)
    note = read_note(archive)
    for name in (*COPIED, PACKED):
        if not (archive / name).is_file():
            raise BadRun(f"{archive / name}: expected a file of an archive, found none")
    require_empty(folder)
    with emptied_on_failure(folder), replacing(folder / RECORDS) as whole:
        unpack_records(archive / PACKED, note, whole)
        for name in COPIED:
            (folder / name).write_bytes(read_bytes(archive / name))


def unpack_records(packed, note, place):
    digest, lines, size = hashlib.sha256(), 0, 0
    reader = lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=MOST_DICTIONARY_BYTES)
    with open_file(packed) as source, open(place, "wb") as target:
        try:
            while not reader.eof:
                read = source.read(READ_BYTES) if reader.needs_input else b""
                if reader.needs_input and not read:
                    raise BadRun(f"{packed}: cut off")
                block = reader.decompress(read, READ_BYTES)
                size += len(block)
                if size > note["bytes"]:
                    raise BadRun(f"{packed}: expected {note['bytes']} bytes of records, found more")
                digest.update(block)
                lines += block.count(b"\n")
                target.write(block)
        except lzma.LZMAError as error:
            raise BadRun(f"{packed}: {error}") from None
        if reader.unused_data or source.read(1):
            raise BadRun(f"{packed}: expected its end, found more")
    if (size, lines, digest.hexdigest()) != (note["bytes"], note["records"], note["sha256"]):
        raise BadRun(f"{packed}: expected {note['records']} records in {note['bytes']} bytes with the sum that {NOTE} has, found "
                     f"{lines} in {size}" + ("" if (size, lines) != (note["bytes"], note["records"]) else " with another"))

"""Files that are there whole or not at all."""

import contextlib
import os


@contextlib.contextmanager
def replacing(path, beside=None):
    """Gives the name of a file beside `path` to write to, and renames it at the end: a reader sees the old file or the new one. If anything
    fails, what was written goes."""
    beside = beside or path.with_name(path.name + ".part")
    beside.unlink(missing_ok=True)  # a link there, in a run that somebody else packed, would have another file written
    try:
        yield beside
        os.replace(beside, path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise

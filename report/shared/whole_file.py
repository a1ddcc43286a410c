"""Files that are there whole or not at all."""

import contextlib
import os
import stat

from shared.run_file import BadRun, kind_of


def has_file(path):
    """Whether there is a file that another one may take the place of. Raises: BadRun for anything else there: a device, a pipe or a link
    that is renamed upon is gone."""
    try:
        mode = os.lstat(path).st_mode
    except FileNotFoundError:
        return False
    except OSError as error:
        raise BadRun(f"{path}: expected a file that can be written, found: {error.strerror}") from error
    if not stat.S_ISREG(mode):
        raise BadRun(f"{path}: expected a file or nothing, found {kind_of(mode)}")
    return True


@contextlib.contextmanager
def replacing(path, beside=None):
    """Gives the name of a file beside `path` to write to, and renames it at the end: a reader sees the old file or the new one. If anything
    fails, what was written goes. Raises: BadRun if what is there is no regular file."""
    has_file(path)
    beside = beside or path.with_name(path.name + ".part")
    beside.unlink(missing_ok=True)  # a link there, in a run that somebody else packed, would have another file written
    try:
        yield beside
        os.replace(beside, path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise

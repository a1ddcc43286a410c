"""What the scripts leave with when something goes wrong, and the one line that they say of it."""

import contextlib
import sys
import traceback

from shared.records import BadRun


def complain(text):
    """Says a line where that can be done: a word that cannot be written (its file may lie on the full disk that it is about) changes no exit code."""
    with contextlib.suppress(OSError):
        print(text, file=sys.stderr, flush=True)


def guarded(work, name="", fault="cannot write "):
    """The exit code of `work()`: its own; 2 for a bad run; 3 for a file that could not be written, and for a fault of the script. `name` and
    `fault` come before what is said."""
    try:
        code = work()
        sys.stdout.flush()
        return code
    except BadRun as error:
        complain(f"{name}{error}")
        return 2
    except OSError as error:
        complain(f"{name}{fault}{error.filename or 'a file'}: {error.strerror}")
        return 3
    except Exception:  # Python would leave with 1, which stands for something else
        complain(traceback.format_exc().rstrip())
        return 3

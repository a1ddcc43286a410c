"""What the scripts leave with when something goes wrong, and the one line that they say of it."""

import sys
import traceback

from shared.records import BadRun


def guarded(work, name="", fault="cannot write "):
    """The exit code of `work()`: its own; 2 for a bad run; 3 for a file that could not be written, and for a fault of the script. `name` and
    `fault` come before what is said."""
    try:
        return work()
    except BadRun as error:
        print(f"{name}{error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{name}{fault}{error.filename or 'a file'}: {error.strerror}", file=sys.stderr)
        return 3
    except Exception:  # Python would leave with 1, which stands for something else
        traceback.print_exc()
        return 3

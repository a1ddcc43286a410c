"""The one reader of the files that a run's folder has: what a contestant left there may be deep, huge, odd, or no file at all.

All of it is refused by a BadRun, which has the path; what that means is the caller's: a run without records is none, a motion that cannot
be read is not drawn, and noted.
"""

import errno
import io
import json
import math
import os
import re
import stat

MOST_BYTES = 512 * 2**20  # of a text
MOST_VALUES = 2**25  # of a JSON text: each takes up to 64 bytes and more
MOST_DEPTH = 64  # of lists and objects within one another, as the runner has it
MOST_DIGITS = 300  # of a whole number: longer ones fit into no double
OTHERS_THAN_BRACKETS = bytes(set(range(256)) - set(b'[]{}"'))
STRING = re.compile(rb'"(?:[^"\\]|\\.)*"', re.DOTALL)
KINDS = ((stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"), (stat.S_ISLNK, "a link"))


class BadRun(Exception):
    """The folder is no run folder, or a file in it is not what it has to be: one line, with the place."""


def kind_of(mode):
    """What it is that has this mode, if it is no regular file."""
    return next((kind for is_kind, kind in KINDS if is_kind(mode)), "a device")


def open_file(path):
    """A file to read bytes from. A pipe is not waited for, a link not followed: whoever packed the run could show what it leads to. Throws BadRun."""
    try:
        file = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOFOLLOW)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the path
        if getattr(error, "errno", None) == errno.ELOOP:
            raise BadRun(f"{path}: expected a file, found a link") from error
        raise BadRun(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from error
    mode = os.fstat(file).st_mode
    if not stat.S_ISREG(mode):
        os.close(file)
        raise BadRun(f"{path}: expected a file, found {kind_of(mode)}")
    return io.open(file, "rb", buffering=2**20)


def read_bytes(path, most=MOST_BYTES):
    """All bytes of a file. Throws BadRun if there are more than `most`."""
    with open_file(path) as file:
        size = os.fstat(file.fileno()).st_size
        if size > most:
            raise BadRun(f"{path}: expected at most {most:,} bytes, found {size:,}")
        try:
            data = file.read(most + 1)
        except OSError as error:
            raise BadRun(f"{path}: cannot be read ({error.strerror})") from error
    if len(data) > most:  # it grows
        raise BadRun(f"{path}: expected at most {most:,} bytes, found more")
    return data


def read_text(path, most=MOST_BYTES):
    """The text of a file. Throws BadRun."""
    try:
        return read_bytes(path, most).decode("utf-8")
    except UnicodeDecodeError as error:
        raise BadRun(f"{path}: expected UTF-8 text") from error


def is_deeper(data, most=MOST_DEPTH):
    """Whether lists and objects lie within one another more than `most` deep, before anybody walks through them."""
    brackets = (STRING.sub(b"", data) if b'"' in data else data).translate(None, OTHERS_THAN_BRACKETS)
    depth = 0
    for bracket in brackets:
        depth += 1 if bracket in b"[{" else -1 if bracket in b"]}" else 0
        if depth > most:
            return True
    return False


class NoNumber(ValueError):
    """A word of Python's where JSON has numbers."""


def refuse_constant(word):
    raise NoNumber(f"expected a number, found {word}")


def whole_number(text):
    return int(text) if len(text) <= MOST_DIGITS else math.inf


def json_fault(error):
    """What is wrong with a text that is no JSON, in one line."""
    return "lists or objects too deep within one another" if isinstance(error, RecursionError) else str(error)


def parse_json(data, where):
    """The value in JSON's bytes. Throws BadRun, which begins with `where`."""
    values = data.count(b",") + data.count(b"[") + data.count(b"{")
    if values > MOST_VALUES:
        raise BadRun(f"{where}: expected at most {MOST_VALUES:,} values of JSON, found about {values:,}")
    if is_deeper(data):
        raise BadRun(f"{where}: expected JSON, found lists or objects too deep within one another ({MOST_DEPTH} are the most)")
    try:
        return json.loads(data.decode("utf-8"), parse_constant=refuse_constant, parse_int=whole_number)
    except UnicodeDecodeError as error:
        raise BadRun(f"{where}: expected UTF-8 text") from error
    except NoNumber as error:
        raise BadRun(f"{where}: {error}") from error
    except (ValueError, RecursionError) as error:
        raise BadRun(f"{where}: expected JSON, found {json_fault(error)}") from error


def read_json(path, most=MOST_BYTES):
    """The value that a file of JSON has, whatever it is. Throws BadRun."""
    return parse_json(read_bytes(path, most), path)


def read_object(path, most=MOST_BYTES):
    """The object that a file of JSON has. Throws BadRun."""
    data = read_json(path, most)
    if not isinstance(data, dict):
        raise BadRun(f"{path}: expected an object of JSON, found something else")
    return data


def is_number(value):
    """Whether it is a number of JSON that a double can hold; true and false are none."""
    try:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number of more than 308 digits
        return False


def are_numbers(values):
    """Whether it is a list of finite numbers."""
    try:
        return isinstance(values, list) and set(map(type, values)) <= {int, float} and all(map(math.isfinite, values))
    except OverflowError:
        return False

"""Holds that no two sources that are compiled together (cmake/unite.cmake) have a function of one name to themselves.

    own_names.py BUILD

Types and constants of one name the compiler refuses. Functions of one name with other parameters it takes for overloads of one, and calls whichever
fits better, in either source. Which sources are compiled together is read from the build's compile commands; with PALPATE_UNITE=OFF none are. Exits with 1 if
there are any, and names them.
"""

import json
import pathlib
import re
import sys

INCLUDE = re.compile(r'^#include "(.+)"$', re.MULTILINE)
OPENS = re.compile(r"^namespace \{$")
CLOSES = re.compile(r"^\}  // namespace$")
RAW_STRING = re.compile(r'R"(\w*)\(.*?\)\1"', re.DOTALL)
BY_TYPE = {"PrintTo"}  # found by the type of what is printed, which the compiler holds to one
# A definition or declaration begins at the margin (clang-format), and its name stands before the first bracket.
FUNCTION = re.compile(r"^(?!(?:template|using|static_assert|namespace|struct|class|enum|union|TEST|INSTANTIATE|MATCHER|#|\}|/)\b)[A-Za-z_][^=;({]*?[\s*&](\w+)\(")


def own_functions(text):
    """The functions that a source defines in its unnamed namespaces."""
    inside, names = False, set()
    for line in RAW_STRING.sub("", text).splitlines():
        if OPENS.match(line):
            inside = True
        elif CLOSES.match(line):
            inside = False
        elif inside:
            found = FUNCTION.match(line)
            if found and found[1] not in BY_TYPE:
                names.add(found[1])
    return names


def find_twins(sources):
    """The names that more than one of these texts has to itself: name -> where."""
    places = {}
    for place, text in sources.items():
        for name in own_functions(text):
            places.setdefault(name, []).append(place)
    return {name: sorted(where) for name, where in sorted(places.items()) if len(where) > 1}


def main(arguments):
    commands = json.loads((pathlib.Path(arguments[0]) / "compile_commands.json").read_text(encoding="utf-8"))
    units = sorted({pathlib.Path(each["file"]) for each in commands if "/Unity/" in each["file"]})
    seen, count = set(), 0
    for unit in units:
        together = INCLUDE.findall(unit.read_text(encoding="utf-8"))
        twins = find_twins({place: pathlib.Path(place).read_text(encoding="utf-8") for place in together})
        count += len(together)
        seen.update((name, *where) for name, where in twins.items())
    for name, *where in sorted(seen):
        print(f"{name}: {', '.join(where)}")
    print(f"{len(units)} units of {count} sources: {len(seen)} names stand in more than one of those compiled together")
    return 1 if seen else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

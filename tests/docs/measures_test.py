"""Every measure of the program has its row in docs/measures.md, with its unit and direction, and no other has one."""

import json
import pathlib
import re
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import pages


def rows_of(text):
    """{name: (unit, better, formula)} of the rows that start with a name in code."""
    found = {}
    for line in text.split("\n"):
        match = re.match(r"\| `(\w+)` \|([^|]*)\|([^|]*)\| (.*) \|$", line)
        if match:
            if match.group(1) in found:
                raise ValueError(f"twice: {match.group(1)}")
            found[match.group(1)] = tuple(cell.strip() for cell in match.groups()[1:])
        elif re.match(r"\| `\w+`", line):
            raise ValueError(f"not four cells: {line}")
    return found


def differences(listed, rows):
    """What the page lacks, has too much, or says otherwise."""
    names = [measure["name"] for measure in listed]
    found = [f"no row: {name}" for name in names if name not in rows] + [f"no measure: {name}" for name in rows if name not in names]
    for measure in listed:
        unit, better, formula = rows.get(measure["name"], (measure["unit"], measure["better"] or "", "none"))
        if (unit, better) != (measure["unit"], measure["better"] or ""):
            found.append(f"{measure['name']}: expected {measure['unit']}, {measure['better']}; found {unit}, {better}")
        if not formula:
            found.append(f"{measure['name']}: no formula")
    return found


class Measures(unittest.TestCase):
    def test_the_page_and_the_program_have_the_same(self):
        listed = json.loads(subprocess.run([pages.PROGRAM, "list", "measures", "--json"], capture_output=True, text=True, check=True).stdout)["measures"]
        self.assertGreater(len(listed), 100)
        self.assertEqual(differences(listed, rows_of((pages.ROOT / "docs" / "measures.md").read_text(encoding="utf-8"))), [])

    def test_what_differs_is_noticed(self):
        listed = [{"name": "a", "unit": "s", "better": "lower"}, {"name": "b", "unit": "1", "better": ""}]
        self.assertEqual(differences(listed, rows_of("| `a` | s | lower | x |\n| `b` | 1 | | y |")), [])
        self.assertEqual(len(differences(listed, rows_of("| `a` | s | higher | x |\n| `c` | 1 | | y |"))), 3)
        with self.assertRaises(ValueError):
            rows_of("| `a` | s | lower |")


if __name__ == "__main__":
    unittest.main()

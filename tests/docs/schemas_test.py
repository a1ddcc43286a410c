"""Every schema in the sources has its row in docs/schemas.md, and every row its schema in the sources."""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import pages
from pages import ROOT

PAGE = ROOT / "docs" / "schemas.md"
WINGS = ("core", "live", "reference", "experiments", "report", "page")
ENDINGS = {".cpp", ".h", ".py", ".ts", ".mjs", ".json", ".yaml", ".sh", ""}  # "": the Snakefile
NAME = re.compile(r"palpate/[a-z][a-z_]*/[0-9]+")
STRICT = ("plan", "scene", "contestant", "training", "accepted", "record")  # with a form in experiments/schema


def names_in_sources():
    """{schema: the first source that names it}"""
    found = {}
    for wing in WINGS:
        for path in sorted((ROOT / wing).rglob("*")):
            if path.suffix in ENDINGS and "node_modules" not in path.parts and path.is_file():
                for name in NAME.findall(path.read_text(encoding="utf-8", errors="replace")):
                    found.setdefault(name, str(path.relative_to(ROOT)))
    return found


def rows_of(text):
    """The schemas of the rows, in order."""
    return re.findall(r"(?m)^\| `([^`]+)` \|", text)


def differences(sources, rows):
    found = [f"no row: {name} ({where})" for name, where in sources.items() if name not in rows]
    found += [f"nowhere in the sources: {name}" for name in rows if name not in sources]
    return found + [f"twice: {name}" for name in set(rows) if rows.count(name) > 1]


class Schemas(unittest.TestCase):
    def test_the_page_lists_what_the_sources_name_and_no_more(self):
        sources = names_in_sources()
        self.assertGreater(len(sources), 25)
        self.assertEqual(differences(sources, rows_of(PAGE.read_text(encoding="utf-8"))), [])

    def test_every_form_says_which_schema_it_is_of(self):
        forms = {path.name.split(".")[0]: path for path in (ROOT / "experiments" / "schema").glob("*.schema.json")}
        self.assertEqual(set(forms), set(STRICT))
        rows = rows_of(PAGE.read_text(encoding="utf-8"))
        for name, path in forms.items():
            form = json.loads(path.read_text(encoding="utf-8"))
            known = form["properties"]["schema"]
            versions = known.get("enum", [known.get("const")])
            self.assertEqual(set(versions), {row for row in rows if row.startswith(f"palpate/{name}/")})

    def test_a_file_of_a_version_that_is_not_read_is_refused_as_the_page_says(self):
        shown = next(line.strip() for line in PAGE.read_text(encoding="utf-8").split("\n") if line.startswith("    plan.yaml:1:"))
        with tempfile.TemporaryDirectory() as folder:
            plan = pathlib.Path(folder) / "plan.yaml"
            text = (ROOT / "experiments" / "plans" / "ci.yaml").read_text(encoding="utf-8")
            lines = [line for line in text.split("\n") if not line.startswith("#")]
            self.assertEqual(lines[0], "schema: palpate/plan/1")
            plan.write_text("\n".join(["schema: palpate/plan/2", *lines[1:]]), encoding="utf-8")
            done = subprocess.run([pages.PROGRAM, "check", "plan.yaml"], cwd=folder, capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr.strip()), (2, f"palpate: {shown}"))

    def test_what_is_wrong_is_found(self):
        sources = names_in_sources()
        rows = rows_of(PAGE.read_text(encoding="utf-8"))
        self.assertEqual(differences({**sources, "palpate/new/1": "a.cpp"}, rows), ["no row: palpate/new/1 (a.cpp)"])
        self.assertEqual(differences(sources, [*rows, "palpate/old/1"]), ["nowhere in the sources: palpate/old/1"])
        self.assertEqual(differences(sources, [*rows, rows[0]]), [f"twice: {rows[0]}"])


if __name__ == "__main__":
    unittest.main()

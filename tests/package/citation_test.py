"""CITATION.cff has the keys of the Citation File Format 1.2.0, the version of the CMake project, and the thesis.

    /usr/bin/python3 -B tests/package/citation_test.py
"""

import pathlib
import re
import unittest

import jsonschema
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
TEXT = {"type": "string", "minLength": 1}
PERSON = ("address affiliation alias city country email family-names fax given-names name-particle name-suffix orcid post-code region tel website").split()
ENTITY = "address alias city country date-end date-start email fax location name orcid post-code region tel website".split()
# A reference may have more; these are what one of a thesis can mean.
REFERENCE = ("abbreviation abstract authors copyright date-accessed date-published department doi identifiers institution isbn keywords languages license month notes "
             "pages publisher repository scope status thesis-type title type url year").split()
SOFTWARE = ("abstract authors cff-version commit contact date-released doi identifiers keywords license license-url message preferred-citation references repository "
            "repository-artifact repository-code title type url version").split()


def texts(names):
    return {name: TEXT for name in names}


PERSON_SCHEMA = {"type": "object", "additionalProperties": False, "properties": texts(PERSON)}
ENTITY_SCHEMA = {"type": "object", "additionalProperties": False, "properties": texts(ENTITY), "required": ["name"]}
AUTHORS = {"type": "array", "minItems": 1, "uniqueItems": True, "items": {"anyOf": [PERSON_SCHEMA, ENTITY_SCHEMA]}}
REFERENCE_SCHEMA = {"type": "object", "additionalProperties": False, "required": ["authors", "title", "type"], "properties": {
    **texts(REFERENCE), "authors": AUTHORS, "institution": ENTITY_SCHEMA, "publisher": ENTITY_SCHEMA, "type": {"enum": ["thesis", "article", "software"]},
    "year": {"type": "integer"}, "month": {"type": "integer", "minimum": 1, "maximum": 12}}}
SCHEMA = {"type": "object", "additionalProperties": False, "required": ["authors", "cff-version", "message", "title"], "properties": {
    **texts(SOFTWARE), "authors": AUTHORS, "cff-version": {"const": "1.2.0"}, "type": {"enum": ["software", "dataset"]}, "license": {"const": "Apache-2.0"},
    "keywords": {"type": "array", "minItems": 1, "uniqueItems": True, "items": TEXT}, "references": {"type": "array", "minItems": 1, "items": REFERENCE_SCHEMA}}}


def read(text):
    return yaml.safe_load(text)


def faults(citation):
    return [error.message for error in jsonschema.Draft7Validator(SCHEMA).iter_errors(citation)]


class Citation(unittest.TestCase):
    def setUp(self):
        self.citation = read((ROOT / "CITATION.cff").read_text(encoding="utf-8"))

    def test_its_keys_are_those_of_the_format(self):
        self.assertEqual(faults(self.citation), [])

    def test_its_version_is_the_projects(self):
        project = re.search(r"^project\(palpate VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.MULTILINE).group(1)
        self.assertEqual(self.citation["version"], project)
        changes = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE).group(1)
        self.assertEqual(changes, project)
        self.assertIn(f"palpate-{project}.tar.gz", (ROOT / "Containerfile").read_text(encoding="utf-8"))

    def test_the_thesis_is_cited(self):
        (thesis,) = [each for each in self.citation["references"] if each["type"] == "thesis"]
        self.assertEqual((thesis["authors"][0]["family-names"], thesis["year"], thesis["institution"]["name"]), ("Mukherjee", 2008, "The University of Texas at Arlington"))

    def test_what_is_wrong_is_found(self):
        for key, value in (("autor", "a"), ("cff-version", "1.1.0"), ("authors", []), ("type", "program"), ("references", [{"type": "thesis", "title": "a"}])):
            self.assertTrue(faults({**self.citation, key: value}), key)
        self.assertTrue(faults({key: value for key, value in self.citation.items() if key != "message"}))


if __name__ == "__main__":
    unittest.main(verbosity=2)

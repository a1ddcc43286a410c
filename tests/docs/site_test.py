"""Links of the pages, and the site made of them: every one leads somewhere, every page is in the index, the same texts give the same bytes."""

import html.parser
import pathlib
import subprocess
import sys
import tempfile
import unittest
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import pages
from pages import ROOT

SCRIPT = ROOT / "cmake" / "site" / "make_site.py"
sys.path.insert(0, str(SCRIPT.parent))
import make_site


class Reader(html.parser.HTMLParser):
    """Addresses, anchors and structure of a page."""

    def __init__(self):
        super().__init__()
        self.addresses, self.anchors, self.tags, self.alone = [], set(), [], set()

    def handle_starttag(self, tag, attributes):
        own = dict(attributes)
        self.tags.append(tag)
        self.addresses += [own[name] for name in ("href", "src") if name in own]
        if "id" in own:
            self.anchors.add(own["id"])
        if tag == "img" and not own.get("alt"):
            self.alone.add(own.get("src"))


def read_html(path):
    reader = Reader()
    reader.feed(path.read_text(encoding="utf-8"))
    return reader


def broken_addresses(folder):
    """What of a site leads nowhere, or to the net without being a link of the text."""
    read = {path: read_html(path) for path in folder.rglob("*.html")}
    for path, reader in read.items():
        for address in reader.addresses:
            parts = urllib.parse.urlsplit(address)
            if parts.scheme:
                continue
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            if not target.is_file():
                yield f"{path.name}: {address}"
            elif parts.fragment and target in read and parts.fragment not in read[target].anchors:
                yield f"{path.name}: {address}"


def build(out, root=ROOT):
    return subprocess.run(["/usr/bin/python3", "-B", SCRIPT, root, out], capture_output=True, text=True, check=False)


class Links(unittest.TestCase):
    def test_every_relative_link_of_every_page_leads_somewhere(self):
        parser = make_site.markdown()
        read = {str(path.relative_to(ROOT)): make_site.read_page(ROOT, str(path.relative_to(ROOT)), parser) for path in pages.pages()}
        self.assertGreater(sum(1 for page in read.values() for _ in make_site.links_of(page)), 100)
        self.assertEqual(list(make_site.broken_links(ROOT, read)), [])

    def test_every_page_of_docs_is_in_the_index(self):
        parser = make_site.markdown()
        index = make_site.read_page(ROOT, make_site.INDEX, parser)
        named = {make_site.target_of(index, token.attrGet(name))[0] for token, name in make_site.links_of(index)}
        own = {str(path.relative_to(ROOT)) for path in (ROOT / "docs").glob("*.md")} - {make_site.INDEX}
        self.assertEqual(own - named, set())

    def test_broken_links_are_noticed(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "docs").mkdir()
            (root / "README.md").write_text("# A\n[b](docs/README.md#there) [c](docs/none.md) ![d](docs/none.png)\n", encoding="utf-8")
            (root / "docs" / "README.md").write_text("# B\n## Here\n[a](../README.md#a) [out](../../x) [net](https://example.org/none)\n", encoding="utf-8")
            done = build(root / "site", root)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(sorted(done.stderr.strip().split("\n")),
                             ["site: README.md: no file docs/none.md", "site: README.md: no file docs/none.png",
                              "site: README.md: no heading docs/README.md#there", "site: docs/README.md: no file ../../x"])
            self.assertFalse((root / "site").exists())


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.out = pathlib.Path(folder.name) / "site"
        cls.done = build(cls.out)

    def test_it_builds_and_no_link_is_broken(self):
        self.assertEqual((self.done.returncode, self.done.stderr), (0, ""))
        self.assertGreater(len(list(self.out.glob("*.html"))), 25)
        self.assertEqual(list(broken_addresses(self.out)), [])

    def test_each_page_has_its_place_in_the_navigation_one_title_and_texts_for_pictures(self):
        for path in self.out.glob("*.html"):
            reader = read_html(path)
            self.assertEqual(reader.tags.count("h1"), 1, path.name)
            self.assertEqual(reader.alone, set(), path.name)
            self.assertIn("main", reader.tags)
            self.assertNotIn("script", reader.tags)
            self.assertGreater(reader.tags.count("a"), 25, path.name)

    def test_it_loads_nothing_from_elsewhere(self):
        for path in self.out.glob("*.html"):
            text = path.read_text(encoding="utf-8")
            self.assertNotIn("@import", text)
            self.assertNotIn('src="http', text)
            self.assertNotIn("<link", text)

    def test_tables_code_and_marks_come_through(self):
        text = (self.out / "measures.html").read_text(encoding="utf-8")
        self.assertIn("<code>mean_quality</code>", text)
        self.assertGreater(text.count("<table>"), 10)
        self.assertIn(make_site.MARKS["long"], (self.out / "index.html").read_text(encoding="utf-8"))
        self.assertIn(make_site.MARKS["part"], (self.out / "contest.html").read_text(encoding="utf-8"))
        self.assertIn("run by the test live.page", (self.out / "live.html").read_text(encoding="utf-8"))

    def test_the_same_texts_give_the_same_bytes(self):
        before = {path.relative_to(self.out): path.read_bytes() for path in self.out.rglob("*") if path.is_file()}
        self.assertEqual(build(self.out).returncode, 0)
        self.assertEqual({path.relative_to(self.out): path.read_bytes() for path in self.out.rglob("*") if path.is_file()}, before)

    def test_a_folder_of_somebody_else_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "mine.txt").write_text("mine", encoding="utf-8")
            done = build(folder)
            self.assertEqual(done.returncode, 2)
            self.assertIn("expected a new or empty folder", done.stderr)
            self.assertEqual([path.name for path in pathlib.Path(folder).iterdir()], ["mine.txt"])

    def test_an_anchor_is_that_of_github(self):
        self.assertEqual([make_site.anchor_of(title) for title in ("What is measured", "The file: `palpate/model/1`", "How good is the reference?", "1 kHz, and more")],
                         ["what-is-measured", "the-file-palpatemodel1", "how-good-is-the-reference", "1-khz-and-more"])

    def test_a_site_with_a_broken_address_is_noticed(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            (out / "a.html").write_text('<a href="b.html">b</a><a href="#c">c</a><a href="a.html">a</a>', encoding="utf-8")
            self.assertEqual(list(broken_addresses(out)), ["a.html: b.html", "a.html: #c"])


if __name__ == "__main__":
    unittest.main()

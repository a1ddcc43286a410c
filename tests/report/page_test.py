"""The page of a run, on made-up records: what stands in it, that nothing in a record becomes markup, and that it stays small."""

import base64
import contextlib
import html.parser
import io
import json
import os
import pathlib
import re
import shutil
import tempfile
import unittest
import unittest.mock
import zlib

import numpy as np

from support import ReportTest
import compare_page
import synthetic
from page import bodies_json, chart_html, facts, markup, table_html, write_page
from shared.mesh_file import Mesh
from shared.page_parts import Axis, Body, Chart, Column, Field, Table
from shared.records import BadRun

EVIL = "</script><script>alert(1)</script><!-- <b a='\"&\">"
SCRIPT = "window.a = '</script>' + '<!--';"


class Reader(html.parser.HTMLParser):
    """Elements with their texts; addresses that something would be fetched from."""

    def __init__(self, text):
        super().__init__()
        self.is_broken = False
        self.tags, self.blocks, self.texts, self.addresses, self.open = [], {}, {}, [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.tags.append(tag)
        if tag not in ("meta", "img", "input", "br", "link"):
            self.open.append((tag, attributes.get("id")))
        self.addresses += [value for name, value in attributes.items() if name in ("src", "href", "srcset", "data", "action")]

    def handle_endtag(self, tag):
        self.is_broken |= not self.open or self.open[-1][0] != tag
        if not self.is_broken:
            self.open.pop()

    def handle_data(self, data):
        if self.open and self.open[-1][0] == "script":
            self.blocks[self.open[-1][1]] = self.blocks.get(self.open[-1][1], "") + data
        for tag, name in self.open:
            if name:
                self.texts[name] = self.texts.get(name, "") + data


class PageTest(ReportTest):
    def setUp(self):
        super().setUp()
        self.scripts = self.folder.parent / "scripts"
        self.scripts.mkdir()
        for name, text in (("report.js", SCRIPT), ("report.css", ".a { color: red; }"), ("built.txt", "report\n")):
            (self.scripts / name).write_text(text, encoding="utf-8")

    def page(self, *arguments, code=0):
        found = self.report("--no-charts", "--scripts", str(self.scripts), *arguments)
        self.assertEqual((found[0], found[2]), (code, ""))
        self.text = (self.folder / "report.html").read_text(encoding="utf-8")
        return Reader(self.text)


class Content(PageTest):
    def test_the_parts_stand_in_their_order_and_the_elements_are_closed(self):
        synthetic.write_run(self.folder, synthetic.thesis_records())
        page = self.page()
        self.assertEqual((page.open, page.is_broken), ([], False))
        self.assertEqual(re.findall(r'<section id="([\w-]+)"', self.text), ["verdict", "not-accepted", "charts", "tables", "organs", "provenance"])
        self.assertIn("Which order keeps more well-shaped tetrahedra?", self.text)

    def test_a_page_takes_the_place_of_a_page_and_of_nothing_else(self):
        with tempfile.TemporaryDirectory() as folder:
            page, records = pathlib.Path(folder) / "a.html", pathlib.Path(folder) / "records.jsonl"
            write_page.write_new_page(page, "<!doctype html>one")
            write_page.write_new_page(page, "<!doctype html>two")
            self.assertEqual(page.read_text(encoding="utf-8"), "<!doctype html>two")
            records.write_text("{}\n", encoding="utf-8")
            with self.assertRaisesRegex(BadRun, "expected a new file or an earlier page"):
                write_page.write_new_page(records, "<!doctype html>")
            self.assertEqual(records.read_text(encoding="utf-8"), "{}\n")

    def test_the_verdict_is_one_sentence_with_its_figures(self):
        synthetic.write_run(self.folder, synthetic.thesis_records())
        said = self.page().texts["verdict"]
        self.assertIn("The claim does not reproduce: hierarchical against sequential has -5.00 points", said)
        self.assertIn("+17.62 points was published, and 78 of 78 answers of sequential random are at least as good.", said)
        self.assertIn('class="verdict bad"', self.text)

    def test_what_was_not_accepted_is_said_with_its_reason(self):
        lines = [synthetic.record("kidney", "a", 70), synthetic.record("kidney", "b", 60, outcome="rejected", violations=["inverted_tets 3 > 0"])]
        synthetic.write_run(self.folder, lines, {})
        said = self.page().texts["not-accepted"]
        self.assertIn("1 of 2 answers was not accepted", said)
        self.assertIn("inverted_tets 3 > 0", said)
        synthetic.write_run(self.folder, lines[:1], {})
        self.assertIn("All 1 answers were accepted", self.page().texts["not-accepted"])

    def test_what_is_required_and_does_not_hold_stands_in_the_verdict(self):
        plan = {**synthetic.PLAN, "claim": {**synthetic.PLAN["claim"], "required": True}}
        synthetic.write_run(self.folder, synthetic.thesis_records(), plan)
        self.assertIn("Required, and does not hold: the claim that hierarchical beats sequential", self.page(code=1).texts["verdict"])

    def test_charts_have_their_intervals_units_and_cases(self):
        synthetic.write_run(self.folder, synthetic.thesis_records())
        charts = {data["title"]: data for name, block in self.page().blocks.items() if name and name.startswith("chart-") for data in [json.loads(block)]}
        timing = charts["Time of the methods"]
        self.assertEqual((timing["kind"], timing["x"]["unit"], timing["x"]["log"]), ("ranges", "ms", True))
        for low, middle, high in zip(*(timing["columns"][key] for key in ("time_low", "time", "time_high"))):
            self.assertTrue(low <= middle <= high)
        self.assertEqual(timing["columns"]["case"][0], "kidney/hierarchical/None")
        histogram = charts["Quality of the tetrahedra: kidney"]
        own = [value for value, label in zip(histogram["columns"]["percent"], histogram["columns"]["label"]) if label == "hierarchical"]
        self.assertAlmostEqual(sum(own), 100.0, 5)

    def test_the_command_that_repeats_it_names_the_plan_or_its_copy(self):
        for name, command in (("thesis_histograms", "./palpate run thesis_histograms"), ("../x", "./palpate run plan.yaml"), ("no such plan", "./palpate run plan.yaml")):
            synthetic.write_run(self.folder, [synthetic.record("kidney", "a", 70, plan=name)], {})
            self.assertIn(f"<code>{command}</code>", (self.page(), self.text)[1])

    def test_without_records_there_is_a_page_that_says_so(self):
        for contest in (None, "deform", "motion", "engine", "stability", "verify"):
            synthetic.write_run(self.folder, [], {"contest": contest} if contest else {})
            self.page()
            self.assertIn("There are no answers.", self.text)


class Sources(unittest.TestCase):
    def test_who_says_which_commit_it_is(self):
        commit = {"commit": "012345678"}
        self.assertEqual(facts.commit_text({**commit, "dirty": False}), "012345678")  # of a run made before sources were named
        self.assertEqual(facts.commit_text({**commit, "source": "checkout", "dirty": True}), "012345678, with changes that are not committed")
        self.assertIn("nobody can tell", facts.commit_text({**commit, "source": "archive", "dirty": None}))
        self.assertIn("by the installed package", facts.commit_text({**commit, "source": "package", "dirty": False}))
        self.assertIn("by the installed package, with changes", facts.commit_text({**commit, "source": "package", "dirty": True}))
        self.assertTrue(facts.commit_text({"commit": "unknown", "source": "unknown", "dirty": None}).startswith("unknown: "))


class Safety(PageTest):
    def evil(self):
        lines = synthetic.thesis_records(meshes=(EVIL,), seeds=2)
        lines.append(synthetic.record(EVIL, EVIL, 50, outcome="rejected", violations=[EVIL], message=EVIL))
        plan = json.loads(json.dumps({**synthetic.PLAN, "question": EVIL}))
        plan["claim"]["text"] = EVIL
        synthetic.write_run(self.folder, lines, plan)
        provenance = json.loads((self.folder / "provenance.json").read_text(encoding="utf-8"))
        (self.folder / "provenance.json").write_text(json.dumps({**provenance, "processor": EVIL, "commit": EVIL}), encoding="utf-8")
        (self.folder / "plan.yaml").write_text(EVIL, encoding="utf-8")

    def test_links_in_a_run_that_others_packed_lead_nowhere(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(seeds=2))
        elsewhere = self.folder.parent / "elsewhere"
        elsewhere.mkdir()
        theirs = elsewhere / "theirs.txt"
        theirs.write_text("nobody is to see this", encoding="utf-8")
        (self.folder / "plan.yaml").unlink(missing_ok=True)
        (self.folder / "plan.yaml").symlink_to(theirs)
        self.page()
        self.assertNotIn("nobody is to see this", (self.folder / "report.html").read_text(encoding="utf-8"))
        for name in ("tables", "charts"):
            shutil.rmtree(self.folder / name, ignore_errors=True)
            (self.folder / name).symlink_to(elsewhere)
            code, _, err = self.report()
            self.assertEqual((code, err.count("\n")), (2, 1), err)
            self.assertIn(f"{name}: expected a folder of the run, found a link", err)
            self.assertEqual([path.name for path in elsewhere.iterdir()], ["theirs.txt"])
            (self.folder / name).unlink()
        self.page()
        written = [*(self.folder / "tables").iterdir(), self.folder / "report.html"]
        for path in written:
            (path.parent / f"{path.name}.part").symlink_to(theirs)
        self.page()
        self.assertEqual(theirs.read_text(encoding="utf-8"), "nobody is to see this")
        self.assertFalse(any(path.is_symlink() for path in [*(self.folder / "tables").iterdir(), *self.folder.glob("*.part")]))

    def test_a_plan_that_is_a_pipe_is_not_waited_for(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(seeds=2))
        (self.folder / "plan.yaml").unlink(missing_ok=True)
        os.mkfifo(self.folder / "plan.yaml")
        self.page()

    def test_nothing_of_a_record_becomes_an_element(self):
        synthetic.write_run(self.folder, synthetic.thesis_records(meshes=("plain",), seeds=2))
        plain = self.page()
        self.evil()
        page = self.page()
        self.assertEqual((page.open, page.is_broken), ([], False))
        self.assertNotIn("b", page.tags)
        self.assertEqual(page.tags.count("script"), plain.tags.count("script"))
        for block in ("charts", "tables", "provenance", "not-accepted"):
            self.assertIn(EVIL, page.texts[block].replace("\\u003c", "<"), block)
        for name, text in page.blocks.items():
            if name:
                self.assertNotIn("<", text)
                json.loads(text)

    def test_markup_that_is_not_escaped_would_be_seen(self):
        reader = Reader(f"<p>{EVIL}</p>".replace("<!--", ""))
        self.assertIn("script", reader.tags)
        self.assertTrue(reader.is_broken)

    def test_a_script_cannot_end_its_own_element(self):
        synthetic.write_run(self.folder, [synthetic.record("kidney", "a", 70)], {})
        page = self.page()
        self.assertEqual((page.open, page.is_broken), ([], False))
        self.assertEqual(page.blocks[None].replace("\\/", "/").replace("\\!", "!"), SCRIPT)

    def test_nothing_is_fetched(self):
        synthetic.write_run(self.folder, synthetic.thesis_records())
        code, _, _ = self.report("--scripts", str(self.scripts))
        self.assertEqual(code, 0)
        text = (self.folder / "report.html").read_text(encoding="utf-8")
        for address in Reader(text).addresses:
            self.assertTrue(address.startswith(("#", "data:image/png;base64,", "charts/")), address)
        self.assertNotIn("http", text.lower().replace("http-equiv", ""))
        self.assertIn("default-src 'none'", text.replace("&#x27;", "'"))

    def test_the_same_run_gives_the_same_bytes_wherever_it_lies(self):
        found = []
        for name in ("one", "another"):
            self.folder = self.folder.parent / name
            synthetic.write_run(self.folder, synthetic.thesis_records())
            self.page()
            found.append(self.text)
        self.assertEqual(*found)


class WithoutScripts(PageTest):
    def test_the_page_says_so_and_has_pictures_and_tables(self):
        synthetic.write_run(self.folder, synthetic.thesis_records())
        code, _, err = self.report("--scripts", str(self.folder / "none"))
        self.assertEqual((code, err), (0, ""))
        text = (self.folder / "report.html").read_text(encoding="utf-8")
        page = Reader(text)
        self.assertIn("This page has no scripts", text)
        self.assertNotIn("script", page.tags)
        self.assertGreater(page.tags.count("img"), 2)
        self.assertGreater(page.tags.count("tr"), 10)


class Size(PageTest):
    def test_many_cases_are_cut_and_it_says_so(self):
        lines = [synthetic.record(f"mesh {k % 50}", f"label {k}", 70, kernel_s=0.01 + 1e-6 * k) for k in range(4500)]
        synthetic.write_run(self.folder, lines, {})
        self.page()
        self.assertLess(len(self.text), 5e6)
        self.assertIn("The first 4,000 of 4,500 points.", self.text)
        self.assertIn("of 4,500 rows; all are in tables/timing.csv", self.text)

    def test_repeats_are_aggregated(self):
        lines = [synthetic.record("kidney", "a", 70, repeat=k, kernel_s=0.01 + 1e-7 * k) for k in range(4000)]
        synthetic.write_run(self.folder, lines, {})
        self.page()
        self.assertLess(len(self.text), 100_000)

    def test_bodies_take_turns_until_the_room_is_full(self):
        tetrahedron = np.array([[0, 1, 2, 3]])
        bodies = [Body(f"{group}{k}", group, Mesh(np.random.default_rng([ord(group), k]).random((400, 3)), tetrahedron)) for group in "ab" for k in range(4)]
        one = bodies_json.size_of(bodies_json.mesh_data(bodies[0].mesh)) + bodies_json.size_of(bodies_json.body_data(bodies[0]))
        chosen = bodies_json.choose_bodies(bodies, room=round(4.5 * one))
        self.assertEqual([body["title"] for body in chosen.bodies], ["a0", "a1", "b0", "b1"])
        self.assertIn("4 of 8 meshes are left out", chosen.note)
        self.assertLessEqual(sum(map(bodies_json.size_of, [*chosen.meshes, *chosen.bodies])), 4.5 * one)

    def test_the_case_of_a_body_stands_in_the_page(self):
        bodies = [bodies_json.body_data(Body("a", "g", Bodies.MESH, case=case)) for case in ("", "kidney/a")]
        self.assertEqual(["case" in body for body in bodies], [False, True])
        self.assertEqual(bodies[1]["case"], "kidney/a")

    def test_a_mesh_that_several_bodies_share_stands_there_once(self):
        mesh = Mesh(np.random.default_rng(1).random((10, 3)), np.array([[0, 1, 2, 3], [4, 5, 6, 7]]))
        chosen = bodies_json.choose_bodies([Body(name, "g", mesh) for name in "abc"])
        self.assertEqual((len(chosen.meshes), [body["mesh"] for body in chosen.bodies]), (1, [0, 0, 0]))


class Bodies(unittest.TestCase):
    MESH = Mesh(np.random.default_rng(5).random((30, 3)), np.array([[0, 1, 2, 3], [26, 27, 28, 29]]))

    def unpack(self, data, kind):
        return np.frombuffer(zlib.decompress(base64.b64decode(data)), dtype=kind)

    def test_positions_and_indices_come_back(self):
        data = bodies_json.mesh_data(self.MESH)
        np.testing.assert_array_equal(self.unpack(data["positions"]["data"], "<f4"), self.MESH.points.astype("<f4").ravel())
        np.testing.assert_array_equal(self.unpack(data["indices"]["data"], "<u2"), self.MESH.tets.ravel())
        self.assertEqual(bodies_json.indices(np.array([[70000]]), 70001)["type"], "u32")

    def test_a_figure_comes_back_to_half_a_level_and_an_unknown_one_is_marked(self):
        values = np.array([0.0, 1.0, np.nan, 0.123, 0.777])
        levels = self.unpack(bodies_json.levels(values, 0.0, 1.0), np.uint8)
        self.assertEqual(levels[2], 255)
        known = np.isfinite(values)
        self.assertLessEqual(np.abs(levels[known] / 254 - values[known]).max(), 0.5 / 254 + 1e-12)

    def test_a_motion_comes_back_to_half_a_step_and_keeps_its_ends(self):
        moves = [(0.1 * k, np.full((30, 3), 1e-3 * k)) for k in range(200)]
        data = bodies_json.body_data(Body("a", "g", self.MESH, moves=moves))["motion"]
        frames = np.cumsum(self.unpack(data["data"], "<i2").reshape(len(data["times_s"]), 30, 3).astype(int), axis=0) * data["most"] / data["levels"]
        self.assertEqual((len(frames), data["of"], data["times_s"][0]), (bodies_json.MOST_FRAMES, 200, 0.0))
        self.assertAlmostEqual(data["times_s"][-1], 19.9)
        self.assertLessEqual(np.abs(frames[:, 0, 0] - 1e-2 * np.array(data["times_s"])).max(), 0.5 * data["most"] / data["levels"] + 1e-12)

    def test_figures_that_do_not_fit_the_mesh_are_refused(self):
        with self.assertRaisesRegex(ValueError, "expected 2 figures, found 3"):
            bodies_json.body_data(Body("a", "g", self.MESH, [Field("q", "", "tet", [1, 2, 3])]))


class Parts(unittest.TestCase):
    def test_numbers_are_short_in_a_cell_and_whole_beside_it(self):
        for value, digits, text in ((0.123456, 4, "0.1235"), (1234567, 4, "1,234,567"), (1.5e-7, 3, "1.50e-07"), (12.0, 4, "12"), (-0.5, 4, "-0.5"), (123456.7, 4, "123,500"), (12345678.9, 4, "1.235e+07"), (6386.5, 4, "6,386"),
                                    (1e-4, 3, "0.0001")):
            self.assertEqual(table_html.number_text(value, digits), text)
        shown = table_html.table_html(Table("t", [Column("a"), Column("b", "ms")], [["x", 0.123456], ["y", None], ["z", float("nan")]]), "t")
        self.assertIn('data-value="0.123456">0.1235</td>', shown)
        self.assertNotIn("nan", shown)
        self.assertEqual(re.findall(r'<th scope="col"( class="number")?>', shown), ["", ' class="number"'])  # heads stand over their figures

    def test_long_words_have_a_broad_cell_and_a_note_ends_with_a_full_stop(self):
        shown = table_html.table_html(Table("t", [Column("a"), Column("b")], [["x", "short"], ["y", "a reason " * 9]], note="No stop", file="t.csv"), "t")
        self.assertEqual(shown.count('class="long"'), 1)
        self.assertIn("No stop. Also in t.csv.", shown)

    def test_the_command_that_repeats_a_run_chooses_the_same_cases(self):
        for chosen, words in (({"only": ["kidney", "a b"]}, " --only kidney --only 'a b'"), ({"case": "x/y"}, " --case x/y"), (None, ""), (3, ""), ({"only": 3}, "")):
            self.assertEqual(facts.chosen_words(chosen), words)

    def test_what_is_no_number_is_null_in_data(self):
        self.assertEqual(markup.plain({"a": [float("nan"), float("inf"), 0.1 + 0.2, True, None]}), {"a": [None, None, 0.3, True, None]})

    def test_a_chart_has_only_the_columns_that_it_reads(self):
        chart = Chart("c", "points", Axis("x", "x"), Axis("y", "y"), [{"x": 1, "y": 2, "x_low": 0, "secret": 3, "note": ""}], shown=[Axis("z", "z")])
        self.assertEqual(chart_html.chart_data(chart)["columns"], {"x": [1], "y": [2], "x_low": [0]})


class Several(PageTest):
    def write(self, name, factor):
        folder = self.folder.parent / name / "run"
        lines = [synthetic.record("kidney", "a", 70, repeat=k, kernel_s=factor * (0.01 + 1e-5 * k), output_hash="x") for k in range(9)]
        return synthetic.write_run(folder, lines, {})

    def test_runs_are_held_against_the_first(self):
        runs = [self.write(name, factor) for name, factor in (("first", 1.0), ("same", 1.0), ("slow", 2.0))]
        out = self.folder.parent / "page.html"
        with contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(compare_page.main([*map(str, runs), "-o", str(out), "--scripts", str(self.scripts)]), 0)
        page = Reader(out.read_text(encoding="utf-8"))
        self.assertEqual((page.open, page.is_broken), ([], False))
        self.assertIn("most of all kernel_s of kidney/a/None, 2 times in slow/run.", page.texts["verdict"])
        chart = next(json.loads(block) for name, block in page.blocks.items() if name and name.startswith("chart-"))
        ratios = dict(zip(chart["columns"]["run"], chart["columns"]["ratio"]))
        self.assertAlmostEqual(ratios["slow/run"], 2.0, 6)
        self.assertAlmostEqual(ratios["same/run"], 1.0, 6)

    def test_a_single_run_is_bad_usage(self):
        with self.assertRaises(SystemExit), unittest.mock.patch("sys.stderr"):
            compare_page.main(["one", "-o", "x"])


if __name__ == "__main__":
    unittest.main()

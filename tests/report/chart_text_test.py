"""Every chart of the report, drawn with names that are hard on it: all text stays on the paper and as it is, and no title meets another."""

import sys
import unittest
import unittest.mock

import matplotlib.figure
import matplotlib.pyplot as plt
from matplotlib.text import Text
from support import ReportTest

import synthetic
from shared import chart_style

LONG = "a_mesh_of_a_body_with_a_name_that_somebody_made_up_to_be_long_and_longer"
HARD = "<script>$x_1$ & $\\alpha$%s{y}_"
SLACK = 1.5  # pixels: rounding of the renderer's boxes


def shown_texts(fig):
    """(text, its box) of everything written on a figure; of ticks those that are drawn."""
    renderer = fig.canvas.get_renderer()
    axes = [ax for ax in fig.axes if ax.get_visible()]
    ticks = {label for ax in fig.axes for axis in (ax.xaxis, ax.yaxis) for tick in [*axis.majorTicks, *axis.minorTicks] for label in (tick.label1, tick.label2)}
    drawn = [label for ax in axes if ax.axison for axis in (ax.xaxis, ax.yaxis) if axis.get_visible() for tick in axis._update_ticks()
             for label in (tick.label1, tick.label2)]
    texts = [text for text in fig.findobj(Text) if text not in ticks and (text.axes is None or text.axes in axes)]
    for text in [*texts, *drawn]:
        if text.get_visible() and text.get_text().strip():
            yield text, text.get_window_extent(renderer)


def off_the_paper(fig):
    """Texts that reach over the edge of the figure."""
    fig.draw_without_rendering()
    width, height = fig.bbox.width, fig.bbox.height
    return [text.get_text() for text, box in shown_texts(fig)
            if box.x0 < -SLACK or box.y0 < -SLACK or box.x1 > width + SLACK or box.y1 > height + SLACK]


def meeting_titles(fig):
    """Pairs of titles, of panels and of the figure, whose boxes meet."""
    fig.draw_without_rendering()
    renderer = fig.canvas.get_renderer()
    titles = [title for ax in fig.axes if ax.get_visible() for title in (ax.title, ax._left_title)] + ([fig._suptitle] if fig._suptitle else [])
    titles = [title for title in titles if title.get_text().strip()]
    boxes = [(title.get_text(), title.get_window_extent(renderer).padded(-SLACK)) for title in titles]
    return [(a, b) for place, (a, one) in enumerate(boxes) for b, other in boxes[:place] if one.overlaps(other)]


class ChartTest(ReportTest):
    def setUp(self):
        super().setUp()
        self.found = {}

        def savefig(fig, path, *_arguments, **_options):  # looks, and writes nothing but a name: drawing takes the time
            if path.suffix == ".png":
                said = [*(f"off the paper: {text}" for text in off_the_paper(fig)), *(f"titles meet: {pair}" for pair in meeting_titles(fig))]
                self.found.update({path.name: said} if said else {})
            path.write_bytes(b"drawn")

        patched = unittest.mock.patch.object(matplotlib.figure.Figure, "savefig", savefig)
        patched.start()
        self.addCleanup(patched.stop)

    def assert_good(self, lines, plan=None, least=1):
        synthetic.write_run(self.folder, lines, plan)
        code, out, err = self.report()
        self.assertEqual((code, err), (0, ""), out)
        self.assertGreaterEqual(len(self.charts()), least)
        self.assertEqual("\n".join(f"{name}: {text}" for name, said in self.found.items() for text in said), "")


def renamed(value, names):
    """Records or a plan with other names in them."""
    if isinstance(value, dict):
        return {key: renamed(item, names) for key, item in value.items()}
    if isinstance(value, list):
        return [renamed(item, names) for item in value]
    for old, new in names.items():
        value = value.replace(old, new) if isinstance(value, str) else value
    return value


class Charts(ChartTest):
    def test_the_charts_of_the_claim_with_long_and_hard_names(self):
        for names, seeds in (({"kidney": LONG}, 2), ({"hierarchical": LONG}, 7), ({"sequential": HARD, "bean": HARD}, 5)):
            with self.subTest(names=names, seeds=seeds):
                self.found.clear()
                lines = renamed(synthetic.thesis_records(seeds=seeds, repeats=2), names)
                self.assert_good(lines, renamed(synthetic.PLAN, names), 8)

    def test_a_question_of_many_words(self):
        self.assert_good(synthetic.thesis_records(seeds=3), {**synthetic.PLAN, "question": "Which of all these orders keeps more? " * 8}, 8)

    def test_the_charts_of_a_contest(self):
        lines = [synthetic.input_record("kidney", 90)]
        lines += [synthetic.answer(label, share, ratio, repeat=repeat, kernel_s=0.01 * (1 + k)) for ratio in (0.22, 0.5) for repeat in (0, 1)
                  for k, (label, share) in enumerate({"refined": 80, "cgal_1": 75, "cgal_2": 78}.items())]
        for names in ({"kidney": LONG, "cgal_1": HARD}, {"refined": LONG}):
            with self.subTest(names=names):
                self.found.clear()
                plan = {**synthetic.CONTEST, "charts": ["quality_time", "histograms", "overview", "timing"]}
                self.assert_good(renamed(lines, names), renamed(plan, names), 6)

    def test_the_charts_of_displacements_with_one_scene_and_with_many(self):
        scenes = ["bar_tension", "kidney_gravity", "liver_force", "a", "b"]
        for count, names in ((1, {}), (1, {"bar_tension": LONG, "isotropy": HARD}), (2, {"isotropy": LONG}), (5, {"bar_tension": LONG})):
            with self.subTest(count=count, names=names):
                self.found.clear()
                lines = [synthetic.reference_record(scene) for scene in scenes[:count]]
                lines += [synthetic.deformed(scene, label, error, repeat=repeat) for scene in scenes[:count] for repeat in (0, 1)
                          for label, error in (("isotropy", 0.05), ("p1", 0.08), ("thesis", 2.5))]
                plan = {**synthetic.DEFORM, "scenes": scenes[:count], "contestants": [{"label": name} for name in ("isotropy", "p1", "thesis")]}
                self.assert_good(renamed(lines, names), renamed(plan, names), 4)


class Spread(unittest.TestCase):
    def drawn(self, values):
        from simplify import charts
        fig, ax = plt.subplots()
        self.addCleanup(plt.close, fig)
        charts.draw_spread(ax, 0.0, values, "black")
        return ax.lines

    def test_a_box_stands_for_five_values_at_least(self):
        self.assertEqual(len(self.drawn([1.0])), 0)
        for count in (2, 4):
            line, ticks = self.drawn([float(k) for k in range(count)])
            self.assertEqual((list(ticks.get_xdata()), ticks.get_marker()), ([float(k) for k in range(count)], "|"))
        line, box = self.drawn([0.0, 1.0, 2.0, 3.0, 4.0])
        self.assertEqual((list(line.get_xdata()), list(box.get_xdata())), ([0.0, 4.0], [1.0, 3.0]))


class Style(unittest.TestCase):
    def setUp(self):
        self.enterContext(plt.rc_context(chart_style.STYLE))
        self.fig, self.axes = plt.subplots(1, 2, figsize=(5, 3))
        self.addCleanup(plt.close, self.fig)

    def test_dollars_are_no_mathematics(self):
        text = self.axes[0].set_title("$x_1$ and $y$")
        self.assertEqual(text._preprocess_math(text.get_text()), ("$x_1$ and $y$", False))

    def test_powers_are_written_without_mathematics(self):
        self.assertEqual([chart_style.power_text(value) for value in (0.01, 1.0, 1000.0, 1e6, 1e-7, 20.0, 0.0)],
                         ["0.01", "1", "1000", "10\u2076", "10\u207b\u2077", "", ""])
        self.axes[0].plot([1e2, 1e8], [1, 2])
        self.axes[0].set_xscale("log")
        chart_style.write_powers_plainly(self.fig)
        self.fig.canvas.draw()
        labels = [label.get_text() for label in self.axes[0].get_xticklabels()]
        self.assertIn("10\u2077", labels)
        self.assertFalse(any("$" in label for label in labels))

    def test_titles_that_meet_or_leave_the_paper_are_found_and_mended(self):
        for ax in self.axes:
            ax.set_title(LONG, loc="left", fontsize=10)
        self.assertEqual(len(off_the_paper(self.fig)), 2)
        self.assertEqual(len(meeting_titles(self.fig)), 1)
        chart_style.fit_titles(self.fig)
        self.assertEqual((off_the_paper(self.fig), meeting_titles(self.fig)), ([], []))
        self.assertEqual(self.axes[0].get_title(loc="left").replace("\n", ""), LONG)


if __name__ == "__main__":
    sys.exit(unittest.main())

"""The figures: drawn from metrics, as PNG and PDF, the same twice, legible at the width of a column, and of nothing as well."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from ovman.report.figures import agent, budget, canvas, charts, controls, coverage, difficulty, memory, sensitivity
from ovman.report.figures.canvas import COLUMN_IN, DPI, SMALL_PT
from ovman.report.paper_comparison.metrics import Metrics, arms_by_row
from ovman.report.paper_comparison.paper import PAPER, Paper
from tests.arms import CONFIG
from tests.episodes import DATA
from tests.report.paper_comparison.papers import metrics_of, papers_files, written_files

ROOT = Path(__file__).parents[2]
RULES = (ROOT / "workflow" / "rules" / "figures.smk").read_text(encoding="utf-8")
RELEASED = Metrics.load(
    [DATA / "metrics" / f"{name}.csv" for name in ("controls", "coverage", "sensitivity")],
    arms_by_row(CONFIG.comparisons, CONFIG.paper),
)
FIGURES = tuple(sorted(re.findall(r"(\w+)\.png", RULES.split("rule charts")[1])))
"""The names of the outputs of the rule."""


@pytest.fixture(scope="module")
def draw(tmp_path_factory) -> Callable[[], Path]:
    """Return a function that runs the stage and returns its folder."""
    metrics = written_files(tmp_path_factory.mktemp("metrics"), papers_files())

    def run() -> Path:
        directory = tmp_path_factory.mktemp("drawn")
        charts.run(metrics, PAPER, CONFIG, directory)
        return directory

    return run


@pytest.fixture(scope="module")
def drawn(draw) -> Path:
    return draw()


def width_px(picture: Path) -> int:
    return int.from_bytes(picture.read_bytes()[16:20], "big")


@pytest.mark.soak
def test_the_stage_draws_the_same_bytes_twice(draw, drawn):
    again = draw()
    for path in drawn.iterdir():
        assert path.read_bytes() == (again / path.name).read_bytes(), path.name


def test_the_stage_makes_what_the_rule_declares(drawn):
    assert {path.name for path in drawn.iterdir()} == {f"{name}.{form}" for name in FIGURES for form in ("png", "pdf")}
    for path in drawn.iterdir():
        assert path.read_bytes().startswith(b"\x89PNG" if path.suffix == ".png" else b"%PDF"), path.name
    assert {width_px(path) for path in drawn.glob("*.png")} == {round(COLUMN_IN * DPI)}


def test_every_figure_has_a_caption_and_is_released():
    for name in (*FIGURES, "relations"):
        caption = ROOT / "workflow" / "report" / f"{name}.rst"
        assert f'"../report/{name}.rst"' in RULES and len(caption.read_text().split()) > 8
    released = (ROOT / "Makefile").read_text()
    assert "cp results/figures/*.png results/figures/*.pdf docs/figures/" in released


def test_figures_of_nothing_are_drawn_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(canvas, "DPI", 40)
    charts.run([], PAPER, CONFIG, tmp_path)
    assert len(list(tmp_path.iterdir())) == 2 * len(FIGURES)


def texts(draw, tmp_path, monkeypatch) -> list:
    """The texts of a figure, with their sizes and extents, as they are when it is written."""
    from matplotlib.figure import Figure

    found = []

    def savefig(figure, *_, **__):
        figure.canvas.draw()
        from matplotlib.text import Text

        beyond = {
            tick.label1
            for axes in figure.axes
            for axis in (axes.xaxis, axes.yaxis)
            for tick in axis.get_major_ticks()
            if not min(axis.get_view_interval()) <= tick.get_loc() <= max(axis.get_view_interval())
        }
        for text in figure.findobj(Text):
            if text.get_text().strip() and text.get_visible() and text not in beyond:
                found.append((text.get_text(), text.get_fontsize(), text.get_window_extent(), figure.bbox.frozen()))

    monkeypatch.setattr(Figure, "savefig", savefig)
    draw(tmp_path / "figure.png")
    return found


def test_type_is_legible_in_print_and_stays_on_the_page(tmp_path, monkeypatch):
    metrics, paper = metrics_of(papers_files()), Paper.read()
    for draw in (
        agent.draw,
        lambda path: budget.draw(metrics, paper, CONFIG, path),
        lambda path: controls.draw(RELEASED, CONFIG, path),
        lambda path: coverage.draw(RELEASED, CONFIG, path),
        lambda path: difficulty.draw(metrics, paper, CONFIG, path),
        lambda path: memory.draw(metrics, paper, path),
        lambda path: sensitivity.draw(RELEASED, paper, path),
    ):
        found = texts(draw, tmp_path, monkeypatch)
        assert found
        for words, size, box, page in found:
            assert size >= SMALL_PT >= 6, words
            assert page.x0 - 1 <= box.x0 and box.x1 <= page.x1 + 1 and page.y0 - 1 <= box.y0 and box.y1 <= page.y1 + 1, words


def test_controls_has_the_released_rates_of_the_first_split_and_of_the_last(tmp_path, monkeypatch):
    rows = RELEASED.frame("controls")
    rows = rows[(rows["kind"] == "static") & (rows["relation"] == "all")]
    found = [words for words, *_ in texts(lambda path: controls.draw(RELEASED, CONFIG, path), tmp_path, monkeypatch)]
    for arm in ("joint", "two_visits", "depth_difference"):
        rates = rows[(rows["arm"] == arm) & rows["split"].isin(("main", "everyday"))]["rate"]
        assert len(rates) == 2 and {f"{float(rate):.3f}" for rate in rates} <= {*found}, arm
        assert CONFIG.arms[arm].system in found
    assert controls.CHANCE in found and CONFIG.arms["wrong_noun"].system not in found


def test_words_of_the_agent_lie_in_their_boxes_and_boxes_apart(tmp_path, monkeypatch):
    for one in agent.BOXES:
        for other in agent.BOXES:
            apart = one.right < other.left or other.right < one.left or one.top < other.bottom or other.top < one.bottom
            assert one is other or apart, (one.title, other.title)
    found = {words: box for words, _, box, _ in texts(agent.draw, tmp_path, monkeypatch)}
    inch = 100  # of matplotlib's default
    for box in agent.BOXES:
        for words in (box.title, box.line):
            extent = found[words]
            inside = box.left * inch <= extent.x0 and extent.x1 <= box.right * inch
            assert inside and box.bottom * inch <= extent.y0 + 1 and extent.y1 - 1 <= box.top * inch, words
    assert {box.title for box in agent.BOXES if box.fill == agent.NEW} == {"cross-visit association", "change relations"}
    left, bottom, width, height = agent.RETAINED
    inside = {
        box.title
        for box in agent.BOXES
        if left <= box.left and box.right <= left + width and bottom <= box.bottom and box.top <= bottom + height
    }
    assert inside == {agent.MAP_1.title, agent.MAP_2.title}

"""The figures: drawn from metrics as PNG and PDF, legible at the width of a column, and drawn without metrics, too."""

from __future__ import annotations

import pytest

from ovman.analysis.registry import drawn
from ovman.report.figures import CHARTS, agent, canvas, draw_charts, rates, sweeps
from ovman.report.figures.canvas import COLUMN_IN, DPI, SMALL_PT
from ovman.report.metrics import Metrics, name_arms
from tests.arms import CONFIG
from tests.episodes import DATA

FILES = [DATA / "metrics" / f"{name}.csv" for name in drawn(CONFIG)]
RELEASED = Metrics.load(FILES, name_arms(CONFIG.comparisons, CONFIG.paper))
FUNCTIONS = (
    *(agent.draw_agent, rates.draw_memory, rates.draw_difficulty, rates.draw_controls, rates.draw_coverage),
    *(sweeps.draw_budget, sweeps.draw_sensitivity),
)


def test_every_chart_is_drawn_as_png_and_pdf_at_the_width_of_a_column(tmp_path):
    draw_charts(FILES, CONFIG, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {f"{name}.{form}" for name in CHARTS for form in ("png", "pdf")}
    for path in tmp_path.iterdir():
        assert path.read_bytes().startswith(b"\x89PNG" if path.suffix == ".png" else b"%PDF"), path.name
    widths = {int.from_bytes(path.read_bytes()[16:20], "big") for path in tmp_path.glob("*.png")}
    assert widths == {round(COLUMN_IN * DPI)}


@pytest.mark.soak
def test_charts_have_the_same_bytes_twice(tmp_path):
    for turn in ("one", "other"):
        (tmp_path / turn).mkdir()
        draw_charts(FILES, CONFIG, tmp_path / turn)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "other" / path.name).read_bytes(), path.name


def test_charts_without_metrics_are_drawn_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(canvas, "DPI", 40)
    draw_charts([], CONFIG, tmp_path)
    assert len(list(tmp_path.iterdir())) == 2 * len(CHARTS)


def texts(draw, tmp_path, monkeypatch) -> list:
    """Return the texts of a figure with their sizes and extents, as they are when it is written."""
    from matplotlib.figure import Figure
    from matplotlib.text import Text

    found = []

    def savefig(figure, *_, **__):
        figure.canvas.draw()
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
    draw(RELEASED, CONFIG, tmp_path / "figure.png")
    return found


@pytest.mark.parametrize("draw", FUNCTIONS, ids=lambda draw: draw.__name__)
def test_type_is_legible_in_print_and_stays_on_the_page(draw, tmp_path, monkeypatch):
    found = texts(draw, tmp_path, monkeypatch)
    assert found
    for words, size, box, page in found:
        assert size >= SMALL_PT >= 6, words
        assert page.x0 - 1 <= box.x0 and box.x1 <= page.x1 + 1 and page.y0 - 1 <= box.y0 and box.y1 <= page.y1 + 1, words


def test_controls_have_the_released_rates_of_the_first_split_and_of_the_last(tmp_path, monkeypatch):
    rows = RELEASED.frame("controls")
    rows = rows[(rows["kind"] == "static") & (rows["relation"] == "all")]
    found = {words for words, *_ in texts(rates.draw_controls, tmp_path, monkeypatch)}
    for arm in ("joint", "two_visits", "depth_difference"):
        of_arm = rows[(rows["arm"] == arm) & rows["split"].isin(("main", "everyday"))]["rate"]
        assert len(of_arm) == 2 and {f"{float(rate):.3f}" for rate in of_arm} <= found, arm
        assert CONFIG.arms[arm].system in found
    assert rates.CHANCE in found and CONFIG.arms["wrong_noun"].system not in found

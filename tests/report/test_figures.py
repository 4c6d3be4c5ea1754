"""The figures: drawn from metrics as PNG and PDF, legible at the width of a column, and drawn without metrics, too."""

from __future__ import annotations

import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

from ovman.analysis.registry import DRAWN
from ovman.report.figures import CHARTS, canvas, draw_charts, rates
from ovman.report.metrics import Metrics
from tests.arms import CONFIG
from tests.episodes import DATA

FILES = [DATA / "metrics" / f"{name}.csv" for name in DRAWN]
DPI = 50


@pytest.fixture(scope="module")
def charts(tmp_path_factory):
    """Return the folder of all charts, and the texts of each with their sizes and extents."""
    folder, texts = tmp_path_factory.mktemp("charts"), {}
    save = Figure.savefig

    def save_and_read(figure, path, **options):
        save(figure, path, **options)
        beyond = {
            tick.label1
            for axes in figure.axes
            for axis in (axes.xaxis, axes.yaxis)
            for tick in axis.get_major_ticks()
            if not min(axis.get_view_interval()) <= tick.get_loc() <= max(axis.get_view_interval())
        }
        shown = [one for one in figure.findobj(Text) if one.get_text().strip() and one.get_visible() and one not in beyond]
        texts[path.stem] = [(one.get_text(), one.get_fontsize(), one.get_window_extent(), figure.bbox.frozen()) for one in shown]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Figure, "savefig", save_and_read)
        patched.setattr(canvas, "DPI", DPI)
        draw_charts(FILES, CONFIG, folder)
    return folder, texts


def test_every_chart_is_drawn_as_png_and_pdf_at_the_width_of_a_column(charts):
    folder, _ = charts
    assert {path.name for path in folder.iterdir()} == {f"{name}.{form}" for name in CHARTS for form in ("png", "pdf")}
    for path in folder.glob("*.png"):
        assert int.from_bytes(path.read_bytes()[16:20], "big") == round(canvas.COLUMN_IN * DPI), path.name


@pytest.mark.parametrize("name", CHARTS)
def test_type_is_legible_in_print_and_stays_on_the_page(name, charts):
    found = charts[1][name]
    assert found
    for words, size, box, page in found:
        assert size >= canvas.SMALL_PT >= 6, words
        assert page.x0 - 1 <= box.x0 and box.x1 <= page.x1 + 1 and page.y0 - 1 <= box.y0 and box.y1 <= page.y1 + 1, words


def test_controls_have_the_released_rates_of_the_first_split_and_of_the_last(charts):
    released = Metrics.load(FILES, {})
    found = {words for words, *_ in charts[1]["controls"]}
    for arm in ("joint", "two_visits", "depth_difference"):
        of_arm = [f"{released.rows('controls', kind='static', arm=arm, split=split).one()}" for split in ("main", "everyday")]
        assert {*of_arm} <= found and CONFIG.arms[arm].system in found
    assert rates.CHANCE in found and CONFIG.arms["wrong_noun"].system not in found


def test_charts_without_metrics_are_drawn_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(canvas, "DPI", DPI)
    draw_charts([], CONFIG, tmp_path)
    assert len(list(tmp_path.iterdir())) == 2 * len(CHARTS)


@pytest.mark.soak
def test_charts_have_the_same_bytes_twice(tmp_path):
    for turn in ("one", "other"):
        (tmp_path / turn).mkdir()
        draw_charts(FILES, CONFIG, tmp_path / turn)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "other" / path.name).read_bytes(), path.name

"""The figures: drawn from metrics as PNG and PDF in legible type, and drawn without metrics, too."""

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
DPI = 30


@pytest.fixture(scope="module")
def charts(tmp_path_factory):
    """Return the folder of all charts, and the sizes of the texts of each by what they say."""
    folder, texts, save = tmp_path_factory.mktemp("charts"), {}, Figure.savefig

    def save_and_read(figure, path, **options):
        if path.suffix == ".png" or len(texts) == 1:  # one PDF is enough: its fonts take longer than its drawing
            save(figure, path, **options)
        path.touch()
        texts[path.stem] = {one.get_text(): one.get_fontsize() for one in figure.findobj(Text) if one.get_visible()}

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Figure, "savefig", save_and_read)
        patched.setattr(canvas, "DPI", DPI)
        draw_charts(FILES, CONFIG, folder)
    return folder, texts


def test_every_chart_is_drawn_as_png_and_pdf_in_legible_type(charts):
    folder, texts = charts
    assert {path.name for path in folder.iterdir()} == {f"{name}.{form}" for name in CHARTS for form in ("png", "pdf")}
    assert min(size for of_chart in texts.values() for words, size in of_chart.items() if words.strip()) >= canvas.SMALL_PT >= 6


def test_controls_have_the_released_rates_of_the_first_split_and_of_the_last(charts):
    released, found = Metrics.load(FILES, {}), {*charts[1]["controls"]}
    for arm in ("joint", "two_visits", "depth_difference"):
        of_arm = [f"{released.rows('controls', kind='static', arm=arm, split=split).one()}" for split in ("main", "everyday")]
        assert {*of_arm} <= found and CONFIG.arms[arm].system in found
    assert rates.CHANCE in found and CONFIG.arms["wrong_noun"].system not in found


def test_charts_without_metrics_are_drawn_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(Figure, "savefig", lambda figure, path, **_: path.touch())
    draw_charts([], CONFIG, tmp_path)
    assert len(list(tmp_path.iterdir())) == 2 * len(CHARTS)
